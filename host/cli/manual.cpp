#include "cli/manual.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/version.hpp"

namespace regulus::cli {

namespace {

/// Text as roff shows it: a dash that can be copied, a backslash that is one, no line that is a request.
std::string roff(const std::string& text) {
  std::string escaped;
  bool starts_line = true;
  for (const char letter : text) {
    if (starts_line && (letter == '.' || letter == '\'')) escaped += "\\&";
    if (letter == '\\')
      escaped += "\\e";
    else if (letter == '-')
      escaped += "\\-";
    else
      escaped += letter;
    starts_line = letter == '\n';
  }
  return escaped;
}

std::string page_name(const CommandEntry& entry) {
  std::string name = "regulus";
  for (const std::string& word : entry.path) name += "-" + word;
  return name;
}

std::string synopsis(const CommandEntry& entry) {
  std::string line = "\\fBregulus";
  for (const std::string& word : entry.path) line += " " + roff(word);
  line += "\\fR";
  if (!entry.commands.empty()) line += " \\fICOMMAND\\fR";
  line += " [\\fIoptions\\fR]";
  for (const OptionEntry& option : entry.options)
    if (option.is_argument)
      line += fmt::format(" \\fI{}\\fR{}", roff(option.value.empty() ? option.names.front() : option.value),
                          option.repeats ? " ..." : "");
  return line + "\n";
}

std::string option_paragraph(const OptionEntry& option) {
  std::string names;
  for (const std::string& name : option.names) {
    names += fmt::format("{}\\fB{}\\fR", names.empty() ? "" : ", ", roff(name));
  }
  if (!option.value.empty()) names += fmt::format(" \\fI{}\\fR", roff(option.value));
  return fmt::format(".TP\n{}\n{}\n", names, roff(option.description));
}

std::string options_by_topic(const CommandEntry& entry) {
  std::string text, topic;
  for (const OptionEntry& option : entry.options) {
    if (option.is_argument) continue;
    if (text.empty()) text = ".SH OPTIONS\n";
    if (option.topic != topic && option.topic != "Options")
      text += fmt::format(".SS {}\n", roff(option.topic));
    topic = option.topic;
    text += option_paragraph(option);
  }
  return text;
}

std::string see_also(const CommandEntry& entry, const CommandEntry& root) {
  std::string list;
  for (const CommandEntry* other : all_commands(root))
    if (other->path != entry.path && other->path.size() <= 1)
      list += fmt::format("{}\\fB{}\\fR(1)", list.empty() ? "" : ", ", roff(page_name(*other)));
  return ".SH SEE ALSO\n" + list + "\n";
}

}  // namespace

std::string manual_name(const CommandEntry& entry) {
  return page_name(entry) + ".1";
}

std::string manual_page(const CommandEntry& entry, const CommandEntry& root) {
  std::string page =
      fmt::format(".TH {} 1 \"\" \"regulus {}\" \"Regulus\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n",
                  roff(page_name(entry)), VERSION, roff(page_name(entry)), roff(entry.description));
  page += synopsis(entry);
  if (!entry.commands.empty()) {
    page += ".SH COMMANDS\n";
    for (const CommandEntry& command : entry.commands)
      page += fmt::format(".TP\n\\fB{}\\fR\n{}\n", roff(command.path.back()), roff(command.description));
  }
  std::string arguments;
  for (const OptionEntry& option : entry.options)
    if (option.is_argument) arguments += option_paragraph(option);
  if (!arguments.empty()) page += ".SH ARGUMENTS\n" + arguments;
  page += options_by_topic(entry);
  page +=
      ".SH EXIT STATUS\n0 done, 1 failed, 2 bad usage, 3 bad scene or image, 4 no usable device or device "
      "lost, 130 interrupted.\n";
  return page + see_also(entry, root);
}

}  // namespace regulus::cli
