#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace proximity_server::tools {

/// What stands around and between the rows of a file, so that files can be cut and joined at rows.
struct OutputFormat {
  std::string name;  ///< csv, json or npy; also the suffix of files
  std::string begin, before_first, between, end;
  std::string npy_type;  ///< numpy's description of the type of a row; "" for text

  bool isText() const { return npy_type.empty(); }

  /// What stands before the rows. Of .npy it depends on their number, but its size does not.
  std::string header(std::uint64_t rows) const;
};

/// The header of a .npy file, version 1.0: an array of one dimension. All headers of a type have the same size.
/// Source: numpy.lib.format. Its padding is longer here, so that the number of rows may be filled in later.
std::string npyHeader(const std::string& type, std::uint64_t rows);

/// numpy's description of the row of a pair, and its 24 bytes: state u8, pair i4 (-1: none), distance f4 (the nearest),
/// lower f4 (rounded down), upper f4 (rounded up); little endian.
std::string npyPairType();
struct PairRow {
  std::uint64_t state = 0;
  int pair = -1;
  double distance = 0.0, lower = 0.0, upper = 0.0;  ///< [m]
};
void appendNpy(const PairRow& row, std::string& bytes);

/// The smallest signed integers of numpy that hold -2 to pairs - 1.
struct NpyInteger {
  int bytes = 4;
  std::string type() const { return "'<i" + std::to_string(bytes) + "'"; }
  void append(int number, std::string& to) const;
};
NpyInteger npyIntegerFor(std::size_t pairs);

}  // namespace proximity_server::tools
