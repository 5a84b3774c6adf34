#pragma once

#include <iostream>
#include <string>

namespace proximity_server::system {

/// Prints the version of the package if --version is the only argument. Returns true if it is.
inline bool tellsVersion(int argc, char** argv, const std::string& program) {
  if (argc != 2 || std::string(argv[1]) != "--version") return false;
  std::cout << program << " of proximity_server " PROXIMITY_VERSION "\n";
  return true;
}

}  // namespace proximity_server::system
