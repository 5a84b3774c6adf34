#include "scene/query/placed_robot.h"

#include <algorithm>
#include <cmath>
#include <limits>
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
      first_object_(volumes_->size()),
      bodies_(model.bodies.size()),
      spheres_(static_cast<std::size_t>(volumes_->rootCount())),
      next_piece_(static_cast<int>(model.pieces.size())) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) bodies_[i].is_used = !model.bodies[i].pieces.empty();
}

void PlacedRobot::update(const BodyPoses& poses) {
  if (poses.size() != model_.bodies.size()) {
    throw std::invalid_argument("the robot has " + std::to_string(model_.bodies.size()) + " bodies, but there are " +
                                std::to_string(poses.size()) + " poses");
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (bodies_[i].is_used) placeBody(poses[i], bodies_[i]);
  }
  placeSpheres();
}

void PlacedRobot::placeBody(const std::optional<Isometry3d>& pose, BodyPlace& body) {
  const std::optional<Isometry3d> usable = usablePose(pose);
  body.known = usable.has_value();
  if (!usable) return;
  body.rotation = usable->linear();
  body.origin = usable->translation();
}

// --- objects

std::vector<int> PlacedRobot::use(std::shared_ptr<const Objects> objects) {
  std::vector<int> changed;
  const auto count = static_cast<std::size_t>(objects->numberLimit());
  // No number is ever lost: those of the objects of before stay, without an object.
  if (count > places_.size()) {
    places_.resize(count);
    bodies_.resize(model_.bodies.size() + count);
  }
  for (int number = 0; number < static_cast<int>(places_.size()); ++number) {
    const PlacedObject *before = objects_ ? objects_->placed(number) : nullptr, *next = objects->placed(number);
    if (next == before) continue;
    if (before && !(next && next->geometry == before->geometry)) changed.push_back(number);
    if (next)
      occupy(number, *next);
    else
      bodies_[model_.bodies.size() + static_cast<std::size_t>(number)].known = false;
    places_[static_cast<std::size_t>(number)].object = next;
  }
  for (const int number : objects->moving()) {
    const std::vector<std::string>& frames = objects->frames();
    const auto frame = std::lower_bound(frames.begin(), frames.end(), objects->placed(number)->frame);
    places_[static_cast<std::size_t>(number)].frame = static_cast<int>(frame - frames.begin());
  }
  objects_ = std::move(objects);
  return changed;
}

/// Gives an object the place of the one that had its number.
void PlacedRobot::occupy(int number, const PlacedObject& object) {
  ObjectPlace& place = places_[static_cast<std::size_t>(number)];
  const auto own_body = model_.bodies.size() + static_cast<std::size_t>(number);
  BodyPlace& body = bodies_[own_body];
  const bool is_new = !place.object || place.object->geometry != object.geometry;
  const bool keeps_its_frame = place.object && object.kind == PlacedObject::Kind::Moving &&
                               place.object->kind == object.kind && place.object->frame == object.frame;
  body.known = object.kind == PlacedObject::Kind::Fixed || (keeps_its_frame && body.known);
  if (object.kind == PlacedObject::Kind::Fixed) {
    body.rotation = object.world_T_object.linear();
    body.origin = object.world_T_object.translation();
  }
  if (is_new) {
    place.root = object.geometry->root();
    if (object.isUnbounded()) place.root.bounds.radius = std::numeric_limits<double>::infinity();
    // When the numbers end they begin anew: a warm start of other pieces is as legal as any.
    const int pieces = static_cast<int>(object.geometry->pieces().size());
    if (next_piece_ > std::numeric_limits<int>::max() - pieces) next_piece_ = static_cast<int>(model_.pieces.size());
    place.first_piece = next_piece_;
    next_piece_ += pieces;
  }
  place.root.body = object.kind == PlacedObject::Kind::Attached ? object.body : static_cast<int>(own_body);
  if (object.kind == PlacedObject::Kind::Attached) bodies_[object.body].is_used = true;
}

void PlacedRobot::requireFrames(std::size_t count) const {
  const std::size_t frames = objects_ ? objects_->frames().size() : 0;
  if (count == frames) return;
  throw std::invalid_argument("the objects have " + std::to_string(frames) + " frames, but there are " +
                              std::to_string(count) + " poses");
}

