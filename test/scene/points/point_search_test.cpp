#include "proximity_server/scene/points/point_search.h"

#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "scene/files.h"
#include "scene/query/cell.h"
#include "scene/solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace proximity_server::scene::point_search_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::Shape;
using narrowphase::SignedDistance;
using narrowphase::Sphere;
using narrowphase::Status;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<PairProximity> ask(const State& state, const Points& points, const Question& question = {},
                               Skipping skipping = Skipping::On) {
  return PointSearch(state.sharedModel(), skipping).closest(state, points, question);
}

SignedDistance askOne(const State& state, const Vector3d& point, double radius = 0.0) {
  return ask(state, {{point}, {radius}}).front().result;
}

Question within(double threshold) {
  Question question;
  question.threshold = threshold;
  return question;
}

std::string errorOf(const State& state, const Points& points) {
  return scene::errorOf([&] { ask(state, points); });
}

bool sameBits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool sameBits(const Vector3d& a, const Vector3d& b) {
  return sameBits(a.x(), b.x()) && sameBits(a.y(), b.y()) && sameBits(a.z(), b.z());
}
void expectSameAnswer(const PairProximity& a, const PairProximity& b) {
  EXPECT_EQ(a.asked.a, b.asked.a);
  EXPECT_EQ(a.collision_a, b.collision_a);
  EXPECT_EQ(a.result.status, b.result.status);
  EXPECT_TRUE(sameBits(a.result.distance, b.result.distance));
  EXPECT_TRUE(sameBits(a.result.lower_bound, b.result.lower_bound));
  EXPECT_TRUE(sameBits(a.result.upper_bound, b.result.upper_bound));
  EXPECT_TRUE(sameBits(a.result.point_a, b.result.point_a));
  EXPECT_TRUE(sameBits(a.result.normal, b.result.normal));
}

/// A box, a hull of a bracket with a dent as triangles, and a ball, far from each other, with a held box and a wall.
struct MixedCell : Cell {
  explicit MixedCell(Meshes& meshes)
      : Cell({box("0.4 0.6 0.8"), meshes.of(bracket()), ball("0.3") + box("0.1 0.2 0.3", "0.5 0 0")}) {
    change({add("held", {{Shape(narrowphase::Box{{0.2, 0.2, 0.2}})}}, Attached{"2", {}, at(0, 0.8, 0)}),
            add("wall", {{Shape(narrowphase::Box{{0.1, 9, 9}})}}, Fixed{at(4, 0, 0)})});
  }
  void putAtChance(Chance& chance) { put({chance.pose(1.5), chance.pose(1.5), chance.pose(1.5)}); }
};

TEST(PointSearch, FindsTheDistanceFromABox) {
  Cell cell({box("2 4 6")});
  cell.put({at(1, 0, 0)});
  const State& state = cell.scene().state;
  EXPECT_NEAR(askOne(state, {5, 0, 0}).distance, 3.0, 1e-12);
  EXPECT_NEAR(askOne(state, {5, 0, 0}, 0.5).distance, 2.5, 1e-12);
  EXPECT_NEAR(askOne(state, {5, 6, 3}).distance, 5.0, 1e-12);
  EXPECT_NEAR(askOne(state, {1.75, 0, 0}).distance, -0.25, 1e-9);
  EXPECT_NEAR(askOne(state, {1.75, 0, 0}, 0.5).distance, -0.75, 1e-9);
  EXPECT_NEAR(askOne(state, {2, 0, 0}).distance, 0.0, 1e-12);
}

TEST(PointSearch, TellsPointsAndNormalFromTheShapeToThePoint) {
  Cell cell({box("2 4 6")});
  cell.put({at(1, 0, 0)});
  const PairProximity found = ask(cell.scene().state, {{{0, 0, 9}, {5, 0.5, 0}}, {0.5}})[1];
  EXPECT_EQ(found.asked.a, cell.link("0"));
  EXPECT_EQ(found.collision_a, 1);
  EXPECT_EQ(found.asked.b, ShapeRef::ofPoint(1));
  EXPECT_TRUE(found.result.point_a.isApprox(Vector3d(2, 0.5, 0), 1e-12));
  EXPECT_TRUE(found.result.point_b.isApprox(Vector3d(4.5, 0.5, 0), 1e-12));
  EXPECT_TRUE(found.result.normal.isApprox(Vector3d::UnitX(), 1e-12));
}

