// Sines, cosines and angles, beside those of long double.
#include "proximity_server/narrowphase/angle.h"

#include "sanitized.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace proximity_server::narrowphase::angle_test {

constexpr long double kPi = 3.14159265358979323846264338327950288L;

/// How far a value is from the truth, in units in its last place.
long double unitsOff(double value, long double truth) {
  const double nearest = static_cast<double>(truth);
  const double unit = std::nextafter(std::abs(nearest), std::numeric_limits<double>::infinity()) - std::abs(nearest);
  return std::abs(value - truth) / static_cast<long double>(unit);
}

long double worstOf(double angle) {
  const SineCosine found = sineAndCosine(angle);
  const long double exact = angle;
  return std::max(unitsOff(found.sine, std::sin(exact)), unitsOff(found.cosine, std::cos(exact)));
}

TEST(SineAndCosine, AreWithinTheirError) {
  std::mt19937_64 random(1);
  for (const double most : {1e-9, 1e-3, 0.8, 3.2, 7.0, 1e3, 1.6e6}) {
    std::uniform_real_distribution<double> angles(-most, most);
    long double worst = 0;
    for (int i = 0; i < repeats(1000000); ++i) worst = std::max(worst, worstOf(angles(random)));
    EXPECT_LE(worst, 0.9L) << most;
  }
}

// These are the angles where the sine or the cosine is nearly 0, and where the number of quarter turns changes.
TEST(SineAndCosine, AreWithinTheirErrorAboutMultiplesOfAnEighthTurn) {
  std::mt19937 random(2);
  std::uniform_int_distribution<int> steps(-3, 3);
  for (int eighth = -400000; eighth <= 400000; ++eighth) {
    const double about = static_cast<double>(0.25L * kPi * eighth);
    const double angle = about + steps(random) * (std::nextafter(about, 1e9) - about);
    ASSERT_LE(worstOf(angle), 0.9L) << eighth;
  }
}

TEST(SineAndCosine, OfZeroAreExact) {
  EXPECT_EQ(sineAndCosine(0.0).sine, 0.0);
  EXPECT_EQ(sineAndCosine(0.0).cosine, 1.0);
}

// Mirrored joints of a robot are to have mirrored poses.
TEST(SineAndCosine, OfAnOppositeAngleAreMirrored) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> angles(0.0, 100.0);
  for (int i = 0; i < repeats(100000); ++i) {
    const double angle = angles(random);
    const SineCosine of = sineAndCosine(angle), opposite = sineAndCosine(-angle);
    ASSERT_EQ(of.sine, -opposite.sine) << angle;
    ASSERT_EQ(of.cosine, opposite.cosine) << angle;
  }
}

// Regression: beyond 1.6e6 rad a turn was taken for a number of 64 bits, which is off by 1e-20 of the angle.
TEST(SineAndCosine, OfHugeAnglesAreWithinTheirError) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> mantissas(-2.0, 2.0);
  for (int exponent = 18; exponent < 1023; ++exponent)
    for (int i = 0; i < repeats(100); ++i) {
      const double angle = std::ldexp(mantissas(random), exponent);
      ASSERT_LE(worstOf(angle), 0.9L) << angle;
      ASSERT_EQ(sineAndCosine(angle).sine, -sineAndCosine(-angle).sine) << angle;
    }
  for (const double angle : {0x1p20 * 1.5707963267341256, std::nextafter(0x1p20 * 1.5707963267341256, 1e9), 1e22,
                             std::numeric_limits<double>::max()})
    EXPECT_LE(worstOf(angle), 0.9L) << angle;
}

// The double nearest to a multiple of a quarter turn: Kahan, 6381956970095103 * 2^797.
TEST(SineAndCosine, OfTheHardestAngleAreWithinTheirError) {
  EXPECT_LE(worstOf(std::ldexp(6381956970095103.0, 797)), 0.9L);
}

// Source: the arc tangent of long double, whose last digits do not reach those of double.
TEST(AngleOf, IsWithinItsError) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> numbers(-1.0, 1.0), exponents(-60.0, 60.0);
  for (int i = 0; i < repeats(1000000); ++i) {
    const double sine = numbers(random), cosine = numbers(random) * std::exp2(i % 2 == 0 ? 0.0 : exponents(random));
    const long double truth = std::atan2(static_cast<long double>(sine), static_cast<long double>(cosine));
    ASSERT_LE(unitsOff(angleOf(sine, cosine), truth), 4.0L) << sine << " " << cosine;
    ASSERT_EQ(angleOf(-sine, cosine), -angleOf(sine, cosine));
  }
}

TEST(AngleOf, IsThatOfTheSineAndTheCosine) {
  for (int i = -3000; i <= 3000; ++i) {
    const double angle = 1e-3 * i;
    const auto [sine, cosine] = sineAndCosine(angle);
    EXPECT_NEAR(angleOf(sine, cosine), angle, 4e-16 * std::abs(angle));
  }
  EXPECT_EQ(angleOf(0.0, 1.0), 0.0);
  EXPECT_EQ(angleOf(0.0, -1.0), M_PI);
  EXPECT_EQ(angleOf(1e-300, 1.0), 1e-300);
}

TEST(AngleOf, IsThatOfTheCLibraryWhereItIsNone) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(angleOf(0.0, 0.0), 0.0);
  EXPECT_EQ(angleOf(infinity, -infinity), std::atan2(infinity, -infinity));
  EXPECT_EQ(angleOf(-1.0, infinity), 0.0);
  EXPECT_TRUE(std::isnan(angleOf(std::numeric_limits<double>::quiet_NaN(), 1.0)));
}

TEST(SineAndCosine, OfWhatIsNotFiniteAreNotNumbers) {
  for (const double angle : {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_TRUE(std::isnan(sineAndCosine(angle).sine));
    EXPECT_TRUE(std::isnan(sineAndCosine(angle).cosine));
  }
}

}  // namespace proximity_server::narrowphase::angle_test
