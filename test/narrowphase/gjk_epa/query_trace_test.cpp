#include "proximity_server/narrowphase/cso/query_trace.h"

#include "narrowphase/cso/two_cores.h"
#include "narrowphase/near.h"
#include "narrowphase/same_bits.h"
#include "proximity_server/narrowphase/signed_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace proximity_server::narrowphase::query_trace_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

bool areSame(const WarmStart& x, const WarmStart& y) {
  const auto begin = x.simplex.begin();
  return areSameBits(x.axis, y.axis) && x.simplex_size == y.simplex_size &&
         std::equal(begin, begin + x.simplex_size, y.simplex.begin(),
                    [](const auto& p, const auto& q) { return p.a == q.a && p.b == q.b; });
}

/// Random shapes about 1 m large.
class RandomShapes {
 public:
  explicit RandomShapes(unsigned seed) : random_(seed) {}

  double size() { return std::uniform_real_distribution<double>(0.1, 1.0)(random_); }
  Vector3d sizes() { return {size(), size(), size()}; }
  Vector3d point() { return {normal_(random_), normal_(random_), normal_(random_)}; }

  Isometry3d pose(double offset) {
    Isometry3d pose = Isometry3d::Identity();
    const Eigen::Vector4d q(normal_(random_), normal_(random_), normal_(random_), normal_(random_));
    pose.linear() = Eigen::Quaterniond(q.normalized()).toRotationMatrix();
    pose.translation() = offset * point().normalized();
    return pose;
  }

  Shape hull() {
    std::vector<Vector3d> points(4 + random_() % 200);
    for (Vector3d& p : points) p = 0.4 * point();
    return ConvexHull(points);
  }

  Shape any() {
    switch (random_() % 9) {
      case 0:
        return Sphere{size()};
      case 1:
        return Capsule{size(), size()};
      case 2:
        return Box{sizes()};
      case 3:
        return Cylinder{size(), size()};
      case 4:
        return Cone{size(), size()};
      case 5:
        return Ellipsoid{sizes()};
      case 6:
        return Shape(Box{sizes()}).padded(0.05);
      case 7:
        return Shape(Cylinder{size(), size()}).sweptTo(pose(0.5));
      default:
        return hull();
    }
  }

