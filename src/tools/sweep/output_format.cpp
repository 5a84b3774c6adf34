#include "tools/sweep/output_format.h"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace proximity_server::tools {
namespace {

/// Both numpy and the file are little endian, and so is every machine that Debian's ROS packages are built for.
static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);

constexpr std::size_t kHeaderSize = 256;  ///< a multiple of 64; the longest of our types and 20 digits fit

template <typename Number>
void append(Number number, std::string& bytes) {
  std::array<char, sizeof number> raw;
  std::memcpy(raw.data(), &number, sizeof number);
  bytes.append(raw.data(), raw.size());
}

float roundedDown(double value) {
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) > value ? std::nextafter(nearest, -std::numeric_limits<float>::infinity())
                                              : nearest;
}

float roundedUp(double value) { return -roundedDown(-value); }

}  // namespace

const char* toString(RowFormat format) {
  switch (format) {
    case RowFormat::Csv:
      return "csv";
    case RowFormat::Json:
      return "json";
    case RowFormat::Npy:
      return "npy";
  }
  return "";
}

std::optional<RowFormat> rowFormatNamed(const std::string& name) {
  for (const RowFormat format : {RowFormat::Csv, RowFormat::Json, RowFormat::Npy})
    if (name == toString(format)) return format;
  return std::nullopt;
}

OutputFormat::OutputFormat(RowFormat format, const std::string& csv_header, const std::string& type) : rows(format) {
  switch (format) {
    case RowFormat::Csv:
      begin = csv_header;
      before_first = between = end = "\n";
      return;
    case RowFormat::Json:
      begin = "[";
      before_first = "\n";
      between = ",\n";
      end = "\n]\n";
      return;
    case RowFormat::Npy:
      npy_type = type;
      return;
  }
}

std::string OutputFormat::header(std::uint64_t count) const {
  return rows == RowFormat::Npy ? npyHeader(npy_type, count) : begin;
}

std::string npyHeader(const std::string& type, std::uint64_t rows) {
  const std::string text =
      "{'descr': " + type + ", 'fortran_order': False, 'shape': (" + std::to_string(rows) + ",), }";
  std::string header("\x93NUMPY\x01\x00", 8);
  append(static_cast<std::uint16_t>(kHeaderSize - 10), header);
  header += text;
  header.resize(kHeaderSize - 1, ' ');
  return header + '\n';
}

std::string npyPairType() {
  return "[('state', '<u8'), ('pair', '<i4'), ('distance', '<f4'), ('lower', '<f4'), ('upper', '<f4')]";
}

void appendNpy(const NumberedPair& row, std::string& bytes) {
  append(row.state, bytes);
  append(static_cast<std::int32_t>(row.pair), bytes);
  append(static_cast<float>(row.distance), bytes);
  append(roundedDown(row.lower), bytes);
  append(roundedUp(row.upper), bytes);
}

void NpyInteger::append(int number, std::string& to) const {
  std::array<char, sizeof number> raw;
  std::memcpy(raw.data(), &number, sizeof number);
  to.append(raw.data(), static_cast<std::size_t>(bytes));
}

NpyInteger npyIntegerFor(std::size_t pairs) { return {pairs <= 128 ? 1 : pairs <= 32768 ? 2 : 4}; }

}  // namespace proximity_server::tools
