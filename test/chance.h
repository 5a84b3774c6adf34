#pragma once

#include <Eigen/Geometry>

#include <cmath>
#include <cstdint>
#include <random>

namespace proximity_server {

/// The random source of the tests: all that it gives depends on its seed alone. It is an engine of the standard
/// library, too, so that distributions of <random> and functions that take a std::mt19937 work with it.
class Chance : public std::mt19937 {
 public:
  explicit Chance(unsigned seed) : std::mt19937(seed) {}

  /// The source of one case of a family of a run.
  Chance(unsigned seed, std::size_t family, std::int64_t number)
      : Chance(
            std::seed_seq{static_cast<std::int64_t>(seed), static_cast<std::int64_t>(family), number, number >> 32}) {}

  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(*this); }

  /// Returns a number from 0 to count - 1.
  int below(int count) { return std::uniform_int_distribution<int>(0, count - 1)(*this); }

  /// Returns true in such a share of the calls.
  bool happens(double share) { return between(0.0, 1.0) < share; }

  /// Returns a power of ten between two exponents; every decade is as likely.
  double decades(double low, double high) { return std::pow(10.0, between(low, high)); }

  double eitherSign(double value) { return below(2) == 0 ? value : -value; }

  template <class List>
  const auto& oneOf(const List& list) {
    return list[below(static_cast<int>(std::size(list)))];
  }

  Eigen::Vector3d direction() {
    std::normal_distribution<double> normal;
    const double x = normal(*this), y = normal(*this), z = normal(*this);
    return Eigen::Vector3d(x, y, z).normalized();
  }

  /// Returns a pose that is turned in any way, within `reach` [m] of the origin along each axis.
  Eigen::Isometry3d pose(double reach) {
    const Eigen::Vector3d axis = direction();
    const double angle = between(0.0, M_PI);
    const double x = between(-reach, reach), y = between(-reach, reach), z = between(-reach, reach);
    return Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(angle, axis.normalized());
  }

 private:
  explicit Chance(std::seed_seq&& sequence) : std::mt19937(sequence) {}
};

}  // namespace proximity_server
