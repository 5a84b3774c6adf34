#pragma once

#include <algorithm>

// PROXIMITY_SANITIZED: a sanitizer stands in for malloc and fork, and makes everything many times slower. gcc and clang
// say it differently.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define PROXIMITY_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define PROXIMITY_SANITIZED
#endif
#endif

namespace proximity_server {

/// How often a test repeats itself where it usually does `usual` times: a thirtieth for a sanitizer, which finds in the
/// first ones what it finds.
constexpr int repeats(int usual) {
#ifdef PROXIMITY_SANITIZED
  return std::max(1, usual / 30);
#else
  return usual;
#endif
}

}  // namespace proximity_server
