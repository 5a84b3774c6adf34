#include "scene/guaranteed/displaced_pair.h"

#include "scene/query/half_space.h"
#include "scene/state/placed_robot.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <utility>

namespace proximity_server::scene {

using Eigen::Vector3d;
using narrowphase::SignedDistance;

namespace {

constexpr double kTiny = std::numeric_limits<double>::min();

// The steps of LimitedWork: of 3 ns, measured on PR2 and Panda within a factor of 1.5.
constexpr std::int64_t kStepsOfQuery = 500, kStepsOfDirection = 60, kStepsOfDisplacement = 30, kStepsOfVertex = 2;

/// The point of the convex hull of some points that is the nearest to the origin, approximately: each step goes along
/// the segment to one of the points (Gilbert, An Iterative Procedure for Computing the Minimum of a Quadratic Form on a
/// Convex Set, 1966).
Vector3d nearestToOrigin(const Vector3d* points, int count) {
  constexpr int kRounds = 8;
  Vector3d nearest = points[count - 1];
  for (int i = 0; i < kRounds * (count - 1); ++i) {
    const Vector3d way = points[i % count] - nearest;
    nearest += std::clamp(-nearest.dot(way) / std::max(way.squaredNorm(), kTiny), 0.0, 1.0) * way;
  }
  return nearest;
}

}  // namespace

DisplacedPair::DisplacedPair(const SceneModel& model, UncertainPlaces& places, LimitedWork& work)
    : places_(places),
      work_(work),
      paddings_(paddingsOf(model.pairs)),
      chains_(kFrames, Chains(static_cast<int>(model.robot.joints.size()))) {}

bool DisplacedPair::begin(const ShapeRefPair& pair) {
  const RobotModel& robot = places_.robot();
  const int bodies = static_cast<int>(robot.bodies.size());
  if (!places_.place(pair.a, bodies, a) || !places_.place(pair.b, bodies + 1, b)) return false;
  int body_a = places_.state().bodyOf(pair.a), body_b = places_.state().bodyOf(pair.b);
  while (body_a != body_b) {
    const bool is_of_a = body_a > body_b;  // parents come first
    int& later = is_of_a ? body_a : body_b;
    const UncertainPlaces::Place& place = places_.placeOf(later);
    if (!place.is_known) return false;
    std::vector<Displacement>& chain = is_of_a ? a.chain : b.chain;
    chain.insert(chain.end(), place.displacements.begin(), place.displacements.end());
    later = robot.bodies[later].parent;
  }
  asked = pair;
  is_exchanged = a.part.isUnbounded();
  if (is_exchanged) std::swap(a, b);
  padding = paddings_.of(pair);
  swelling = places_.swellingOf(pair.a) + places_.swellingOf(pair.b);
  // A half-space has no farthest point: its frame is the only one in which all ways are bounded.
  frame = b.part.isUnbounded() ? kOfB : kCommon;
  place();
  return true;
}

void DisplacedPair::place() {
  a_T_b = relative(a.pose, b.pose);
  for (Chains& chains : chains_) chains.is_placed = false;
}

DisplacedPair::Chains& DisplacedPair::chains(int seen_from) {
  Chains& chains = chains_[seen_from];
  if (chains.is_placed) return chains;
  chains.is_placed = true;
  chains.of_a.begin(a.part.whole().bounds, a.pose);
  chains.of_b.begin(b.part.whole().bounds, b.pose);
  const auto add_inverse = [](const std::vector<Displacement>& chain, Displacements& of) {
    for (auto own = chain.rbegin(); own != chain.rend(); ++own) {
      Displacement inverse = *own;
      inverse.multiplier = -inverse.multiplier;
      of.add(inverse);
    }
  };
  if (seen_from != kOfA)
    for (const Displacement& own : a.chain) chains.of_a.add(own);
  if (seen_from != kOfB)
    for (const Displacement& own : b.chain) chains.of_b.add(own);
  if (seen_from == kOfA) add_inverse(a.chain, chains.of_b);
  if (seen_from == kOfB) add_inverse(b.chain, chains.of_a);
  return chains;
}

void DisplacedPair::countAlong(const Displacements& of, const narrowphase::Shape& shape) {
  const bool is_hull = shape.kind() == narrowphase::Shape::Kind::Hull;
  const std::int64_t vertices = is_hull ? static_cast<std::int64_t>(shape.hull().vertices().size()) : 8;
  work_.count(kStepsOfDirection + kStepsOfDisplacement * of.count() + kStepsOfVertex * vertices);
}

DisplacedPair::Along DisplacedPair::along(const LeafPair& leaves, const Vector3d& normal, int seen_from) {
  Chains& seen = chains(seen_from);
  const Leaf leaf_a(a.part, leaves.a), leaf_b(b.part, leaves.b);
  countAlong(seen.of_a, leaf_a.piece.shape);
  countAlong(seen.of_b, leaf_b.piece.shape);
  const Vector3d from = a.pose.translation();
  const Displacements::Lowest of_a = seen.of_a.lowest(leaf_a.piece, -normal, from),
                              of_b = seen.of_b.lowest(leaf_b.piece, normal, from);
  const double remainder = seen.of_a.remainder(-normal) + seen.of_b.remainder(normal) +
                           PlacedRobot::rounding(leaf_a.volume, leaf_b.volume, a_T_b);
  return {of_a.present + of_b.present - padding,
          of_a.displaced + of_b.displaced - remainder - surfaces(),
          of_a.loss + of_b.loss,
          seen_from,
          {leaves, normal, from + of_a.point, from + of_b.point}};
}

void DisplacedPair::improve(Along& best, double enough, double negligible) {
  // Other frames cannot help if only one of the two is displaced, and the closest points lose about as much in each.
  constexpr double kMuchMore = 1.05;
  if (b.part.isUnbounded()) return;
  const bool are_both_displaced = !a.chain.empty() && !b.chain.empty();
  if (are_both_displaced || best.present - swelling - best.bound > kMuchMore * best.loss) {
    for (const int other_frame : {kOfA, kOfB}) {
      const Along other = along(best.where.leaves, best.where.normal, other_frame);
      if (other.bound > best.bound) best = other;
    }
  }
  turn(best, enough, negligible);
}

/// Turns the normal so that the bound becomes larger. To first order the bound is the support height of a convex set,
/// all differences of displaced points of the cores, and the best normal points to the point of this set that is the
/// nearest to the origin. As in GJK, the nearest point of the support points so far gives the next normal.
void DisplacedPair::turn(Along& best, double enough, double negligible) {
  constexpr int kMostSteps = 6;
  constexpr double kMuch = 0.05;  // of the loss
  if (best.present - best.bound <= negligible) return;
  const LeafPair leaves = best.where.leaves;
  const double margins =
      padding + Leaf(a.part, leaves.a).piece.shape.margin() + Leaf(b.part, leaves.b).piece.shape.margin();
  std::array<Vector3d, kMostSteps + 1> points{(best.present + margins) * best.where.normal};
  Along last = best;
  double lowest = 0.0;
  for (int i = 0; i < kMostSteps && best.bound < enough && best.present + margins > 0.0; ++i) {
    Chains& seen = chains(last.frame);
    const Where& where = last.where;
    points[i + 1] = where.point_b + seen.of_b.lowestStep(where.point_b, where.normal) - where.point_a -
                    seen.of_a.lowestStep(where.point_a, -where.normal);
    lowest = std::max(lowest, where.normal.dot(points[i + 1]));
    const Vector3d nearest = nearestToOrigin(points.data(), i + 2);
    const double length = nearest.norm();
    if (!(length - lowest > std::max(negligible, kMuch * (best.present - best.bound)))) return;
    last = along(leaves, nearest / length, last.frame);
    if (last.bound > best.bound) best = last;
  }
}

SignedDistance DisplacedPair::measured(const LeafPair& leaves, const RelativePose& pose, double stop_above) {
  work_.count(kStepsOfQuery);
  const Leaf leaf(a.part, leaves.a);
  narrowphase::Options options;
  options.stop_above = stop_above + padding;
  if (leaves.hasHalfSpace()) {
    const double rounding = PlacedRobot::rounding(a.part.whole(), b.part.whole(), pose);
    return padded(halfSpaceDistance(leaf.piece, b.part.halfSpaces()[leaves.half_space], pose, rounding,
                                    options.distance_tolerance),
                  padding);
  }
  narrowphase::WarmStart cold;
  return padded(PlacedRobot::distanceInBodyA(leaf, Leaf(b.part, leaves.b), pose, options, cold), padding);
}

}  // namespace proximity_server::scene
