#include "base/error.hpp"

#include "base/printable.hpp"

namespace regulus {

Error::Error(ErrorCode code, const std::string& message)
    : std::runtime_error(printable(message)), code_(code) {}

SettingError::SettingError(const std::string& setting, const std::string& value, const std::string& problem)
    : Error(ErrorCode::BadUsage, setting + (value.empty() ? "" : " " + value) + ": " + problem) {}

}  // namespace regulus
