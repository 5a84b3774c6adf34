#pragma once

#include <string>

namespace proximity_server::tools {

/// A hash of the program that runs: of its file, of the libraries of this package that it has loaded, and of the sines that the
/// C library computes on this processor. Two builds that may answer differently have different ones, and so have two hosts.
std::string programDigest();

}  // namespace proximity_server::tools
