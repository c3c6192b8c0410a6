// A library that is looked for when the program runs.
#pragma once

#include <dlfcn.h>

#include <memory>
#include <string>

namespace regulus {

/// Loaded until the last copy is gone.
class SharedLibrary {
 public:
  /// @param name a file with its path, or a name that the system looks for in its folders
  explicit SharedLibrary(const std::string& name) {
    void* handle = ::dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle != nullptr) {
      handle_ = std::shared_ptr<void>(handle, [](void* library) { ::dlclose(library); });
    } else if (const char* problem = ::dlerror()) {
      problem_ = problem;
    }
  }

  bool is_loaded() const { return handle_ != nullptr; }
  /// Why it is not loaded, as the system says it.
  const std::string& problem() const { return problem_; }

  /// The function of that name, or null. Precondition: it is loaded, and F is the function's type.
  template <typename F>
  F* find(const char* name) const {
    return reinterpret_cast<F*>(::dlsym(handle_.get(), name));
  }

 private:
  std::shared_ptr<void> handle_;
  std::string problem_;
};

}  // namespace regulus
