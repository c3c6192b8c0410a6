#include "cli/output_writer.hpp"

#include <fmt/format.h>

#include <new>

#include "base/atomic_file.hpp"
#include "base/error.hpp"

namespace regulus::cli {

void OutputWriter::write(const std::filesystem::path& file, const std::function<std::string()>& encode) {
  std::string bytes, failure;
  try {
    bytes = encode();
    write_file_atomically(file, bytes);
    return;
  } catch (const Error& error) {
    failure = error.what();
  } catch (const std::bad_alloc&) {
    failure = fmt::format("{}: not enough memory to encode it", file.string());
  }
  const std::filesystem::path rescued =
      bytes.empty() ? std::filesystem::path() : write_to_temporary_folder(file, bytes);
  if (!rescued.empty()) failure += fmt::format("; it is in {} instead", rescued.string());
  failures_ += (failures_.empty() ? "" : "; ") + failure;
}

void OutputWriter::throw_failures() const {
  if (has_failed()) throw Error(ErrorCode::Failed, failures_);
}

}  // namespace regulus::cli