void PlacedRobot::updateFrames(const std::vector<std::optional<Isometry3d>>& poses) {
  requireFrames(poses.size());
  if (!objects_) return;
  for (const int number : objects_->moving()) {
    const auto index = static_cast<std::size_t>(number);
    placeBody(poses[static_cast<std::size_t>(places_[index].frame)], bodies_[model_.bodies.size() + index]);
  }
}

void PlacedRobot::forgetFrames() {
  if (!objects_) return;
  for (const int number : objects_->moving())
    bodies_[model_.bodies.size() + static_cast<std::size_t>(number)].known = false;
}

bool PlacedRobot::isObjectPlaced(int root) const {
  const auto number = static_cast<std::size_t>(root - first_object_);
  if (number >= places_.size() || !places_[number].object)
    throw std::invalid_argument("there is no object " + std::to_string(number));
  return bodyOf(root).known;
}

Compound PlacedRobot::compoundOfObject(int root) const {
  const ObjectGeometry& geometry = *placedAt(root).geometry;
  const ObjectPlace& place = places_[static_cast<std::size_t>(root - first_object_)];
  return {geometry.volumes().data(), geometry.pieces().data(), 0, place.first_piece};
}

int PlacedRobot::shapeNumber(int root, int leaf) const {
  const ObjectGeometry& geometry = *placedAt(root).geometry;
  if (leaf < 0) return 1 + geometry.halfSpaces()[static_cast<std::size_t>(-2 - leaf)].shape;
  return 1 + geometry.pieces()[static_cast<std::size_t>(geometry.volumes()[static_cast<std::size_t>(leaf)].piece)]
                 .collision;
}

/// As placeSpheres() does it.
PlacedRobot::Sphere PlacedRobot::sphereAround(int root) const {
  if (!isObject(root)) return sphereOf(root);
  const Volume& volume = at(root);
  const BodyPlace& body = bodies_[volume.body];
  Sphere sphere;
  sphere.is_placed = body.known;
  sphere.centre = (body.origin - origin_) + body.rotation * volume.bounds.centre;
  sphere.radius = volume.bounds.radius + kPoseRounding * sphere.centre.norm();
  return sphere;
}

double PlacedRobot::objectGap(int a, int b) const {
  const Sphere sphere_a = sphereAround(a);
  if (!isUnbounded(b)) {
    const Sphere sphere_b = sphereAround(b);
    return (sphere_b.centre - sphere_a.centre).norm() - (sphere_a.radius + sphere_b.radius);
  }
  const BodyPlace& body = bodyOf(b);
  const Vector3d from_b = sphere_a.centre - (body.origin - origin_);
  double gap = std::numeric_limits<double>::infinity();
  for (const PlacedHalfSpace& half_space : halfSpacesOf(b)) {
    const double height = (body.rotation * half_space.normal).dot(from_b) - half_space.offset;
    gap = std::min(gap, height - kPoseRounding * (from_b.norm() + half_space.way));
  }
  gap -= sphere_a.radius;
  const Volume& root = placedAt(b).geometry->root();
  if (root.isEmpty()) return gap;
  const Vector3d between = body.rotation * root.bounds.centre - from_b;
  return std::min(gap, (1.0 - kPoseRounding) * between.norm() - (sphere_a.radius + root.bounds.radius));
}

Eigen::AlignedBox3d PlacedRobot::worldBox(int root) const {
  const BodyPlace& body = bodyOf(root);
  return scene::boxAround(at(root).bounds, body.rotation, body.origin);
}

// --- spheres and boxes

void PlacedRobot::placeSpheres() {
  const auto known = [](const BodyPlace& body) { return body.known; };
  const auto end = bodies_.begin() + static_cast<std::ptrdiff_t>(model_.bodies.size());
  const auto first = std::find_if(bodies_.begin(), end, known);
  if (first != end) origin_ = first->origin;
  for (int root = 0; root < volumes_->rootCount(); ++root) placeSphere(root);
}

void PlacedRobot::placeSphere(int root) {
  const Volume& volume = (*volumes_)[root];
  const BodyPlace& body = bodies_[volume.body];
  Sphere& sphere = spheres_[root];
  sphere.is_placed = body.known && !volume.isEmpty();
  if (!sphere.is_placed) return;
  sphere.centre = (body.origin - origin_) + body.rotation * volume.bounds.centre;
  sphere.radius = volume.bounds.radius + kPoseRounding * sphere.centre.norm();
}

