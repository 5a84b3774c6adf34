#pragma once

#include <chrono>
#include <string>

namespace proximity_server::system {

/// A duration [s] as text for a message, with up to six significant digits: "0.5 s".
std::string secondsText(double seconds);

/// The point of time in `seconds` [s] from now; years from now for any larger number.
std::chrono::steady_clock::time_point deadlineIn(double seconds);

}  // namespace proximity_server::system
