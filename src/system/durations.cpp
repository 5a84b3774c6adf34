#include "system/durations.h"

#include <cstdio>

namespace proximity_server::system {

std::string secondsText(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", seconds);
  return text;
}

std::chrono::steady_clock::time_point deadlineIn(double seconds) {
  const std::chrono::duration<double> length(seconds);
  return std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::steady_clock::duration>(length);
}

}  // namespace proximity_server::system