RelativePose PlacedRobot::relative(const Volume& a, const Volume& b) const {
  if (a.body == b.body) return {};
  const BodyPlace &body_a = bodies_[a.body], &body_b = bodies_[b.body];
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

double PlacedRobot::sphereGap(const Volume& a, const Volume& b, const RelativePose& a_T_b) {
  const Bounds &bounds_a = a.bounds, &bounds_b = b.bounds;
  const Vector3d between = a_T_b.translation + (a_T_b.rotation * bounds_b.centre - bounds_a.centre);
  return scene::sphereGap(between, bounds_a, bounds_b);
}

double PlacedRobot::boxGap(const Volume& a, const Volume& b, const RelativePose& a_T_b) {
  const Bounds &bounds_a = a.bounds, &bounds_b = b.bounds;
  const Vector3d between = a_T_b.translation + (a_T_b.rotation * bounds_b.centre - bounds_a.centre);
  return scene::boxGap(between, bounds_a, bounds_a.axes, bounds_b, a_T_b.rotation * bounds_b.axes);
}

double PlacedRobot::rounding(const Volume& a, const Volume& b, const RelativePose& a_T_b) {
  return kPoseRounding * (a_T_b.translation.norm() + a.bounds.reach + b.bounds.reach);
}

/// No point of b moves farther in the frame of a than the centre of its sphere does, plus the turn's chord at the
/// radius; and the same the other way round. A turn by t moves a point at distance 1 from its axis by 2 sin(t/2), which
/// is the Frobenius norm of the difference of the two rotations over sqrt(2).
RelativeMotionBound PlacedRobot::relativeMotion(const Volume& a, const Volume& b, const RelativePose& before,
                                                const RelativePose& now) {
  const double chord = std::sqrt(0.5) * (now.rotation - before.rotation).norm();
  const Vector3d step = now.translation - before.translation;
  if (chord == 0.0 && step.isZero(0.0)) return {0.0, true};

  const Bounds &bounds_a = a.bounds, &bounds_b = b.bounds;
  const auto seenFrom_b = [&](const RelativePose& a_T_b) {
    return Vector3d(a_T_b.rotation.transpose() * (bounds_a.centre - a_T_b.translation));
  };
  const double of_a = (seenFrom_b(now) - seenFrom_b(before)).norm() + chord * bounds_a.radius;
  // Of infinite radius: infinity, or NaN without a turn; std::min() then returns its first argument.
  const double of_b = ((now.rotation - before.rotation) * bounds_b.centre + step).norm() + chord * bounds_b.radius;
  const double distance = std::min(of_a, of_b), margin = rounding(a, b, now);
  // Points on b are kept in the frame of a; those on a half-space are where those of a are.
  const bool has_end = bounds_b.radius < std::numeric_limits<double>::infinity();
  return {distance + margin, (has_end ? of_b : of_a) <= margin};
}

narrowphase::SignedDistance PlacedRobot::distance(const Leaf& a, const Leaf& b, const RelativePose& a_T_b,
                                                  const narrowphase::Options& options,
                                                  narrowphase::WarmStart& warm_start) {
  const Piece &piece_a = a.piece, &piece_b = b.piece;
  const Matrix3d rotation_a = piece_a.body_T_piece.linear();
  const Vector3d origin_a = piece_a.body_T_piece.translation();
  Isometry3d pose = Isometry3d::Identity();  // of piece b in the frame of piece a
  pose.linear() = rotation_a.transpose() * (a_T_b.rotation * piece_b.body_T_piece.linear());
  pose.translation() =
      rotation_a.transpose() * (a_T_b.translation + (a_T_b.rotation * piece_b.body_T_piece.translation() - origin_a));

  const double margin = rounding(a.volume, b.volume, a_T_b);
  narrowphase::Options inner = options;
  // Twice what the bounds lose, so that the sums below cannot take a decision back.
  inner.distance_tolerance = std::max(0.0, options.distance_tolerance - 4.0 * margin);
  inner.stop_above += 2.0 * margin;
  inner.stop_below -= 2.0 * margin;
  narrowphase::SignedDistance result = signedDistance(piece_a.shape, piece_b.shape, pose, inner, warm_start);
  result.lower_bound -= margin;
  result.upper_bound += margin;
  if (result.status == narrowphase::Status::Converged &&
      result.upper_bound - result.lower_bound > narrowphase::usableTolerance(options.distance_tolerance))
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
