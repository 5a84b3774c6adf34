#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace proximity_server::tools {

/// How rows are written.
enum class RowFormat : unsigned char { Csv, Json, Npy };

/// csv, json or npy; also the suffix of files.
const char* toString(RowFormat format);

/// The format of a name; nullopt: there is none.
std::optional<RowFormat> rowFormatNamed(const std::string& name);

/// The text around and between the rows of a file, so that files can be cut and joined at rows.
struct OutputFormat {
  RowFormat rows = RowFormat::Csv;
  std::string begin, before_first, between, end;
  std::string npy_type;  ///< numpy's description of the type of a row; "" for text

  /// `csv_header` is used by Csv only, `npy_type` by Npy.
  OutputFormat(RowFormat rows, const std::string& csv_header, const std::string& npy_type);

  /// The text before the rows. It depends on their number in a .npy, but its size does not.
  std::string header(std::uint64_t rows) const;
};

/// The header of a .npy file, version 1.0: an array of one dimension. All headers of a type have the same size.
/// Source: numpy.lib.format. Its padding is longer here, so that the number of rows may be filled in later.
std::string npyHeader(const std::string& type, std::uint64_t rows);

/// A pair in a state, most often its closest one.
struct NumberedPair {
  std::uint64_t state = 0;
  int pair = -1;                                    ///< its number; -1: none
  double distance = 0.0, lower = 0.0, upper = 0.0;  ///< [m]
};

/// numpy's description of the row of a pair, and its 24 bytes: state u8, pair i4 (-1: none), distance f4 (the nearest),
/// lower f4 (rounded down), upper f4 (rounded up); little endian.
std::string npyPairType();
void appendNpy(const NumberedPair& row, std::string& bytes);

/// The smallest signed integers of numpy that hold -2 to pairs - 1.
struct NpyInteger {
  int bytes = 4;
  std::string type() const { return "'<i" + std::to_string(bytes) + "'"; }
  void append(int number, std::string& to) const;
};
NpyInteger npyIntegerFor(std::size_t pairs);

}  // namespace proximity_server::tools
