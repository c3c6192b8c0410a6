#include "cli/output_guard.hpp"

#include <fmt/format.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/file_identity.hpp"
#include "scene/references.hpp"

namespace regulus::cli {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail(const std::string& option, const fs::path& file, const std::string& what) {
  throw Error(ErrorCode::BadUsage, fmt::format("{} {}: is {}, which it would replace; name another file",
                                               option, file.string(), what));
}

void require_place(const std::string& option, const fs::path& file) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw Error(ErrorCode::Failed, fmt::format("{} {}: {} is not a folder; create it first", option,
                                               file.string(), folder.string()));
  if (fs::is_directory(file, error))
    throw Error(ErrorCode::Failed, fmt::format("{} {}: is a folder; name a file", option, file.string()));
  try {
    require_writable(file);
  } catch (const Error& problem) {
    throw Error(problem.code(), fmt::format("{} {}", option, problem.what()));
  }
}

}  // namespace

OutputGuard::Identity OutputGuard::identify(const fs::path& file) {
  fs::path target = file;
  try {
    target = follow_links(file);
  } catch (const Error&) {  // links in a circle lead to no file that could be lost
  }
  if (const auto found = file_identity(target)) return {found->first, found->second, {}};
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  if (const auto found = file_identity(folder))
    return {found->first, found->second, target.filename().string()};
  std::error_code error;
  return {0, 0, fs::absolute(target, error).lexically_normal().string()};
}

void OutputGuard::add_input(const fs::path& file, const std::string& what) {
  if (is_device_or_pipe(file)) return;
  const Identity identity = identify(file);
  const auto output = outputs_.find(identity);
  if (output != outputs_.end()) fail(output->second.option, output->second.file, what);
  inputs_.emplace(identity, what);
}

void OutputGuard::add_scene(const fs::path& scene_file) {
  add_input(scene_file, "the scene");
  for (const fs::path& file : scene::referenced_files(scene_file))
    add_input(file, fmt::format("a file that {} refers to", scene_file.string()));
}

void OutputGuard::add_output(const std::string& option, const fs::path& file) {
  unchecked_.push_back({option, file});
  if (is_device_or_pipe(file)) return;
  const Identity identity = identify(file);
  const auto input = inputs_.find(identity);
  if (input != inputs_.end()) fail(option, file, input->second);
  const auto [output, is_new] = outputs_.emplace(identity, Output{option, file});
  if (!is_new)
    throw Error(ErrorCode::BadUsage, fmt::format("{} {}: is the file of {} as well; name another one", option,
                                                 file.string(), output->second.option));
}

void OutputGuard::require_places() {
  for (const Output& output : unchecked_) require_place(output.option, output.file);
  unchecked_.clear();
}

}  // namespace regulus::cli
