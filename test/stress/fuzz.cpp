// libFuzzer: any bytes become two shapes, a pose, options and a warm start, which keep every promise.
#include "laws/pair_laws.h"
#include "stress/recorded.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Reads the input from the front; beyond its end there are zeros.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  std::uint8_t byte() {
    if (size_ == 0) return 0;
    --size_;
    return *data_++;
  }

  /// Whatever bits there are.
  double anyDouble() {
    std::uint8_t raw[sizeof(double)];
    for (std::uint8_t& b : raw) b = byte();
    double value = 0.0;
    std::memcpy(&value, raw, sizeof value);
    return value;
  }

  /// In [-1, 1], in steps of 2^-15 or of 2^-63: the coarse ones make coordinates that coincide.
  double fraction() {
    const std::uint8_t kind = byte();
    std::uint64_t bits = 0;
    for (int i = 0; i < 8; ++i)
      if (i < 2 || kind % 4 == 0) bits |= static_cast<std::uint64_t>(byte()) << (8 * (7 - i));
    const double value = static_cast<double>(static_cast<std::int64_t>(bits)) * 0x1p-63;
    return kind >= 224 ? value * 0x1p-40 : value;
  }

  /// A length [m] from 1e-3 to 2, or from 1e-6.
  double length() {
    const double part = std::abs(fraction());
    return (byte() % 8 == 0 ? 1e-6 : 1e-3) + 2.0 * part;
  }

  Vector3d point() {
    const double x = fraction(), y = fraction(), z = fraction();
    return {x, y, z};
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

Shape hull(Bytes& bytes) {
  std::vector<Vector3d> points;
  const int count = 1 + bytes.byte() % 12;
  for (int i = 0; i < count; ++i) points.push_back(bytes.point());
  return ConvexHull(points);
}

Shape primitive(int kind, const Vector3d& size) {
  switch (kind) {
    case 0:
      return Sphere{size.x()};
    case 1:
      return Capsule{size.x(), size.y()};
    case 2:
      return Cylinder{size.x(), size.y()};
    case 3:
      return Cone{size.x(), size.y()};
    case 4:
      return Ellipsoid{size};
    default:
      return Box{size};
  }
}

Shape shape(Bytes& bytes) {
  const int kind = bytes.byte() % 16;
  const double padding = kind >= 8 ? 0.25 * std::abs(bytes.fraction()) : 0.0;
  if (kind % 8 >= 6) return hull(bytes).padded(padding);
  const double x = bytes.length(), y = bytes.length(), z = bytes.length();
  return primitive(kind % 8, {x, y, z}).padded(padding);
}

/// Half of the rotations are made of small integers, so that quarter and half turns are met.
Isometry3d pose(Bytes& bytes) {
  Isometry3d result = Isometry3d::Identity();
  Eigen::Vector4d q;
  const bool coarse = bytes.byte() % 2 == 0;
  for (int i = 0; i < 4; ++i) q[i] = coarse ? bytes.byte() % 3 - 1.0 : bytes.fraction();
  if (q.norm() > 1e-3) result.linear() = Eigen::Quaterniond(q).normalized().toRotationMatrix();
  result.translation() = 2.0 * bytes.point();
  return result;
}

Options options(Bytes& bytes) {
  Options result;
  const int limits[] = {500, 500, 50, 5, 1};
  result.distance_tolerance = std::pow(10.0, -9 - bytes.byte() % 6);
  result.max_iterations = limits[bytes.byte() % 5];
  return result;
}

WarmStart warmStart(Bytes& bytes) {
  WarmStart result;
  if (bytes.byte() % 2 == 0) return result;
  const double x = bytes.anyDouble(), y = bytes.anyDouble(), z = bytes.anyDouble();
  result.axis = Vector3d(x, y, z);
  result.simplex_size = 1;
  result.simplex[0] = {static_cast<std::int8_t>(bytes.byte()), static_cast<std::int8_t>(bytes.byte()) * (1 << 24)};
  return result;
}

StressPair decode(Bytes bytes) {
  const Shape a = shape(bytes), b = shape(bytes);
  const Isometry3d a_T_b = pose(bytes);
  const Options asked = options(bytes);
  return {a, b, a_T_b, asked, warmStart(bytes)};
}

}  // namespace
}  // namespace proximity_server::narrowphase

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace proximity_server::narrowphase;
  const Observation seen = observe(decode({data, size}));
  if (!seen.failure) return 0;
  std::fprintf(stderr, "%s\nfor test/data/recorded_pairs.jsonl:\n%s\n", seen.failure->sentence.c_str(),
               toJsonLine(RecordedPair{"fuzzer: " + seen.failure->sentence, seen.failure->pair, {}, {}}).c_str());
  std::abort();
}
