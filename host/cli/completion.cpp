#include "cli/completion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/shell_words.hpp"

namespace regulus::cli {

namespace {

std::string joined(const std::vector<std::string>& words, const char* between = " ") {
  return fmt::format("{}", fmt::join(words, between));
}

std::vector<std::string> names_of_commands(const CommandEntry& entry) {
  std::vector<std::string> names;
  for (const CommandEntry& command : entry.commands) names.push_back(command.path.back());
  return names;
}

std::vector<std::string> option_names(const CommandEntry& entry) {
  std::vector<std::string> names;
  for (const OptionEntry& option : entry.options)
    if (!option.is_argument) names.insert(names.end(), option.names.begin(), option.names.end());
  return names;
}

/// "'render -o' | 'render --output'": the patterns of a case for a command and any of an option's names.
std::string case_patterns(const CommandEntry& entry, const OptionEntry& option) {
  std::vector<std::string> patterns;
  patterns.reserve(option.names.size());
  for (const std::string& name : option.names) patterns.push_back(shell_word(entry.name() + " " + name));
  return joined(patterns, " | ");
}

/// A description in a list of zsh's _arguments or _describe, where these end it.
std::string zsh_text(const std::string& text) {
  std::string escaped;
  for (const char letter : text) {
    if (letter == '[' || letter == ']' || letter == ':' || letter == '\\') escaped += '\\';
    escaped += letter;
  }
  return escaped;
}

std::string zsh_action(const OptionEntry& option) {
  if (option.kind == ValueKind::None) return "";
  const std::string name = zsh_text(option.value.empty() ? "value" : option.value);
  if (!option.choices.empty()) return fmt::format(":{}:({})", name, joined(option.choices));
  return fmt::format(":{}:{}", name,
                     option.kind == ValueKind::File     ? "_files"
                     : option.kind == ValueKind::Folder ? "_files -/"
                                                        : "");
}

/// The words for _arguments of a command without commands below it, or of the options of one with them.
std::string zsh_arguments(const CommandEntry& entry) {
  std::string words;
  for (const OptionEntry& option : entry.options) {
    if (option.is_argument) {
      words += " " + shell_word((option.repeats ? "*" : "") + zsh_action(option));
      continue;
    }
    for (const std::string& name : option.names) {
      const bool takes_value = option.kind != ValueKind::None;
      const std::string suffix = !takes_value ? "" : name.starts_with("--") ? "=" : "+";
      words += " \\\n    " + shell_word(fmt::format("{}{}{}[{}]{}", option.repeats ? "*" : "", name, suffix,
                                                    zsh_text(option.description), zsh_action(option)));
    }
  }
  return words;
}

std::string zsh_function(const CommandEntry& entry) {
  return "_regulus" + (entry.path.empty() ? "" : "_" + joined(entry.path, "_"));
}

}  // namespace

std::string bash_completion(const CommandEntry& root) {
  std::string descend, options, commands, values;
  for (const CommandEntry* entry : all_commands(root)) {
    const std::string name = shell_word(entry->name());
    if (!entry->path.empty()) descend += (descend.empty() ? "" : " | ") + name;
    options += fmt::format("    {}) options={} ;;\n", name, shell_word(joined(option_names(*entry))));
    if (!entry->commands.empty())
      commands +=
          fmt::format("    {}) commands={} ;;\n", name, shell_word(joined(names_of_commands(*entry))));
    for (const OptionEntry& option : entry->options) {
      if (option.is_argument || option.kind == ValueKind::None) continue;
      const std::string action = !option.choices.empty()          ? "-W " + shell_word(joined(option.choices))
                                 : option.kind == ValueKind::File ? "-f"
                                 : option.kind == ValueKind::Folder ? "-d"
                                                                    : "-W ''";
      values += fmt::format("    {}) _regulus_reply {} -- \"$word\"; return ;;\n",
                            case_patterns(*entry, option), action);
    }
  }
  return fmt::format(R"sh(# Completion of regulus for bash; made by `regulus completion bash`.
_regulus_reply() {{
  local line
  COMPREPLY=()
  [[ $1 == -W ]] || compopt -o filenames 2>/dev/null
  while IFS= read -r line; do COMPREPLY+=("$line"); done < <(compgen "$@")
}}

_regulus() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} command='' next options='' commands=''
  # "--name=value" arrives as three words.
  if [[ $word == = ]]; then
    word=''
  elif [[ $before == = ]]; then
    before=${{COMP_WORDS[COMP_CWORD - 2]}}
  fi
  for next in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case ${{command:+$command }}$next in
    {}) command=${{command:+$command }}$next ;;
    *) break ;;
    esac
  done
  case "$command $before" in
{}  esac
  case $command in
{}  esac
  case $command in
{}  esac
  if [[ $word == -* ]]; then
    _regulus_reply -W "$options" -- "$word"
  elif [[ $commands ]]; then
    _regulus_reply -W "$commands" -- "$word"
  else
    _regulus_reply -f -- "$word"
  fi
}}
complete -F _regulus regulus
)sh",
                     descend, values, options, commands);
}

