#pragma once

#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace proximity_server {

/// Returns the text of a file of test/robots. Throws std::runtime_error if it cannot be read.
inline std::string robotText(const std::string& file) {
  std::ifstream stream(std::string(PROXIMITY_SOURCE_DIR "/test/robots/") + file);
  if (!stream) throw std::runtime_error("cannot read test/robots/" + file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace proximity_server
