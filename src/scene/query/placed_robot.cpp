#include "scene/query/placed_robot.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "proximity_server/narrowphase/signed_distance.h"
#include "proximity_server/scene/model/kinematics.h"
#include "scene/model/usable_pose.h"

namespace proximity_server::scene {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

PlacedRobot::PlacedRobot(const RobotModel& model, std::shared_ptr<const Volumes> volumes)
    : model_(model),
      volumes_(std::move(volumes)),
      bodies_(model.bodies.size()),
      spheres_(static_cast<std::size_t>(volumes_->rootCount())) {}

void PlacedRobot::update(const BodyPoses& poses) {
  if (poses.size() != bodies_.size()) {
    throw std::invalid_argument("the robot has " + std::to_string(bodies_.size()) + " bodies, but there are " +
                                std::to_string(poses.size()) + " poses");
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (model_.bodies[i].pieces.empty()) continue;
    BodyPlace& body = bodies_[i];
    const std::optional<Isometry3d> pose = usablePose(poses[i]);
    body.known = pose.has_value();
    if (!pose) continue;
    body.rotation = pose->linear();
    body.origin = pose->translation();
  }
  placeSpheres();
}

void PlacedRobot::placeSpheres() {
  const auto known = [](const BodyPlace& body) { return body.known; };
  const auto first = std::find_if(bodies_.begin(), bodies_.end(), known);
  for (int root = 0; root < volumes_->rootCount(); ++root) {
    const Volume& volume = at(root);
    const BodyPlace& body = bodyOf(root);
    Sphere& sphere = spheres_[root];
    sphere.is_placed = body.known && !volume.isEmpty();
    if (!sphere.is_placed) continue;
    sphere.centre = (body.origin - first->origin) + body.rotation * volume.bounds.centre;
    sphere.radius = volume.bounds.radius + kPoseRounding * sphere.centre.norm();
  }
}

RelativePose PlacedRobot::relative(int a, int b) const {
  if (at(a).body == at(b).body) return {};
  const BodyPlace &body_a = bodyOf(a), &body_b = bodyOf(b);
  RelativePose a_T_b;
  a_T_b.rotation.noalias() = body_a.rotation.transpose() * body_b.rotation;
  a_T_b.translation.noalias() = body_a.rotation.transpose() * (body_b.origin - body_a.origin);
  return a_T_b;
}

double PlacedRobot::sphereGap(int a, int b) const {
  const Sphere &sphere_a = sphereOf(a), &sphere_b = sphereOf(b);
  return (sphere_b.centre - sphere_a.centre).norm() - (sphere_a.radius + sphere_b.radius);
}

Eigen::AlignedBox3d PlacedRobot::boxAround(int root) const {
  const Sphere& sphere = sphereOf(root);
  return {sphere.centre.array() - sphere.radius, sphere.centre.array() + sphere.radius};
}

double PlacedRobot::sphereGap(int a, int b, const RelativePose& a_T_b) const {
  const Bounds &bounds_a = at(a).bounds, &bounds_b = at(b).bounds;
  const Vector3d between = a_T_b.translation + (a_T_b.rotation * bounds_b.centre - bounds_a.centre);
  return scene::sphereGap(between, bounds_a, bounds_b);
}

double PlacedRobot::boxGap(int a, int b, const RelativePose& a_T_b) const {
  const Bounds &bounds_a = at(a).bounds, &bounds_b = at(b).bounds;
  const Vector3d between = a_T_b.translation + (a_T_b.rotation * bounds_b.centre - bounds_a.centre);
  return scene::boxGap(between, bounds_a, bounds_a.axes, bounds_b, a_T_b.rotation * bounds_b.axes);
}

/// [m] Upper bound of the effect of the rounding of poses on a distance.
double PlacedRobot::rounding(int a, int b, const RelativePose& a_T_b) const {
  return kPoseRounding * (a_T_b.translation.norm() + at(a).bounds.reach + at(b).bounds.reach);
}

/// No point of b moves farther in the frame of a than the centre of its sphere does, plus the turn's chord at the
/// radius; and the same the other way round. A turn by t moves a point at distance 1 from its axis by 2 sin(t/2), which
/// is the Frobenius norm of the difference of the two rotations over sqrt(2).
RelativeMotionBound PlacedRobot::relativeMotion(int a, int b, const RelativePose& before,
                                                const RelativePose& now) const {
  const double chord = std::sqrt(0.5) * (now.rotation - before.rotation).norm();
  const Vector3d step = now.translation - before.translation;
  if (chord == 0.0 && step.isZero(0.0)) return {0.0, true};

  const Bounds &bounds_a = at(a).bounds, &bounds_b = at(b).bounds;
  const auto seenFrom_b = [&](const RelativePose& a_T_b) {
    return Vector3d(a_T_b.rotation.transpose() * (bounds_a.centre - a_T_b.translation));
  };
  const double of_a = (seenFrom_b(now) - seenFrom_b(before)).norm() + chord * bounds_a.radius;
  const double of_b = ((now.rotation - before.rotation) * bounds_b.centre + step).norm() + chord * bounds_b.radius;
  const double distance = std::min(of_a, of_b), margin = rounding(a, b, now);
  return {distance + margin, distance <= margin};
}

narrowphase::SignedDistance PlacedRobot::distance(int a, int b, const RelativePose& a_T_b,
                                                  const narrowphase::Options& options, WarmStarts& warm_starts) const {
  const int index_a = at(a).piece, index_b = at(b).piece;
  const Piece &piece_a = model_.pieces[index_a], &piece_b = model_.pieces[index_b];
  const Matrix3d rotation_a = piece_a.body_T_piece.linear();
  const Vector3d origin_a = piece_a.body_T_piece.translation();
  Isometry3d pose = Isometry3d::Identity();  // of piece b in the frame of piece a
  pose.linear() = rotation_a.transpose() * (a_T_b.rotation * piece_b.body_T_piece.linear());
  pose.translation() =
      rotation_a.transpose() * (a_T_b.translation + (a_T_b.rotation * piece_b.body_T_piece.translation() - origin_a));

  const double margin = rounding(a, b, a_T_b);
  narrowphase::Options inner = options;
  // Twice what the bounds lose, so that the sums below cannot take a decision back.
  inner.distance_tolerance = std::max(0.0, options.distance_tolerance - 4.0 * margin);
  inner.stop_above += 2.0 * margin;
  inner.stop_below -= 2.0 * margin;
  narrowphase::SignedDistance result =
      signedDistance(piece_a.shape, piece_b.shape, pose, inner, warm_starts.of(index_a, index_b));
  result.lower_bound -= margin;
  result.upper_bound += margin;
  if (result.status == narrowphase::Status::Converged &&
      result.upper_bound - result.lower_bound > options.distance_tolerance)
    result.status = narrowphase::Status::Degenerate;
  result.normal = (rotation_a * result.normal).normalized();
  result.point_a = origin_a + rotation_a * result.point_a;
  result.point_b = result.point_a + result.distance * result.normal;
  return result;
}

narrowphase::SignedDistance PlacedRobot::inPosesFrame(int a, narrowphase::SignedDistance result) const {
  const BodyPlace& body = bodyOf(a);
  result.normal = (body.rotation * result.normal).normalized();
  result.point_a = body.origin + body.rotation * result.point_a;
  result.point_b = result.point_a + result.distance * result.normal;
  return result;
}

}  // namespace proximity_server::scene
