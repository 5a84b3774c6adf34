#pragma once

#include "from_environment.h"

#include <algorithm>

// PROXIMITY_SANITIZED: a sanitizer counts and limits memory itself, and makes everything many times slower.
// PROXIMITY_ADDRESS_SANITIZED: kNoForkBesideThreads.
#ifdef __has_feature  // clang
#if __has_feature(address_sanitizer)
#define PROXIMITY_ADDRESS_SANITIZED
#elif __has_feature(thread_sanitizer)
#define PROXIMITY_SANITIZED
#endif
#elif defined(__SANITIZE_ADDRESS__)  // gcc
#define PROXIMITY_ADDRESS_SANITIZED
#elif defined(__SANITIZE_THREAD__)
#define PROXIMITY_SANITIZED
#endif
#ifdef PROXIMITY_ADDRESS_SANITIZED
#define PROXIMITY_SANITIZED
#endif

namespace proximity_server {

inline constexpr char kNoForkBesideThreads[] =
    "AddressSanitizer's malloc waits for ever in a child process where another thread was in it at fork()";

#ifdef PROXIMITY_SANITIZED
inline constexpr bool kIsSanitized = true;
#else
inline constexpr bool kIsSanitized = false;
#endif

/// How often a test repeats itself where it usually does `usual` times: a thirtieth for a sanitizer, which finds in the
/// first ones what it finds, and PROXIMITY_REPEATS times as often where that is set (./dev stress suites). So few need
/// not show all that the whole test has to show.
inline int repeats(int usual) {
  static const auto times = static_cast<int>(fromEnvironment("PROXIMITY_REPEATS", 1));
  return kIsSanitized ? std::max(1, usual / 30) : times * usual;
}

}  // namespace proximity_server
