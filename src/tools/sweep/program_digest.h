#pragma once

#include <string>

namespace proximity_server::tools {

/// A hash of the program that runs: of its file and of the libraries of this package that it has loaded. Two builds that may
/// answer differently have different ones.
std::string programDigest();

}  // namespace proximity_server::tools
