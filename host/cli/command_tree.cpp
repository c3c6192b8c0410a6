#include "cli/command_tree.hpp"

#include <algorithm>
#include <sstream>

#include "cli/help.hpp"

namespace regulus::cli {

namespace {

// "a|b|c" where each is a word; what stands for a value, as in cache:M or METRES, is no choice.
std::vector<std::string> choices_of(const std::string& type) {
  std::vector<std::string> choices;
  std::istringstream stream(type);
  const auto is_plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; };
  for (std::string choice; std::getline(stream, choice, '|');)
    if (!choice.empty() && std::ranges::all_of(choice, is_plain)) choices.push_back(choice);
  return type.find('|') == std::string::npos ? std::vector<std::string>() : choices;
}

ValueKind kind_of(const std::string& type) {
  if (type == "FILE" || type == "SCENE" || type == "REFERENCE" || type == "IMAGE") return ValueKind::File;
  return type == "FOLDER" ? ValueKind::Folder : ValueKind::Text;
}

OptionEntry describe_option(const CLI::Option& option, const HelpFormatter& help) {
  OptionEntry entry;
  for (const std::string& name : option.get_snames()) entry.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) entry.names.push_back("--" + name);
  entry.is_argument = entry.names.empty();
  if (entry.is_argument) entry.names.push_back(option.get_name(true));
  if (option.get_items_expected_max() > 0) {
    entry.value = option.get_type_name();
    entry.kind = kind_of(entry.value);
    entry.choices = choices_of(entry.value);
  }
  entry.repeats = option.get_expected_max() > 1;
  entry.description = help.make_option_desc(&option);
  std::ranges::replace(entry.description, '\n', ' ');
  entry.topic = option.get_group();
  return entry;
}

CommandEntry describe(const CLI::App& app, const std::vector<std::string>& path) {
  CommandEntry entry{.path = path, .description = app.get_description(), .options = {}, .commands = {}};
  const HelpFormatter help;
  for (const CLI::Option* option : app.get_options())
    if (!option->get_group().empty()) entry.options.push_back(describe_option(*option, help));
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    std::vector<std::string> below = path;
    below.push_back(command->get_name());
    entry.commands.push_back(describe(*command, below));
  }
  return entry;
}

void collect(const CommandEntry& entry, std::vector<const CommandEntry*>& all) {
  all.push_back(&entry);
  for (const CommandEntry& command : entry.commands) collect(command, all);
}

}  // namespace

std::string CommandEntry::name() const {
  std::string name;
  for (const std::string& word : path) name += (name.empty() ? "" : " ") + word;
  return name;
}

CommandEntry describe_commands(const CLI::App& app) {
  return describe(app, {});
}

std::vector<const CommandEntry*> all_commands(const CommandEntry& root) {
  std::vector<const CommandEntry*> all;
  collect(root, all);
  return all;
}

}  // namespace regulus::cli
