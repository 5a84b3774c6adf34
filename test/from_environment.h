#pragma once

#include <cstdint>
#include <cstdlib>
#include <string>

namespace proximity_server {

/// How much of something a test does: the number in an environment variable, or the usual one where it is not set.
inline std::int64_t fromEnvironment(const char* variable, std::int64_t usual) {
  const char* wanted = std::getenv(variable);
  return wanted == nullptr ? usual : std::stoll(wanted);
}

}  // namespace proximity_server
