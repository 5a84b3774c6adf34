#include "scene/model/sine_cosine.h"

#include <cmath>
#include <cstdint>
#include <limits>

namespace proximity_server::scene {
namespace {

// pi / 2 in three parts. The first two have 33 bits, so that their products with up to 2^20 are exact.
constexpr double kQuarter = 0x1.921fb544p+0, kSecondPart = 0x1.0b4611a6p-34, kThirdPart = 0x1.3198a2e037073p-69;
constexpr double kQuartersPerRadian = 0x1.45f306dc9c883p-1;
constexpr double kMostReduced = 0x1p20 * kQuarter;  // [rad]
constexpr double kRounds = 0x1.8p52;                // a sum with it is a whole number

constexpr double inverseFactorial(int n) { return n < 2 ? 1.0 : inverseFactorial(n - 1) / n; }

/// Of an angle of at most an eighth of a turn, which is r + rest, where the rest is below the last place of r. What
/// Taylor's polynomials leave out is below 3e-18.
SineCosine withinEighth(double r, double rest) {
  constexpr auto f = inverseFactorial;
  const double z = r * r, half = 0.5 * z, z2 = z * z, z4 = z2 * z2;
  const double of_sine =
      ((-f(3) + z * f(5)) + z2 * (-f(7) + z * f(9))) + z4 * ((-f(11) + z * f(13)) + z2 * (-f(15) + z * f(17)));
  const double of_cosine = ((f(4) - z * f(6)) + z2 * (f(8) - z * f(10))) + z4 * ((f(12) - z * f(14)) + z2 * f(16));
  const double most = 1.0 - half;  // of the cosine, and what that rounds away
  return {r + (r * z * of_sine + rest * most), most + (((1.0 - most) - half) + (z2 * of_cosine - r * rest))};
}

}  // namespace

SineCosine sineAndCosine(double angle) {
  if (!(std::abs(angle) <= kMostReduced)) {
    if (!std::isfinite(angle))
      return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
    constexpr long double kTurn = 6.283185307179586476925286766559L;
    angle = static_cast<double>(std::remainder(static_cast<long double>(angle), kTurn));
  }
  const double quarters = (angle * kQuartersPerRadian + kRounds) - kRounds;
  const double reduced = angle - quarters * kQuarter, second = quarters * kSecondPart;
  const double first = reduced - second, moved = first - reduced;
  const double rounded_away = ((reduced - (first - moved)) - (second + moved)) - quarters * kThirdPart;
  const double r = first + rounded_away, rest = rounded_away - (r - first);
  const SineCosine of_rest = withinEighth(r, rest);
  switch (static_cast<std::int64_t>(quarters) & 3) {
    case 0:
      return of_rest;
    case 1:
      return {of_rest.cosine, -of_rest.sine};
    case 2:
      return {-of_rest.sine, -of_rest.cosine};
    default:
      return {-of_rest.cosine, of_rest.sine};
  }
}

}  // namespace proximity_server::scene
