#include "cli/arguments.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/near_names.hpp"

namespace regulus::cli {

namespace {

const CLI::App* find_subcommand(const CLI::App& app, const std::string& name) {
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    if (command->get_name() == name) return command;
  return nullptr;
}

/// The command that the first words name, as far as they do.
const CLI::App& named_command(const CLI::App& app, const std::vector<std::string>& words) {
  const CLI::App* command = &app;
  for (const std::string& word : words) {
    const CLI::App* next = find_subcommand(*command, word);
    if (next == nullptr) break;
    command = next;
  }
  return *command;
}

bool awaits_value(const CLI::App& command, const std::string& word) {
  if (!word.starts_with("-") || word.find('=') != std::string::npos) return false;
  const CLI::Option* option = command.get_option_no_throw(word);
  return option != nullptr && option->get_items_expected_min() > 0;
}

/// "--output=x" for "-o=x".
std::string with_long_name(const CLI::App& command, const std::string& word) {
  const bool is_short = word.size() > 2 && word[0] == '-' && word[1] != '-' && word[2] == '=';
  const CLI::Option* option = is_short ? command.get_option_no_throw(word.substr(0, 2)) : nullptr;
  if (option == nullptr || option->get_lnames().empty()) return word;
  return "--" + option->get_lnames().front() + word.substr(2);
}

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

}  // namespace

void refuse_empty_values(CLI::App& app) {
  const auto is_not_empty = [](const std::string& text) {
    return text.empty() ? std::string("the value is empty") : std::string();
  };
  for (CLI::Option* option : app.get_options([](const CLI::Option*) { return true; }))
    if (option->get_items_expected_min() > 0) option->check(is_not_empty);
  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    refuse_empty_values(*command);
}

std::vector<std::string> read_arguments(const CLI::App& app, int argc, char** argv) {
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  const CLI::App& command = named_command(app, words);
  for (size_t i = 0; i < words.size() && words[i] != "--"; ++i)
    if (i == 0 || !awaits_value(command, words[i - 1])) words[i] = with_long_name(command, words[i]);
  return words;
}

std::string describe_usage_error(const CLI::App& app, const std::vector<std::string>& arguments,
                                 const CLI::ParseError& error) {
  const CLI::App& command = named_command(app, arguments);
  const bool wants_command = !command_names(command).empty();
  if (wants_command) {
    const auto word = std::ranges::find_if(arguments, [&](const std::string& argument) {
      return !argument.starts_with("-") && &command != find_subcommand(app, argument);
    });
    if (word != arguments.end())
      return fmt::format("{} is not a command{}", *word, suggest(*word, command_names(command)));
  }
  std::string message = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) == nullptr) return message;
  for (const std::string& word : app.remaining(true)) {
    if (!word.starts_with("--")) continue;
    return fmt::format("{} is not an option{}", word,
                       suggest(word.substr(0, word.find('=')), option_names(command)));
  }
  return message;
}

}  // namespace regulus::cli
