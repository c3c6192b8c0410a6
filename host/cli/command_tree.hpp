// What the command line understands, as plain data: from the declarations that also parse it and print its
// help.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace regulus::cli {

/// What an option takes.
enum class ValueKind { None, Text, File, Folder };

/// An option or an argument without a name.
struct OptionEntry {
  std::vector<std::string> names;  ///< with their dashes, short ones first; of an argument its own name
  bool is_argument = false;
  bool repeats = false;  ///< may be given several times
  ValueKind kind = ValueKind::None;
  std::string value;                 ///< what help calls the value; empty: none
  std::vector<std::string> choices;  ///< the values, where they are few words
  std::string description;           ///< one paragraph, with defaults
  std::string topic;
};

struct CommandEntry {
  std::vector<std::string> path;  ///< words of it without "regulus"; empty: the program
  std::string description;
  std::vector<OptionEntry> options;  ///< those that help shows
  std::vector<CommandEntry> commands;

  std::string name() const;  ///< the words with spaces between them
};

/// Everything below `app`. Call when all is declared.
CommandEntry describe_commands(const CLI::App& app);

/// The command and all below it, parents first.
std::vector<const CommandEntry*> all_commands(const CommandEntry& root);

}  // namespace regulus::cli