  Options options() {
    Options options;
    const double threshold = 0.2 * normal_(random_);
    switch (random_() % 5) {
      case 0:
        return Options::above(threshold);
      case 1:
        return Options::apart();
      case 2:
        options.stop_above = std::abs(threshold);
        options.stop_below = -std::abs(threshold);
        return options;
      case 3:
        options.distance_tolerance = 1e-4;
        options.max_iterations = 1 + static_cast<int>(random_() % 6);
        return options;
      default:
        return options;
    }
  }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

TEST(QueryTrace, AWatchedQueryGivesTheBitsOfAnUnwatchedOne) {
  RandomShapes shapes(18);
  int apart = 0, overlaps = 0, undecided = 0;
  std::array<int, static_cast<std::size_t>(Algorithm::EpaEllipsoid) + 1> algorithms{};
  for (int pair = 0; pair < 6000; ++pair) {
    const Shape a = shapes.any(), b = shapes.any();
    const Options options = shapes.options();
    WarmStart unwatched, watched;
    const double nearly_concentric = 0.01, anywhere = 1.5;
    Isometry3d a_T_b = shapes.pose((pair % 6 == 0 ? nearly_concentric : anywhere) * shapes.size());
    for (int step = 0; step < 3; ++step) {  // cold, then warm
      const SignedDistance expected = signedDistance(a, b, a_T_b, options, unwatched);
      QueryTrace trace;
      const SignedDistance found = signedDistance(a, b, a_T_b, options, watched, trace);
      ASSERT_TRUE(areSameBits(found, expected) && found.iterations == expected.iterations)
          << "pair " << pair << ", step " << step;
      ASSERT_TRUE(areSame(watched, unwatched)) << "pair " << pair << ", step " << step;
      ++algorithms[static_cast<std::size_t>(trace.algorithm)];
      ++(found.lower_bound > 0.0 ? apart : found.upper_bound < 0.0 ? overlaps : undecided);
      a_T_b.translation() += 0.02 * shapes.point();
    }
  }
  EXPECT_GT(apart, 4000);
  EXPECT_GT(overlaps, 4000);
  for (const Algorithm algorithm :
       {Algorithm::PointsAndSegments, Algorithm::FirstDirection, Algorithm::InnerBalls, Algorithm::BoxAxes,
        Algorithm::BoxPoints, Algorithm::RecalledFeatures, Algorithm::Gjk, Algorithm::GjkNewton,
        Algorithm::EnclosedBall, Algorithm::Epa, Algorithm::EpaNewton, Algorithm::EpaEllipsoid})
    EXPECT_GT(algorithms[static_cast<std::size_t>(algorithm)], 20) << "algorithm " << static_cast<int>(algorithm);
}

// Along x the cubes are 1 m deep, and so are the balls inside; the vertex in this direction proves the lower bound.
TEST(QueryTrace, HasTheFirstVertexWhereBallsInsideDecide) {
  Isometry3d a_T_b = Isometry3d::Identity();
  a_T_b.translation() = Vector3d(1, 0, 0);
  const Shape large = Box{{2, 2, 2}};
  WarmStart cold;
  QueryTrace trace;
  const SignedDistance answer = signedDistance(large, large, a_T_b, Options::above(0.0), cold, trace);
  EXPECT_EQ(trace.algorithm, Algorithm::InnerBalls);
  ASSERT_EQ(trace.gjk.size(), 1U);
  EXPECT_EQ(trace.gjk.front().w.point.x(), 1.0);
  EXPECT_EQ(trace.gjk.front().lower_bound, answer.lower_bound);
  EXPECT_NEAR(answer.lower_bound, -1.0, 1e-14);
}

TEST(QueryTrace, TellsTheAlgorithm) {
  const Shape ball = Sphere{0.2}, upright = Cylinder{0.2, 1.0},
              tetrahedron = hullOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  const Shape plate = Box{{4, 4, 0.2}}, flat = hullOf({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}});
  Isometry3d turned = Isometry3d::Identity();
  turned.linear() = Eigen::AngleAxisd(0.5, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const auto algorithmOf = [&](const Shape& a, const Shape& b, const Vector3d& offset, const Options& options = {}) {
    Isometry3d a_T_b = turned;
    a_T_b.translation() = offset;
    WarmStart cold;
    QueryTrace trace;
    signedDistance(a, b, a_T_b, options, cold, trace);
    return trace.algorithm;
  };
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(algorithmOf(ball, ball, {kNaN, 0, 0}), Algorithm::None);
  EXPECT_EQ(algorithmOf(ball, ball, {3, 0, 0}), Algorithm::PointsAndSegments);
  EXPECT_EQ(algorithmOf(cube(), cube(), {0.5, 0.25, 0.125}), Algorithm::BoxAxes);
  EXPECT_EQ(algorithmOf(cube(), cube(), {5, 0, 0}), Algorithm::BoxPoints);
  EXPECT_EQ(algorithmOf(cube(), tetrahedron, {5, 0, 0}), Algorithm::Gjk);
  EXPECT_EQ(algorithmOf(cube(), cube(), {5, 0, 0}, Options::above(1.0)), Algorithm::FirstDirection);
  EXPECT_EQ(algorithmOf(cube(), upright, {5, 4, 3}), Algorithm::GjkNewton);
  EXPECT_EQ(algorithmOf(cube(), tetrahedron, {0, 0, 0}), Algorithm::Epa);
  EXPECT_EQ(algorithmOf(cube(), tetrahedron, {0, 0, 0}, Options::apart()), Algorithm::InnerBalls);
  EXPECT_EQ(algorithmOf(cube(), tetrahedron, {1.25, 0.25, 0.125}, Options::apart()), Algorithm::EnclosedBall);
  EXPECT_EQ(algorithmOf(cube(), upright, {0.5, 0.25, 0.125}), Algorithm::EpaNewton);
  // On one centre both opposite directions are equally deep: the ellipsoid proves it without faces there.
  EXPECT_EQ(algorithmOf(Ellipsoid{{1, 2, 3}}, Ellipsoid{{1, 2, 3}}, {0, 0, 0}), Algorithm::EpaEllipsoid);
  turned.setIdentity();
  EXPECT_EQ(algorithmOf(flat, flat, {0.25, 0.125, 0}), Algorithm::SurfacePlane);
  EXPECT_EQ(algorithmOf(cube(), cube(), {1.5, 1.5, 1.25}, Options::apart()), Algorithm::BoxAxes);
  EXPECT_EQ(algorithmOf(plate, plate, {1.5, 0.5, 0.25}, Options::above(0.04)), Algorithm::BoxAxes);
  EXPECT_EQ(algorithmOf(cube(), cube(), {5, 0, 0}), Algorithm::BoxPoints);  // between parallel faces
  EXPECT_EQ(algorithmOf(upright, upright, {5, 0, 0}), Algorithm::ParallelAxes);
}

TEST(QueryTrace, IsEmptiedByTheNextQuery) {
  WarmStart cold;
  QueryTrace trace;
  const Isometry3d apart(Eigen::Translation3d(5, 1, 1));
  signedDistance(cube(), hullOf({{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}), apart, {}, cold, trace);
  ASSERT_FALSE(trace.gjk.empty());
  signedDistance(Sphere{1}, Sphere{1}, apart, {}, cold, trace);
  EXPECT_EQ(trace.algorithm, Algorithm::PointsAndSegments);
  EXPECT_TRUE(trace.gjk.empty());
}

// The trace has every iteration, and its last bounds are those of the answer.
TEST(QueryTrace, HoldsEveryIteration) {
  RandomShapes shapes(5);
  int by_gjk = 0, by_epa = 0;
  for (int pair = 0; pair < 500; ++pair) {
    const Shape a = shapes.hull(), b = shapes.hull();
    WarmStart cold;
    QueryTrace trace;
    const SignedDistance answer = signedDistance(a, b, shapes.pose(3.0 * shapes.size()), {}, cold, trace);
    EXPECT_EQ(static_cast<int>(trace.gjk.size()), answer.iterations - static_cast<int>(trace.epa.size()));
    for (std::size_t i = 1; i < trace.gjk.size(); ++i)
      EXPECT_LE(trace.gjk[i].upper_bound, trace.gjk[i - 1].upper_bound);
    if (trace.algorithm == Algorithm::Gjk) {
      EXPECT_NEAR(trace.gjk.back().upper_bound, answer.upper_bound, 1e-14);  // the points add their rounding
      EXPECT_NEAR(trace.gjk.back().lower_bound, answer.lower_bound, 1e-12);
      ++by_gjk;
    }
    if (trace.algorithm != Algorithm::Epa) continue;
    EXPECT_EQ(trace.epa.back().depth, -answer.distance);
    for (std::size_t i = 1; i < trace.epa.size(); ++i) {
      EXPECT_LE(trace.epa[i].depth, trace.epa[i - 1].depth);
      EXPECT_GE(trace.epa[i].faces.size(), 4U);
    }
    ++by_epa;
  }
  EXPECT_GT(by_gjk, 100);
  EXPECT_GT(by_epa, 100);
}

// The worked examples of src/narrowphase/README.md. All of their numbers are from paper.

/// The hull of points named A, B, C, ... and the origin, as a shape of one point.
struct PointsAndOrigin {
  std::vector<Vector3d> points;
  QueryTrace trace;
  SignedDistance answer;

  PointsAndOrigin(const std::vector<Vector3d>& named, const Vector3d& first_direction) : points(named) {
    WarmStart start;
    start.axis = first_direction;
    answer = signedDistance(hullOf(points), pointAt(Vector3d::Zero()), Isometry3d::Identity(), {}, start, trace);
  }

  std::string nameOf(const CsoVertex& vertex) const {
    for (std::size_t i = 0; i < points.size(); ++i)
      if (points[i] == vertex.point) return std::string(1, static_cast<char>('A' + i));
    return "?";
  }
  std::string simplexOf(const QueryTrace::GjkStep& step) const {
    std::string names;
    for (const CsoVertex& vertex : step.simplex) names += nameOf(vertex);
    std::sort(names.begin(), names.end());
    return names;
  }
  /// Name of the new vertex, the simplex afterwards, its nearest point and both bounds.
  void expectStep(std::size_t i, const std::string& w, const std::string& simplex, const Vector3d& nearest,
                  double lower, double upper) const {
    SCOPED_TRACE("step " + std::to_string(i));
    ASSERT_LT(i - 1, trace.gjk.size());
    const QueryTrace::GjkStep& step = trace.gjk[i - 1];
    EXPECT_EQ(nameOf(step.w), w);
    EXPECT_EQ(simplexOf(step), simplex);
    EXPECT_TRUE(isNear(step.nearest, nearest, 1e-14)) << step.nearest.transpose();
    EXPECT_NEAR(step.lower_bound, lower, 1e-13);
    EXPECT_NEAR(step.upper_bound, upper, 1e-13);
  }
};

TEST(WorkedExample, GjkFindsTheNearestPointInFourSteps) {
  const PointsAndOrigin example({{5, 6, 0}, {4, -4, 0}, {7, 1, 0}, {1, 2, 0}, {4, 1, 0}, {2, -1, 0}, {6, -3, 0}},
                                Vector3d::UnitY());
  example.expectStep(1, "A", "A", {5, 6, 0}, -6.0, std::sqrt(61.0));
  // From A towards the origin: B. The line AB passes the origin at 44/sqrt(101).
  example.expectStep(2, "B", "AB", Vector3d(440, -44, 0) / 101.0, -4.0 / std::sqrt(61.0), 44.0 / std::sqrt(101.0));
  example.expectStep(3, "D", "BD", {1.6, 0.8, 0}, 8.0 / std::sqrt(101.0), 4.0 / std::sqrt(5.0));
  example.expectStep(4, "F", "DF", {1.5, 0.5, 0}, 3.0 / std::sqrt(5.0), std::sqrt(2.5));
  // No vertex lies beyond the edge DF: the fifth support point proves it.
  ASSERT_EQ(example.trace.gjk.size(), 5U);
  EXPECT_FALSE(example.trace.gjk.back().has_progress);
  EXPECT_NEAR(example.trace.gjk.back().lower_bound, std::sqrt(2.5), 1e-13);
  EXPECT_EQ(example.trace.algorithm, Algorithm::Gjk);
  EXPECT_EQ(example.answer.status, Status::Converged);
  EXPECT_NEAR(example.answer.distance, std::sqrt(2.5), 1e-15);
}

TEST(WorkedExample, GjkEnclosesTheOriginInThreeSteps) {
  const PointsAndOrigin example({{3, 2, 0}, {-3, -1, 0}, {1, -3, 0}, {-1, 3, 0}, {3, -1, 0}}, {1, 1, 0});
  example.expectStep(1, "A", "A", {3, 2, 0}, -5.0 / std::sqrt(2.0), std::sqrt(13.0));
  example.expectStep(2, "B", "AB", {-0.2, 0.4, 0}, -11.0 / std::sqrt(13.0), 1.0 / std::sqrt(5.0));
  example.expectStep(3, "C", "ABC", {0, 0, 0}, -7.0 / std::sqrt(5.0), 0.0);
  ASSERT_EQ(example.trace.gjk.size(), 3U);
  // The set is flat: it is left across its plane, without any depth.
  EXPECT_EQ(example.trace.algorithm, Algorithm::SurfacePlane);
  EXPECT_NEAR(example.answer.distance, 0.0, 1e-14);
}

TEST(WorkedExample, TheCsoOfTwoPolygonsIsKnownByItsSupportMappingOnly) {
  const std::vector<Vector3d> a{{0, 0, 0}, {3, -1, 0}, {4, 2, 0}, {1, 3, 0}}, b{{7, 1, 0}, {9, 4, 0}, {6, 4, 0}};
  TwoCores cores(hullOf(a), hullOf(b), Vector3d::Zero());
  // A - B in the order of its edges, which are those of A and of -B by their angle, from the lowest vertex on.
  const std::vector<Vector3d> cso{{-6, -5, 0}, {-3, -5, 0}, {-2, -2, 0}, {-3, 1, 0},
                                  {-6, 2, 0},  {-8, -1, 0}, {-9, -4, 0}};
  std::vector<bool> seen(cso.size());
  for (int i = 0; i < 720; ++i) {
    const double angle = (i + 0.5) * M_PI / 360.0;
    const Vector3d direction(std::cos(angle), std::sin(angle), 0.0);
    const Vector3d w = cores.cso.vertex(direction).point;
    std::size_t farthest = 0;
    for (std::size_t k = 0; k < cso.size(); ++k)
      if (direction.dot(cso[k]) > direction.dot(cso[farthest])) farthest = k;
    EXPECT_TRUE(isNear(w, cso[farthest], 1e-14)) << angle;
    seen[farthest] = true;
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true), 7);

  WarmStart cold;
  QueryTrace trace;
  const SignedDistance answer = signedDistance(cores.a, cores.b, cores.a_T_b, {}, cold, trace);
  EXPECT_EQ(trace.algorithm, Algorithm::Gjk);
  EXPECT_NEAR(answer.distance, 8.0 / std::sqrt(10.0), 1e-14);
  EXPECT_TRUE(isNear(answer.point_a, {4, 2, 0}, 1e-14));
  EXPECT_TRUE(isNear(answer.point_b, {6.4, 2.8, 0}, 1e-14));
  EXPECT_TRUE(isNear(trace.gjk.back().nearest, {-2.4, -0.8, 0}, 1e-14));
}

TEST(WorkedExample, EpaExpandsToTheFaceOfLeastDepth) {
  // An octahedron whose corners lie on the axes, and a sphere: nearest is the plane -x/3 + y/3 + z/2 = 1. At the centre
  // of the sphere the left side is 0.4, and its gradient is sqrt(17)/6 long.
  const std::vector<Vector3d> corners{{4, 0, 0}, {-3, 0, 0}, {0, 3, 0}, {0, -4, 0}, {0, 0, 2}, {0, 0, -3}};
  const Vector3d centre(-0.3, 0.6, 0.2);
  const double depth = 0.6 * 6.0 / std::sqrt(17.0);
  WarmStart start;
  QueryTrace trace;
  const SignedDistance answer =
      signedDistance(hullOf(corners), Sphere{0.5}, Isometry3d(Eigen::Translation3d(centre)), {}, start, trace);
  EXPECT_EQ(trace.algorithm, Algorithm::Epa);
  EXPECT_EQ(answer.status, Status::Converged);
  EXPECT_NEAR(answer.distance, -(depth + 0.5), 1e-14);
  EXPECT_TRUE(isNear(answer.normal, Vector3d(-2, 2, 3) / std::sqrt(17.0), 1e-14));

  // The closest faces: B C D in the plane z = 0, 0.2 away, beyond which is (0, 0, -3) at 3.2; C E F in the plane x = 0,
  // 0.3 away, beyond which is (4, 0, 0) at 4.3; then B C E, and nothing lies beyond it.
  ASSERT_EQ(trace.epa.size(), 3U);
  const Vector3d normals[] = {-Vector3d::UnitZ(), Vector3d::UnitX(), Vector3d(-2, 2, 3) / std::sqrt(17.0)};
  const double lower[] = {0.2, 0.3, depth}, depths[] = {3.2, 3.2, depth};
  for (std::size_t i = 0; i < 3; ++i) {
    SCOPED_TRACE(i);
    const QueryTrace::EpaStep& step = trace.epa[i];
    EXPECT_EQ(step.faces.size(), 4U + 2U * i) << "V - E + F = 2 with one vertex more in each step";
    EXPECT_TRUE(isNear(step.normal, normals[i], 1e-14));
    EXPECT_NEAR(step.lower_bound, lower[i], 1e-13);
    EXPECT_NEAR(step.depth, depths[i], 1e-14);
  }
  EXPECT_TRUE(isNear(trace.epa[0].w.point, corners[5] - centre, 1e-15));
  EXPECT_TRUE(isNear(trace.epa[1].w.point, corners[0] - centre, 1e-15));
  EXPECT_EQ(trace.polytope.size(), 6U);
  EXPECT_EQ(trace.final_faces.size(), 8U);
  const QueryTrace::EpaStep& last = trace.epa.back();
  std::vector<Vector3d> closest;
  for (const int v : last.closest) closest.push_back(trace.polytope.at(v).point);
  for (const std::size_t corner : {1U, 2U, 4U})
    EXPECT_EQ(std::count(closest.begin(), closest.end(), Vector3d(corners[corner] - centre)), 1);
}

}  // namespace proximity_server::narrowphase::query_trace_test
