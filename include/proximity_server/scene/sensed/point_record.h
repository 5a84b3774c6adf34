#pragma once

#include "proximity_server/narrowphase/shape/eigen_alignment.h"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace proximity_server::scene {

/// The points of clouds stand in records of bytes.
struct PointRecord {
  enum class Type : unsigned char { Signed, Unsigned, Float };

  /// A coordinate in the record: a whole number of 1, 2, 4 or 8 bytes, or a float or double.
  struct Field {
    std::uint64_t offset;  ///< [bytes]
    Type type;
    std::uint64_t size;  ///< [bytes]
  };

  std::array<Field, 3> fields;  ///< x, y, z
  bool is_big_endian;

  /// The point of a record, all of whose fields can be read.
  Eigen::Vector3d at(const void* record) const {
    const auto* const bytes = static_cast<const unsigned char*>(record);
    return {numberAt(bytes, fields[0]), numberAt(bytes, fields[1]), numberAt(bytes, fields[2])};
  }

 private:
  double numberAt(const unsigned char* bytes, const Field& field) const {
    bytes += field.offset;
    if (field.type == Type::Float) return field.size == sizeof(float) ? as<float>(bytes) : as<double>(bytes);
    const bool is_signed = field.type == Type::Signed;
    switch (field.size) {
      case 1:
        return is_signed ? as<std::int8_t>(bytes) : as<std::uint8_t>(bytes);
      case 2:
        return is_signed ? as<std::int16_t>(bytes) : as<std::uint16_t>(bytes);
      case 4:
        return is_signed ? as<std::int32_t>(bytes) : as<std::uint32_t>(bytes);
      default:
        return is_signed ? as<std::int64_t>(bytes) : as<std::uint64_t>(bytes);
    }
  }

  template <class Number>
  double as(const unsigned char* place) const {
    std::array<unsigned char, sizeof(Number)> bytes{};
    std::copy_n(place, bytes.size(), bytes.begin());
    if (is_big_endian != (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__)) std::reverse(bytes.begin(), bytes.end());
    Number number{};
    std::memcpy(&number, bytes.data(), bytes.size());
    return static_cast<double>(number);
  }
};

}  // namespace proximity_server::scene
