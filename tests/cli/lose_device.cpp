// Linked into regulus, makes a program whose device is lost when the environment says so.
#include <cstdlib>

#include "gpu/faults.hpp"

namespace regulus::test {
namespace {

/// Reads REGULUS_TEST_DOWNLOADS_BEFORE_LOSS before main.
const bool is_armed = [] {
  const char* downloads = std::getenv("REGULUS_TEST_DOWNLOADS_BEFORE_LOSS");
  if (downloads != nullptr)
    gpu::faults().downloads_before_loss = static_cast<uint32_t>(std::strtoul(downloads, nullptr, 10));
  return downloads != nullptr;
}();

}  // namespace
}  // namespace regulus::test
