// One target as a libFuzzer program. REGULUS_FUZZ_TARGET names it.
#include <cstddef>
#include <cstdint>

#include "fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const regulus::fuzz::Target& target = regulus::fuzz::target(REGULUS_FUZZ_TARGET);
  target.read({data, size});
  return 0;
}
