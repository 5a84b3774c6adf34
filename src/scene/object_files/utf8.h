#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace proximity_server::scene {

/// The Unicode characters of a text in UTF-8. Throws std::invalid_argument if it is none: a file cannot hold it.
std::vector<std::uint32_t> codePointsOf(const std::string& text);

}  // namespace proximity_server::scene
