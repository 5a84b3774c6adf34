#include "stress/point_truth.h"

#include "scene/pieces/interior.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr long double kGrazing = 0.2L;  // the sine of the angle between a line and a surface

/// The signed distance from the inside of a closed mesh; nothing for a point that is surely outside of its box.
std::optional<DistanceBounds> insideOf(const Interior& interior, const Vector3l& point) {
  const Vector3d rounded = point.cast<double>();
  const double rounding = 16.0 * kEpsilon * (rounded.norm() + interior.box().diagonal().norm());
  if (interior.box().exteriorDistance(rounded) > rounding) return std::nullopt;
  const Interior::Place place = interior.placeOf(rounded);
  return DistanceBounds{place.lower_bound - rounding, place.upper_bound + rounding};
}

}  // namespace

OraclePiece::OraclePiece(const RobotModel& robot, const Piece& of_robot)
    : piece(of_robot), link(robot.collisionOf(of_robot).link), body(robot.links[link].body), oracle(of_robot.shape) {}

std::vector<OraclePiece> oraclePiecesOf(const RobotModel& robot) {
  std::vector<OraclePiece> pieces;
  for (const Body& body : robot.bodies)
    for (const int piece : body.pieces) pieces.emplace_back(robot, robot.pieces[piece]);
  return pieces;
}

PointTruth::PointTruth(const std::vector<OraclePiece>& pieces, const BodyPoses& poses)
    : origin_(poses.front()->translation().cast<long double>()) {
  for (const OraclePiece& piece : pieces) {
    LongPose near_T_body = narrowphase::longPose(*poses[piece.body]);
    near_T_body.translation -= origin_;
    const LongPose near_T_piece = near_T_body * narrowphase::longPose(piece.piece.body_T_piece);
    const Vector3d centre = (near_T_piece * piece.oracle.centre()).cast<double>();
    const double radius = static_cast<double>(piece.oracle.radius());
    pieces_.push_back({piece, near_T_piece.inverse(), centre, radius + 4.0 * kEpsilon * (radius + centre.norm())});
  }
}

PointTruth::Place PointTruth::placeOf(const Vector3l& of_poses, int link) const {
  const Vector3l point = of_poses - origin_;
  const Vector3d rounded = point.cast<double>();
  const double rounding = 8.0 * kEpsilon * rounded.norm();
  std::vector<std::pair<double, const Placed*>> by_gap;  // from the ball about the piece
  double smallest_farthest = std::numeric_limits<double>::infinity();
  for (const Placed& placed : pieces_) {
    if (link != kAllLinks && placed.of.link != link) continue;
    const double to_centre = (rounded - placed.centre).norm(), gap = to_centre - placed.radius - rounding;
    if (gap > smallest_farthest) continue;
    by_gap.emplace_back(gap, &placed);
    smallest_farthest = std::min(smallest_farthest, to_centre + placed.radius + rounding);
  }
  std::sort(by_gap.begin(), by_gap.end());
  Place place;
  place.distance.low = place.distance.high;
  const auto offer = [&](const DistanceBounds& distance) {
    place.distance.low = std::min(place.distance.low, distance.low);
    place.distance.high = std::min(place.distance.high, distance.high);
  };
  for (const auto& [gap, placed] : by_gap) {
    if (gap > place.distance.high) break;
    offer(placed->of.oracle.distance(placed->piece_T_near * point));
  }
  for (const Placed& placed : pieces_) {
    if (!placed.of.piece.interior || (link != kAllLinks && placed.of.link != link)) continue;
    const std::optional<DistanceBounds> inside = insideOf(*placed.of.piece.interior, placed.piece_T_near * point);
    if (!inside || !(inside->low < 0)) continue;
    place.is_in_mesh = place.is_in_mesh || inside->low < place.distance.low;
    if (inside->high < 0)
      offer(*inside);
    else
      place.distance.low = std::min(place.distance.low, inside->low);
  }
  return place;
}

long double PointTruth::firstHit(const Vector3l& of_poses, const Vector3l& direction) const {
  const Vector3l origin = of_poses - origin_;
  long double first = std::numeric_limits<long double>::infinity();
  const Vector3d from = origin.cast<double>(), along = direction.cast<double>();
  for (const Placed& placed : pieces_) {
    const Vector3l in_piece = placed.piece_T_near * origin;
    if (placed.of.piece.interior) {
      const std::optional<DistanceBounds> inside = insideOf(*placed.of.piece.interior, in_piece);
      if (inside && inside->high < 0) return 0;
    }
    const Vector3d to_centre = placed.centre - from;
    const double rounding = 8.0 * kEpsilon * (from.norm() + to_centre.norm());
    if (to_centre.cross(along).norm() > placed.radius + rounding) continue;
    const PointOracle::Section section = placed.of.oracle.section(in_piece, placed.piece_T_near.rotation * direction);
    if (!section.isEmpty() && section.end >= 0) first = std::min(first, std::max(section.begin, 0.0L));
  }
  return first;
}

bool PointTruth::grazes(const Vector3l& of_poses, const Vector3l& direction, long double reach) const {
  const Vector3l point = of_poses - origin_;
  return std::any_of(pieces_.begin(), pieces_.end(), [&](const Placed& placed) {
    const Vector3l in_piece = placed.piece_T_near * point, along = placed.piece_T_near.rotation * direction;
    if (placed.of.oracle.distance(in_piece).low > reach) return false;
    const PointOracle::Section section = placed.of.oracle.section(in_piece, along);
    return section.isEmpty() || -section.entry_normal.dot(along) < kGrazing;
  });
}

}  // namespace proximity_server::scene
