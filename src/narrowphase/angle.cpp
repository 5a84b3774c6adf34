#include "proximity_server/narrowphase/angle.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace proximity_server::narrowphase {
namespace {

// pi / 2 in three parts. The first two have 33 bits, so that their products with up to 2^20 are exact.
constexpr double kQuarter = 0x1.921fb544p+0, kSecondPart = 0x1.0b4611a6p-34, kThirdPart = 0x1.3198a2e037073p-69;
constexpr double kQuartersPerRadian = 0x1.45f306dc9c883p-1;
constexpr double kMostReduced = 0x1p20 * kQuarter;  // [rad]
constexpr double kHalfPi = 0x1.921fb54442d18p+0, kHalfPiRest = 0x1.1a62633145c07p-54;
constexpr double kRounds = 0x1.8p52;  // adding it gives a whole number

constexpr double inverseFactorial(int n) { return n < 2 ? 1.0 : inverseFactorial(n - 1) / n; }

/// The sine and the cosine of r + rest, an angle of at most an eighth of a turn. The rest is below the last place of r.
/// The remainder of Taylor's polynomials is below 3e-18.
SineCosine withinEighth(double r, double rest) {
  constexpr auto f = inverseFactorial;
  const double z = r * r, half = 0.5 * z, z2 = z * z, z4 = z2 * z2;
  const double of_sine =
      ((-f(3) + z * f(5)) + z2 * (-f(7) + z * f(9))) + z4 * ((-f(11) + z * f(13)) + z2 * (-f(15) + z * f(17)));
  const double of_cosine = ((f(4) - z * f(6)) + z2 * (f(8) - z * f(10))) + z4 * ((f(12) - z * f(14)) + z2 * f(16));
  const double most = 1.0 - half;  // the largest part of the cosine; the difference from it is added below
  return {r + (r * z * of_sine + rest * most), most + (((1.0 - most) - half) + (z2 * of_cosine - r * rest))};
}

/// The sine and the cosine of an angle that consists of quarter turns and a rest of at most an eighth of a turn.
SineCosine afterQuarters(std::int64_t quarters, const SineCosine& of_rest) {
  switch (quarters & 3) {
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

/// The bits of 2 / pi, 32 in a word, after 64 zeros: as many as the largest double needs.
constexpr std::array<std::uint32_t, 39> kTwoOverPi{
    0x00000000, 0x00000000, 0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041,
    0xfe5163ab, 0xdebbc561, 0xb7246e3a, 0x424dd2e0, 0x06492eea, 0x09d1921c, 0xfe1deb1c, 0xb129a73e,
    0xe88235f5, 0x2ebb4484, 0xe99c7026, 0xb45f7e41, 0x3991d639, 0x835339f4, 0x9c845f8b, 0xbdf9283b,
    0x1ff897ff, 0xde05980f, 0xef2f118b, 0x5a0a6d1f, 0x6d367ecf, 0x27cb09b7, 0x4f463f66, 0x9e5fea2d,
    0x7527bac7, 0xebe5f17b, 0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1, 0x1f8d5d08, 0x56033046};

/// A whole number of 192 bits, the lowest word first. Sums and products drop higher bits.
using Bits192 = std::array<std::uint32_t, 6>;

Bits192 times(const Bits192& bits, std::uint64_t factor) {
  Bits192 product{};
  for (std::size_t half = 0; half < 2; ++half) {
    const std::uint64_t by = half == 0 ? factor & 0xffffffffu : factor >> 32;
    std::uint64_t carry = 0;
    for (std::size_t i = half; i < product.size(); ++i) {
      carry += by * bits[i - half] + product[i];
      product[i] = static_cast<std::uint32_t>(carry);
      carry >>= 32;
    }
  }
  return product;
}

/// The sine and the cosine of an angle beyond kMostReduced. The angle is mantissa * 2^shift, so only 192 bits of 2 / pi
/// matter for its quarter turns: higher bits give whole turns, and lower bits give less than 2^-137 quarters, while no
/// double is nearer than 2^-62 to a quarter.
SineCosine ofLarge(double angle) {
  int exponent = 0;
  const auto mantissa = static_cast<std::uint64_t>(std::ldexp(std::frexp(std::abs(angle), &exponent), 53));
  // In 2 / pi, the bit with the weight 2^-k counts 2^(shift - k) quarters for each unit of the mantissa. The bits begin
  // with two quarters.
  const int first = 64 + (exponent - 53) - 2, word = first / 32, within = first % 32;
  Bits192 bits;
  for (int i = 0; i < 6; ++i) {
    const std::uint64_t two = static_cast<std::uint64_t>(kTwoOverPi[word + i]) << 32 | kTwoOverPi[word + i + 1];
    bits[5 - i] = static_cast<std::uint32_t>(two << within >> 32);
  }
  Bits192 quarters = times(bits, mantissa);  // the upper two bits are whole quarters
  const bool is_rounded_up = (quarters[5] >> 29 & 1u) != 0;
  const std::int64_t whole = (quarters[5] >> 30) + (is_rounded_up ? 1 : 0);
  quarters[5] &= 0x3fffffffu;
  if (is_rounded_up) {  // replaces the fraction by what is missing to the next quarter
    std::uint64_t carry = 1;
    for (std::uint32_t& part : quarters) {
      carry += static_cast<std::uint32_t>(~part);
      part = static_cast<std::uint32_t>(carry);
      carry >>= 32;
    }
    quarters[5] &= 0x3fffffffu;
  }
  double high = 0.0, low = 0.0, scale = 0x1p-30;
  for (std::size_t i = 6; i-- > 0; scale *= 0x1p-32) {
    const double part = scale * quarters[i], sum = high + part;
    low += part - (sum - high);
    high = sum;
  }
  const double r = high * kHalfPi, rest = std::fma(high, kHalfPi, -r) + (high * kHalfPiRest + low * kHalfPi);
  const double sign = is_rounded_up ? -1.0 : 1.0, sum = r + rest;
  const SineCosine result = afterQuarters(whole, withinEighth(sign * sum, sign * (rest - (sum - r))));
  return {std::copysign(1.0, angle) * result.sine, result.cosine};
}

}  // namespace

SineCosine sineAndCosine(double angle) {
  if (!std::isfinite(angle))
    return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  if (std::abs(angle) > kMostReduced) return ofLarge(angle);
  const double quarters = (angle * kQuartersPerRadian + kRounds) - kRounds;
  const double reduced = angle - quarters * kQuarter, second = quarters * kSecondPart;
  const double first = reduced - second, moved = first - reduced;
  const double rounded_away = ((reduced - (first - moved)) - (second + moved)) - quarters * kThirdPart;
  const double r = first + rounded_away, rest = rounded_away - (r - first);
  return afterQuarters(static_cast<std::int64_t>(quarters), withinEighth(r, rest));
}

/// The C library's angle is rounded to a multiple of 2^-16, which forgets its last digits; what is missing to the angle
/// is so small that the series of the arc tangent ends after three terms.
double angleOf(double sine, double cosine) {
  const double angle = std::atan2(sine, cosine), near = std::round(0x1p16 * angle) * 0x1p-16;
  const auto [s, c] = sineAndCosine(near);
  const double across = sine * c - cosine * s, along = cosine * c + sine * s;
  if (!(along > 0.0 && std::isfinite(along))) return angle;
  const double q = across / along, q2 = q * q;
  return near + (q - q * q2 * (1.0 / 3.0 - 0.2 * q2));
}

}  // namespace proximity_server::narrowphase