std::string zsh_completion(const CommandEntry& root) {
  std::string script =
      "#compdef regulus\n# Completion of regulus for zsh; made by `regulus completion zsh`.\n\n";
  for (const CommandEntry* entry : all_commands(root)) {
    script += zsh_function(*entry) + "() {\n";
    if (entry->commands.empty()) {
      script += "  _arguments -s -S" + zsh_arguments(*entry) + "\n}\n\n";
      continue;
    }
    script += "  local line state\n  _arguments -C" + zsh_arguments(*entry) +
              " \\\n    '1:command:->commands' '*::argument:->arguments'\n  case $state in\n  commands)\n"
              "    local -a commands=(";
    for (const CommandEntry& command : entry->commands)
      script += "\n      " + shell_word(command.path.back() + ":" + zsh_text(command.description));
    script += ")\n    _describe command commands ;;\n  arguments)\n    case $line[1] in\n";
    for (const CommandEntry& command : entry->commands)
      script += fmt::format("    {}) {} ;;\n", command.path.back(), zsh_function(command));
    script += "    esac ;;\n  esac\n}\n\n";
  }
  return script + "_regulus \"$@\"\n";
}

std::string fish_completion(const CommandEntry& root) {
  std::string script = "# Completion of regulus for fish; made by `regulus completion fish`.\n";
  // In single quotes fish knows two escapes, \' and \\.
  const auto quoted = [](const std::string& text) {
    std::string word = "'";
    for (const char letter : text) {
      if (letter == '\'' || letter == '\\') word += '\\';
      word += letter;
    }
    return word + "'";
  };
  for (const CommandEntry* entry : all_commands(root)) {
    std::vector<std::string> conditions;
    for (const std::string& word : entry->path) conditions.push_back("__fish_seen_subcommand_from " + word);
    if (!entry->commands.empty())
      conditions.push_back("not __fish_seen_subcommand_from " + joined(names_of_commands(*entry)));
    const std::string when = quoted(joined(conditions, "; and "));
    for (const CommandEntry& command : entry->commands)
      script += fmt::format("complete -c regulus -n {} -f -a {} -d {}\n", when, command.path.back(),
                            quoted(command.description));
    for (const OptionEntry& option : entry->options) {
      if (option.is_argument) continue;
      script += fmt::format("complete -c regulus -n {}", when);
      for (const std::string& name : option.names)
        script += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (!option.choices.empty())
        script += fmt::format(" -x -a {}", quoted(joined(option.choices)));
      else if (option.kind == ValueKind::Text)
        script += " -x";
      else if (option.kind != ValueKind::None)
        script += " -r -F";
      script += fmt::format(" -d {}\n", quoted(option.description));
    }
  }
  return script;
}

}  // namespace regulus::cli
