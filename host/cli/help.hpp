// How `--help` looks.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace regulus::cli {

/// Says defaults, and what an option cannot be without or together with, in words after its description. Set
/// it on the application before its commands are added: they inherit it.
class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter();
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_desc(const CLI::Option* option) const override;
};

}  // namespace regulus::cli
