#include "system/durations.h"

#include <algorithm>
#include <cstdio>

namespace proximity_server::system {

std::string secondsText(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", seconds);
  return text;
}

std::chrono::steady_clock::time_point deadlineIn(double seconds) {
  constexpr double kLongest = 1e8;  // [s] a clock of nanoseconds overflows after 9e9 s
  const std::chrono::duration<double> length(std::min(seconds, kLongest));
  return std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::steady_clock::duration>(length);
}

}  // namespace proximity_server::system
