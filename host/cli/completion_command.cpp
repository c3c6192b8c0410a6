// regulus completion and regulus man: what shells and man show, from the declarations of the command line.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

#include "base/standard_streams.hpp"
#include "cli/command_tree.hpp"
#include "cli/commands.hpp"
#include "cli/completion.hpp"
#include "cli/manual.hpp"
#include "cli/output_writer.hpp"
#include "cli/validators.hpp"

namespace regulus::cli {

namespace {

void say_completion(const CLI::App& app, const std::string& shell) {
  const CommandEntry root = describe_commands(app);
  say_text(shell == "bash"  ? bash_completion(root)
           : shell == "zsh" ? zsh_completion(root)
                            : fish_completion(root));
}

void write_manual(const CLI::App& app, const std::filesystem::path& folder) {
  const CommandEntry root = describe_commands(app);
  std::filesystem::create_directories(folder);
  OutputWriter writer;
  for (const CommandEntry* entry : all_commands(root))
    writer.write(folder / manual_name(*entry), [&] { return manual_page(*entry, root); });
  writer.throw_failures();
}

}  // namespace

void add_completion_commands(CLI::App& app) {
  const auto shell = std::make_shared<std::string>();
  CLI::App* completion =
      app.add_subcommand("completion", "Print a script that lets a shell complete this command line");
  completion->add_option("SHELL", *shell, "The shell")
      ->type_name("bash|zsh|fish")
      ->required()
      ->check(one_of({"bash", "zsh", "fish"}));
  completion->callback([&app, shell] { say_completion(app, *shell); });

  const auto folder = std::make_shared<std::string>();
  CLI::App* manual = app.add_subcommand("man", "Write the manual pages of all commands");
  manual->add_option("FOLDER", *folder, "Where to write them, one file each")
      ->type_name("FOLDER")
      ->required();
  manual->callback([&app, folder] { write_manual(app, *folder); });
}

}  // namespace regulus::cli
