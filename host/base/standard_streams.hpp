// stdin, stdout and stderr, any of which may be closed, full or gone.
#pragma once

#include <fmt/format.h>

#include <string_view>

namespace regulus {

/// Call first. Fills those of the descriptors 0 to 2 that are closed, so that no file that is opened later
/// gets the number that messages go to; writing to them still fails. Makes a reader that went away, and a
/// limit on the size of files, errors of the write instead of the end of the process.
void prepare_streams();

/// Puts text on stdout. A failure does not end what is going on; finish_stdout() knows of it.
void say_text(std::string_view text);

/// The same, formatted as fmt::print does.
template <typename... Values>
void say(fmt::format_string<Values...> format, Values&&... values) {
  say_text(fmt::format(format, std::forward<Values>(values)...));
}

/// What was said is shown at once.
void flush_stdout();

/// Call last. @throws regulus::Error (Failed) if something that was said could not be written, unless there
/// is nobody to read it: the pipe's reader or the terminal went away.
void finish_stdout();

/// stdout is not what this command is for: finish_stdout() has no complaint.
void forgive_stdout();

}  // namespace regulus
