#pragma once

#include "tools/states/bytes.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// The header of a .npy.
struct NpyHeader {
  enum class Order : unsigned char { C, Fortran };
  std::string dtype;  ///< "<f8", "" for a structured array
  Order order = Order::C;
  std::vector<std::uint64_t> shape;
  std::uint64_t data_begin = 0;  ///< the byte behind the header
};

/// Reads the header: versions 1 to 3 of the format, with the three keys in any order.
/// Failure: throws std::invalid_argument with what is wrong, without a name of the file.
/// Source:  "NPY format" in the NumPy reference manual, numpy.lib.format.
NpyHeader readNpyHeader(Bytes& bytes);

/// A table of numbers, read from a .npy in blocks of rows: float64 or float32, little or big endian, in C or Fortran
/// order. An array of one dimension is a table of one column.
///
/// Failure: the constructor throws std::invalid_argument naming the source: no .npy, another dtype, no table, fewer or
///          more bytes than the shape says.
class NpyTable {
 public:
  /// `source` is the name in messages.
  NpyTable(std::unique_ptr<Bytes> bytes, std::string source);

  std::uint64_t rows() const { return rows_; }
  std::uint64_t columns() const { return columns_; }
  int dimensions() const { return dimensions_; }
  const std::string& source() const { return source_; }

  /// `count` rows from `first` on, which must be there; they begin `stride` numbers apart.
  void read(std::uint64_t first, std::size_t count, std::size_t stride, double* to);

 private:
  template <typename Number>
  void readAs(std::uint64_t first, std::size_t count, std::size_t stride, double* to);

  std::unique_ptr<Bytes> bytes_;
  std::string source_;
  NpyHeader header_;
  std::uint64_t rows_ = 0, columns_ = 1;
  int dimensions_ = 0;
  std::vector<char> raw_;  ///< scratch of read()
};

/// The texts of a .npy of one dimension, of dtype U (any text) or S (bytes), without the zeros behind them, in UTF-8.
/// Failure: throws std::invalid_argument naming the source.
std::vector<std::string> readNpyTexts(Bytes& bytes, const std::string& source);

}  // namespace proximity_server::tools
