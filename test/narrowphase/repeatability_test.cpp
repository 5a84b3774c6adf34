#include "chance.h"
#include "narrowphase/certificate.h"
#include "narrowphase/same_bits.h"
#include "oracle/shape_pairs.h"
#include "proximity_server/narrowphase/signed_distance.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace proximity_server::narrowphase {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

/// Round and flat hulls, prisms with many equal faces, points of a grid, which are often coplanar; and all other shapes.
std::vector<Shape> shapes(Chance& random) {
  std::vector<Shape> result;
  for (const NamedShape& named : allShapes()) result.push_back(named.shape);
  for (int i = 0; i < 10; ++i) {
    result.push_back(randomHull(random, 5 + random.below(60), random.direction().cwiseAbs() + Vector3d::Constant(0.1)));
    std::vector<Vector3d> prism, grid;
    const int sides = 3 + random.below(20);
    for (int side = 0; side < sides; ++side)
      for (const double z : {-0.5, 0.5})
        prism.emplace_back(std::cos(2.0 * M_PI * side / sides), std::sin(2.0 * M_PI * side / sides), z);
    for (int point = 0; point < 30; ++point) grid.emplace_back(random.below(5), random.below(5), random.below(5));
    result.push_back(hullOf(prism));
    result.push_back(hullOf(grid));
  }
  return result;
}

/// Poses along a path: small steps of a size that varies, sometimes along the axes of the shapes.
class Path {
 public:
  explicit Path(Chance& random) : random_(random), a_T_b_(randomPose(random, random.decades(-0.3, 1.2))) {
    if (random.happens(0.2)) a_T_b_.linear().setIdentity();
  }
  const Isometry3d& next() {
    const double step = random_.decades(-9.0, -1.0);
    a_T_b_.translation() += step * random_.direction();
    if (!random_.happens(0.3)) a_T_b_.linear() *= Eigen::AngleAxisd(step, random_.direction()).toRotationMatrix();
    return a_T_b_;
  }

 private:
  Chance& random_;
  Isometry3d a_T_b_;
};

constexpr int kPaths = 20000, kSteps = 5;

}  // namespace

TEST(Repeatability, AlwaysGivesTheBitsOfASearchWithoutAWarmStart) {
  Chance random(41);
  const std::vector<Shape> all = shapes(random);
  int by_features = 0, searched = 0;
  for (int i = 0; i < kPaths; ++i) {
    const Shape &a = random.oneOf(all), &b = random.oneOf(all);
    Path path(random);
    Options options;
    options.repeatability = Repeatability::Always;
    if (random.happens(0.3)) options.stop_above = random.between(-0.1, 2.0);
    if (random.happens(0.2)) options.stop_below = std::min(options.stop_above, random.between(-0.2, 0.2));
    WarmStart warm_start;
    for (int step = 0; step < kSteps; ++step) {
      const Isometry3d& a_T_b = path.next();
      const SignedDistance cold = signedDistance(a, b, a_T_b, options);
      const SignedDistance warm = signedDistance(a, b, a_T_b, options, warm_start);
      by_features += warm.iterations == 0 && cold.iterations > 0 ? 1 : 0;
      searched += cold.iterations > 0 && step > 0 ? 1 : 0;
      if (cold.lower_bound > options.stop_above)
        ASSERT_GT(warm.lower_bound, options.stop_above);
      else
        ASSERT_TRUE(areSameBits(warm, cold)) << describe({"path " + std::to_string(i), a, b, a_T_b});
    }
  }
  EXPECT_GT(by_features, searched / 5) << "warm starts were hardly used";
}

TEST(Repeatability, ClearFeaturesGiveTheSameBitsFromAnyWarmStart) {
  Chance random(42);
  const std::vector<Shape> all = shapes(random);
  int same = 0, clear = 0;
  for (int i = 0; i < kPaths; ++i) {
    const Shape &a = random.oneOf(all), &b = random.oneOf(all);
    if (!a.isPolytope() || !b.isPolytope()) continue;
    const Isometry3d a_T_b = randomPose(random, random.decades(0.3, 1.2));
    Options options;
    options.repeatability = Repeatability::OfClearFeatures;
    WarmStart recalled;
    const SignedDistance cold = signedDistance(a, b, a_T_b, options, recalled);
    if (signedDistance(a, b, a_T_b, options, recalled).iterations > 0 || cold.iterations == 0) continue;
    ++clear;  // the features were taken, which were clear
    WarmStart other;
    other.axis = random.direction();
    other.simplex = {{{random.below(8), random.below(8)}, {random.below(8), random.below(8)}, {0, 0}}};
    other.simplex_size = random.below(4);
    same += areSameBits(signedDistance(a, b, a_T_b, options, other), cold) ? 1 : 0;
  }
  EXPECT_EQ(same, clear);
  EXPECT_GT(clear, kPaths / 10);
}

TEST(Repeatability, RecalledFeaturesKeepTheirBounds) {
  Chance random(43);
  const std::vector<Shape> all = shapes(random);
  for (int i = 0; i < kPaths; ++i) {
    const Shape &a = random.oneOf(all), &b = random.oneOf(all);
    Path path(random);
    WarmStart warm_start;
    for (int step = 0; step < kSteps; ++step) {
      const Isometry3d& a_T_b = path.next();
      const SignedDistance warm = signedDistance(a, b, a_T_b, Options(), warm_start);
      const SignedDistance cold = signedDistance(a, b, a_T_b, Options());
      const PairCase pair{"path " + std::to_string(i), a, b, a_T_b};
      ASSERT_TRUE(carriesItsProof({a, b, a_T_b}, warm)) << describe(pair);
      ASSERT_LE(warm.lower_bound, cold.upper_bound) << describe(pair);
      ASSERT_LE(cold.lower_bound, warm.upper_bound) << describe(pair);
    }
  }
}

}  // namespace proximity_server::narrowphase
