// The one exception type of Regulus, and what kinds of error there are.
#pragma once

#include <stdexcept>
#include <string>

namespace regulus {

/// What kind of error it is, for programs that act on it.
enum class ErrorCode {
  Failed,      ///< neither the caller's nor a file's fault: no memory, a place that cannot be written
  BadUsage,    ///< an argument or setting that makes no sense, by itself or with the others
  BadFile,     ///< a scene or image that cannot be read, or is not what it should be
  NoDevice,    ///< no Vulkan device can be used, or it was lost
  Interrupted  ///< the caller stopped it
};

/// An error that the user can act on. The message is one line that names the file or setting, the offending
/// element and what to do; what it quotes of files is made printable.
class Error : public std::runtime_error {
 public:
  /// @param code what kind of error it is
  /// @param message one line, see above
  Error(ErrorCode code, const std::string& message);
  /// What kind of error it is.
  ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

/// A value that a setting does not take (BadUsage). The message begins with the setting's name.
class SettingError : public Error {
 public:
  /// @param setting its name, as in Settings::set()
  /// @param value empty if the problem quotes it
  /// @param problem what is wrong and what is expected
  SettingError(const std::string& setting, const std::string& value, const std::string& problem);
};

}  // namespace regulus