// Inside of the bracket, 0.4 from its nearest face, no triangle is near.
TEST(PointSearch, IsNegativeInsideOfAClosedMesh) {
  Meshes meshes;
  Cell cell({meshes.of(bracket())});
  cell.put({at(0, 0, 0)});
  const SignedDistance inside = askOne(cell.scene().state, {0.5, 0.5, 0.4});
  EXPECT_NEAR(inside.distance, -0.4, 1e-12);
  EXPECT_LE(inside.lower_bound, -0.4);
  EXPECT_GE(inside.upper_bound, -0.4);
  EXPECT_NEAR(askOne(cell.scene().state, {0.5, 0.5, 0.4}, 0.1).distance, -0.5, 1e-12);
}

TEST(PointSearch, AsksAboutHeldObjectsToo) {
  Meshes meshes;
  MixedCell cell(meshes);
  cell.put({at(-9, 0, 0), at(9, 0, 0), at(0, 0, 0)});
  const PairProximity found = ask(cell.scene().state, {{{0, 1.4, 0}, {3.9, 0, 0}}})[0];
  EXPECT_EQ(found.asked.a, cell.object("held"));
  EXPECT_NEAR(found.result.distance, 0.5, 1e-12);
}

TEST(PointSearch, AsksAboutTheNamedShapesOnly) {
  Meshes meshes;
  MixedCell cell(meshes);
  cell.put({at(-9, 0, 0), at(9, 0, 0), at(0, 0, 0)});
  Points points{{{3, 0, 0}}, {}, {cell.object("wall")}};
  EXPECT_NEAR(ask(cell.scene().state, points)[0].result.distance, 0.95, 1e-12);
  points.shapes = {{cell.link("2").link(), 1}};
  EXPECT_NEAR(ask(cell.scene().state, points)[0].result.distance, 2.7, 1e-12);
  points.shapes = {{cell.link("2").link(), 2}};
  EXPECT_NEAR(ask(cell.scene().state, points)[0].result.distance, 2.45, 1e-12);
}

