#pragma once

#include <array>
#include <cstring>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// The text with which a .npy begins.
inline std::string npyHeader(const std::string& dictionary, int version = 1) {
  std::string bytes = "\x93NUMPY";
  bytes += static_cast<char>(version);
  bytes += '\0';
  for (std::size_t i = 0; i < (version == 1 ? 2 : 4); ++i) bytes += static_cast<char>(dictionary.size() >> 8 * i);
  return bytes + dictionary;
}

/// The dictionary of an array in C order.
inline std::string npyDictionary(const std::string& dtype, const std::string& shape) {
  return "{'descr': '" + dtype + "', 'fortran_order': False, 'shape': " + shape + ", }\n";
}

/// The numbers as the memory has them.
template <typename Number>
std::string bytesOf(const std::vector<Number>& numbers) {
  std::string bytes(numbers.size() * sizeof(Number), '\0');
  if (!numbers.empty()) std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

}  // namespace proximity_server::tools
