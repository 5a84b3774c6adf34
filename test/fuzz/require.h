#pragma once

#include <cstdio>
#include <cstdlib>

namespace proximity_server::fuzz {

/// Ends the program where a promise is broken, which is what a fuzzer looks for.
inline void require(bool holds, const char* promise) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", promise);
  std::abort();
}

}  // namespace proximity_server::fuzz