TEST(PointSearch, MeasuresHalfSpaces) {
  Cell cell({ball("0.1")});
  cell.change({add("floor", {{HalfSpace{{0, 0, 1}, 0.0}}}, Fixed{at(0, 0, -1)})});
  cell.put({at(50, 0, 0)});
  const Points points{{{3, 0, 0.5}, {3, 4, -1.5}}, {0.25}, {cell.object("floor")}};
  const std::vector<PairProximity> found = ask(cell.scene().state, points);
  EXPECT_NEAR(found[0].result.distance, 1.25, 1e-12);
  EXPECT_TRUE(found[0].result.normal.isApprox(Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE(found[0].result.point_a.isApprox(Vector3d(3, 0, -1), 1e-12));
  EXPECT_NEAR(found[1].result.distance, -0.75, 1e-12);
  EXPECT_FALSE(found[1].depth_is_lower_bound);
}

// A ball of the scene in the place of each point is asked as a pair.
TEST(PointSearch, IsTheDistanceOfTheClosestPairWithABall) {
  Meshes meshes;
  MixedCell cell(meshes);
  Chance chance(17);
  cell.change({add("ball", {{Shape(Sphere{1.0})}}, Fixed{at(0, 0, 0)})});
  for (int i = 0; i < 100; ++i) {
    cell.putAtChance(chance);
    const Vector3d point = 2.0 * chance.direction() * chance.between(0.0, 1.0);
    const double radius = chance.between(0.01, 0.3);
    cell.change(
        {RemoveObject{"ball"}, add("ball", {{Shape(Sphere{radius})}}, Fixed{at(point.x(), point.y(), point.z())})});
    double smallest = kInfinity;
    for (const ShapeRef& ref : {cell.link("0"), cell.link("1"), cell.link("2"), cell.object("held")})
      smallest = std::min(smallest, cell.between(ref, cell.object("ball")).result.distance);
    const PairProximity found = ask(cell.scene().state, {{point}, {radius}})[0];
    EXPECT_EQ(found.result.status, Status::Converged);
    if (smallest > -radius) {
      EXPECT_NEAR(found.result.distance, smallest, 3e-9);
    }
    EXPECT_TRUE(
        found.result.point_b.isApprox(found.result.point_a + found.result.distance * found.result.normal, 1e-12));
  }
}

TEST(PointSearch, HasTheSameBitsAloneAndInAnyOrderAndWithoutSkipping) {
  Meshes meshes;
  MixedCell cell(meshes);
  Chance chance(5);
  cell.putAtChance(chance);
  const State& state = cell.scene().state;
  Points points;
  for (int i = 0; i < 300; ++i) {
    points.centres.push_back(chance.direction() * chance.between(0.0, 4.0));
    points.radii.push_back(chance.between(0.0, 0.2));
  }
  Points reversed = points;
  std::reverse(reversed.centres.begin(), reversed.centres.end());
  std::reverse(reversed.radii.begin(), reversed.radii.end());
  for (const double threshold : {kInfinity, 0.5, 0.0}) {
    const auto together = ask(state, points, within(threshold)), backwards = ask(state, reversed, within(threshold));
    const auto unskipped = ask(state, points, within(threshold), Skipping::Off);
    for (std::size_t i = 0; i < together.size(); ++i) {
      SCOPED_TRACE(i);
      expectSameAnswer(together[i], ask(state, {{points.centres[i]}, {points.radii[i]}}, within(threshold))[0]);
      expectSameAnswer(together[i], backwards[together.size() - 1 - i]);
      const bool is_far = together[i].result.lower_bound > threshold;
      EXPECT_EQ(is_far, unskipped[i].result.lower_bound > threshold);
      if (!is_far) {
        EXPECT_NEAR(together[i].result.distance, unskipped[i].result.distance, 2e-9);
      }
    }
  }
}

TEST(PointSearch, ProvesWhatIsBeyondTheThreshold) {
  Cell cell({box("2 2 2")});
  cell.put({at(0, 0, 0)});
  PointSearch search(cell.scene().state.sharedModel());
  const auto& found = search.closest(cell.scene().state, {{{1.4, 0, 0}, {1.6, 0, 0}, {9, 0, 0}}}, within(0.5));
  EXPECT_NEAR(found[0].result.distance, 0.4, 1e-12);
  for (const int far : {1, 2}) {
    EXPECT_EQ(found[far].result.status, Status::Threshold);
    EXPECT_EQ(found[far].asked.a.kind(), ShapeRef::Kind::None);
    EXPECT_GT(found[far].result.lower_bound, 0.5);
    EXPECT_FALSE(found[far].result.has_points);
  }
  EXPECT_LE(found[1].result.lower_bound, 0.6);
  EXPECT_EQ(search.counts().total, 3);
  EXPECT_EQ(search.counts().computed, 1);
  EXPECT_EQ(search.counts().by_bounds, 2);
}

// Regression: the bound beyond the threshold was that of the box about the bounded shapes alone.
TEST(PointSearch, ProvesNoMoreThanHalfSpacesAllow) {
  Cell cell({ball("0.1")});
  cell.change({add("floor", {{HalfSpace{{0, 0, 1}, 0.0}}}, Fixed{at(0, 0, -1)})});
  cell.put({at(50, 0, 0)});
  Points points{{{3, 0, 0.5}}, {}, {cell.link("0"), cell.object("floor")}};
  EXPECT_LE(ask(cell.scene().state, points, within(0.5))[0].result.lower_bound, 1.5);
  points.shapes = {cell.object("floor")};
  EXPECT_LE(ask(cell.scene().state, points, within(0.5))[0].result.lower_bound, 1.5);
}

TEST(PointSearch, KeepsItsBoundsFarFromTheOrigin) {
  Cell cell({box("2 2 2")});
  cell.put({at(1e6, 0, 0)});
  const SignedDistance near = askOne(cell.scene().state, {1e6 + 1.5, 0, 0});
  EXPECT_NEAR(near.distance, 0.5, 1e-9);
  const SignedDistance far = askOne(cell.scene().state, {0, 0, 0});
  EXPECT_NEAR(far.distance, 1e6 - 1.0, 1e-7);
  EXPECT_LE(far.lower_bound, 1e6 - 1.0);
  EXPECT_GE(far.upper_bound, 1e6 - 1.0);
}

// Regression: the radius was taken off the bounds without the rounding of that.
TEST(PointSearch, KeepsTheBoundsOfLargeBalls) {
  Cell cell({box("2 2 2")});
  cell.put({at(0, 0, 0)});
  Chance chance(13);
  for (int i = 0; i < 200; ++i) {
    const double x = chance.between(1.1, 2.0), radius = chance.decades(-2, 6);
    const SignedDistance found = askOne(cell.scene().state, {x, 0, 0}, radius);
    const long double truth = static_cast<long double>(x) - 1.0L - radius;
    EXPECT_LE(found.lower_bound, truth) << x << " " << radius;
    EXPECT_GE(found.upper_bound, truth) << x << " " << radius;
  }
}

TEST(PointSearch, HasTheGradientOfAPointAtRest) {
  const auto model =
      modelOf(urdfOf(link("base", box("0.1 0.1 0.1", "0 0 -5")) + link("arm", box("0.2 0.2 1", "0 0 0.5")) +
                     joint("hinge", "continuous", "base", "arm", axis("0 1 0"))));
  State state(model);
  const auto distanceAt = [&](double angle) {
    setPositions(state, {angle});
    return ask(state, {{{0.7, 0.03, 0.6}}})[0];
  };
  const PairProximity found = distanceAt(0.3);
  std::vector<double> gradient;
  scene::gradient(state, found, gradient);
  ASSERT_EQ(gradient.size(), 1u);
  const double step = 1e-5;
  const double difference =
      (distanceAt(0.3 + step).result.distance - distanceAt(0.3 - step).result.distance) / (2 * step);
  EXPECT_NEAR(gradient[0], difference, 1e-6);
  EXPECT_LT(gradient[0], -0.1);
}

// One search keeps the places of the shapes, as long as neither the state nor the shapes change.
TEST(PointSearch, FollowsPosesObjectsAndShapes) {
  Meshes meshes;
  MixedCell cell(meshes);
  PointSearch search(cell.scene().state.sharedModel());
  const auto distanceOf = [&](const std::vector<ShapeRef>& shapes) {
    return search.closest(cell.scene().state, {{{0, 0, 0}}, {}, shapes}).front().result.distance;
  };
  cell.put({at(1, 0, 0), at(9, 9, 9), at(9, 0, 0)});
  EXPECT_NEAR(distanceOf({}), 0.8, 1e-12);
  EXPECT_NEAR(distanceOf({cell.object("wall")}), 3.95, 1e-12);
  EXPECT_THROW(distanceOf({ShapeRef::ofObject(7)}), std::invalid_argument);
  EXPECT_NEAR(distanceOf({}), 0.8, 1e-12);
  cell.put({at(2, 0, 0), at(9, 9, 9), at(9, 0, 0)});
  EXPECT_NEAR(distanceOf({}), 1.8, 1e-12);
  cell.move("wall", Fixed{at(5, 0, 0)});
  EXPECT_NEAR(distanceOf({cell.object("wall")}), 4.95, 1e-12);
}

TEST(PointSearch, LeavesOutShapesWithoutAPose) {
  Cell cell({box("2 2 2"), box("2 2 2")});
  BodyPoses poses = posesOf(cell.robot(), {at(0, 0, 0), at(5, 0, 0)});
  poses[bodyOf(cell.robot(), "0")].reset();
  cell.scene().update(poses);
  PointSearch search(cell.scene().state.sharedModel());
  EXPECT_NEAR(search.closest(cell.scene().state, {{{0, 0, 0}}})[0].result.distance, 4.0, 1e-12);
  ASSERT_EQ(search.unplaced().size(), 1u);
  EXPECT_EQ(search.unplaced()[0], cell.link("0"));
  poses[bodyOf(cell.robot(), "1")].reset();
  cell.scene().update(poses);
  EXPECT_EQ(search.closest(cell.scene().state, {{{0, 0, 0}}})[0].result.status, Status::Unknown);
  EXPECT_EQ(search.counts().unknown, 1);
}

TEST(PointSearch, NamesWhatItRefuses) {
  Cell cell({box("2 2 2")});
  cell.put({at(0, 0, 0)});
  const State& state = cell.scene().state;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(errorOf(state, {{{0, 0, 0}, {0, nan, 0}}}), "points[1] is not finite");
  EXPECT_EQ(errorOf(state, {{{0, 0, 0}, {0, 0, 1}}, {0.1, -0.1}}), "radii[1] is negative or not finite");
  EXPECT_EQ(errorOf(state, {{{0, 0, 0}, {0, 0, 1}, {0, 0, 2}}, {0.1, 0.1}}), "there are 3 points, but 2 radii");
  EXPECT_EQ(errorOf(state, {{{0, 0, 0}}, {}, {ShapeRef::ofObject(3)}}), "there is no object 3");
  EXPECT_THROW(PointSearch(nullptr), std::invalid_argument);
}

}  // namespace proximity_server::scene::point_search_test
