// libFuzzer: one program for each function of targets.h, which CMake names.
#include "fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  proximity_server::fuzz::PROXIMITY_FUZZ_TARGET({reinterpret_cast<const char*>(data), size});
  return 0;
}
