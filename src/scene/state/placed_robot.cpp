#include "scene/state/placed_robot.h"

#include "proximity_server/narrowphase/assertion.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "proximity_server/scene/model/kinematics.h"
#include "scene/model/body_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Transforms a result from one frame into another. The point on b follows from that on a, so that the distance between
/// the two stays exact.
narrowphase::SignedDistance transformed(const Matrix3d& to_R_from, const Vector3d& origin_in_to,
                                        narrowphase::SignedDistance result) {
  result.normal = (to_R_from * result.normal).normalized();
  result.point_a = origin_in_to + to_R_from * result.point_a;
  result.point_b = result.point_a + result.distance * result.normal;
  return result;
}

}  // namespace

PlacedRobot::PlacedRobot(const RobotModel& model, std::shared_ptr<const Volumes> volumes)
    : model_(model),
      volumes_(std::move(volumes)),
      bodies_(model.bodies.size()),
      spheres_(static_cast<std::size_t>(volumes_->rootCount())),
      next_piece_(static_cast<int>(model.pieces.size())) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) bodies_[i].has_geometry = !model.bodies[i].pieces.empty();
  for (int part = 0; part < volumes_->rootCount(); ++part) parts_.push_back(volumes_->part(part));
}

void PlacedRobot::update(const BodyPoses& poses, const FramePoses& frames) {
  PROXIMITY_ASSERT(poses.size() == model_.bodies.size(), "There must be one pose for each body.");
  for (std::size_t i = 0; i < poses.size(); ++i) placeBody(poses[i], bodies_[i]);
  placeSpheres();
  if (!objects_) return;
  for (const int number : objects_->moving()) placeBody(frames[objects_->frameOf(number)], ownBodyOf(number));
}

void PlacedRobot::placeBody(const std::optional<Isometry3d>& usable, BodyPlace& body) {
  body.known = usable.has_value();
  if (!usable) return;
  body.rotation = usable->linear();
  body.origin = usable->translation();
}

void PlacedRobot::place(int body, const Isometry3d& pose) { placeBody(usablePose(pose), bodies_[body]); }

void PlacedRobot::placeFrames(const FramePoses& frames) {
  for (const int number : objects_->moving())
    placeBody(usablePose(frames[objects_->frameOf(number)]), ownBodyOf(number));
}

// --- objects

void PlacedRobot::use(std::shared_ptr<const Objects> objects) {
  // Numbers are never removed: a number of an old object stays, without an object.
  const auto numbers = static_cast<std::size_t>(objects->numberLimit());
  if (const std::size_t end = static_cast<std::size_t>(volumes_->rootCount()) + numbers; end > parts_.size()) {
    parts_.resize(end);
    bodies_.resize(model_.bodies.size() + numbers);
  }
  for (int number = 0; numberOfObject(number) < static_cast<int>(parts_.size()); ++number) {
    const PlacedObject *&present = parts_[numberOfObject(number)].object, *const next = objects->placed(number);
    if (!next)
      ownBodyOf(number).known = false;
    else if (next != present)
      occupy(number, *next);
    present = next;
  }
  objects_ = std::move(objects);
}

/// Puts an object into the place of its number. There may have been another object before.
void PlacedRobot::occupy(int number, const PlacedObject& object) {
  Part& part = parts_[volumes_->rootCount() + number];
  const PlacedObject* before = part.object;
  std::optional<Isometry3d> fixed;
  if (object.kind == PlacedObject::Kind::Fixed) fixed = object.world_T_object;
  placeBody(fixed, ownBodyOf(number));
  if (!before || before->geometry != object.geometry) {
    part = partOf(object);
    // When the numbers are used up, they begin anew: a warm start of other pieces is legal, too.
    const int pieces = static_cast<int>(object.geometry->pieces().size());
    if (next_piece_ > std::numeric_limits<int>::max() - pieces) next_piece_ = static_cast<int>(model_.pieces.size());
    part.first_piece = next_piece_;
    next_piece_ += pieces;
  }
  part.body =
      object.kind == PlacedObject::Kind::Attached ? object.body : static_cast<int>(model_.bodies.size()) + number;
  if (object.kind == PlacedObject::Kind::Attached) bodies_[object.body].has_geometry = true;
}

ShapeRef PlacedRobot::refOf(int part) const {
  if (isObject(part)) return ShapeRef::ofObject(part - volumes_->rootCount());
  const int links = static_cast<int>(model_.links.size());
  if (part < links) return ShapeRef(part);
  const Collision& collision = model_.collisions[part - links];
  return {collision.link, collision.number};
}

const Part& PlacedRobot::existing(int object) const {
  if (static_cast<std::size_t>(object) >= parts_.size() || !(*this)[object].object)
    throw std::invalid_argument("there is no object " + std::to_string(object - volumes_->rootCount()));
  return (*this)[object];
}

PlacedRobot::Sphere PlacedRobot::sphereAround(int part) const {
  Sphere sphere;
  putAround(part, sphere);
  return sphere;
}

void PlacedRobot::putAround(int part, Sphere& sphere) const {
  const Bounds& bounds = (*this)[part].whole().bounds;
  const BodyPlace& body = bodyOf(part);
  sphere.is_placed = body.known;
  sphere.centre = (body.origin - origin_) + body.rotation * bounds.centre;
  sphere.radius = bounds.radius + kPoseRounding * sphere.centre.norm();
}

bool PlacedRobot::isUnboundedFirst(int a, int b) const {
  if (!(*this)[a].isUnbounded()) return false;
  if ((*this)[b].isUnbounded()) throw std::invalid_argument("the distance of two half-spaces is not defined");
  return true;
}

/// sphereGap() of a pair with an object.
double PlacedRobot::gapWithObject(int a, int b) const {
  PROXIMITY_ASSERT(!(*this)[a].isUnbounded(),
                   "The first of the two has half-spaces: exchange them, see isUnboundedFirst().");
  if ((*this)[b].isUnbounded()) return halfSpaceGap(sphereOf(a), b);
  return gapOf(sphereOf(a), sphereOf(b));
}

/// A lower bound of the gap between a sphere and an object with half-spaces.
double PlacedRobot::halfSpaceGap(const Sphere& sphere, int object) const {
  const BodyPlace& body = bodyOf(object);
  const Vector3d from_object = sphere.centre - (body.origin - origin_);
  double gap = std::numeric_limits<double>::infinity();
  for (const PlacedHalfSpace& half_space : (*this)[object].halfSpaces()) {
    const double height = (body.rotation * half_space.normal).dot(from_object) - half_space.offset;
    gap = std::min(gap, height - kPoseRounding * (from_object.norm() + half_space.chain_length));
  }
  gap -= sphere.radius;
  const Volume& root = (*this)[object].whole();
  if (root.isEmpty()) return gap;
  const Vector3d between = body.rotation * root.bounds.centre - from_object;
  return std::min(gap, (1.0 - kPoseRounding) * between.norm() - (sphere.radius + root.bounds.radius));
}

Eigen::AlignedBox3d PlacedRobot::worldBox(int part) const {
  const BodyPlace& body = bodyOf(part);
  return scene::boxAround((*this)[part].whole().bounds, body.rotation, body.origin);
}

// --- spheres and boxes

void PlacedRobot::placeSpheres() {
  const auto known = [](const BodyPlace& body) { return body.has_geometry && body.known; };
  const auto end = bodies_.begin() + static_cast<std::ptrdiff_t>(model_.bodies.size());
  const auto first = std::find_if(bodies_.begin(), end, known);
  if (first != end) origin_ = first->origin;
  for (int part = 0; part < volumes_->rootCount(); ++part) placeSphere(part);
}

void PlacedRobot::placeSphere(int part) {
  PROXIMITY_ASSERT(narrowphase::isPlace(part, spheres_.size()),
                   "Only parts of the robot keep their spheres: that of an object is made when it is asked.");
  Sphere& sphere = spheres_[part];
  sphere.is_placed = bodyOf(part).known && !(*this)[part].whole().isEmpty();
  if (sphere.is_placed) putAround(part, sphere);
}

RelativePose PlacedRobot::relative(int a, int b) const {
  PROXIMITY_ASSERT(narrowphase::isPlace(a, parts_.size()) && narrowphase::isPlace(b, parts_.size()),
                   "No part has one of these numbers: they may be volumes within a part.");
  const Part &part_a = (*this)[a], &part_b = (*this)[b];
  if (part_a.body == part_b.body) return {};
  const BodyPlace &body_a = bodies_[part_a.body], &body_b = bodies_[part_b.body];
  RelativePose a_T_b;
  a_T_b.rotation.noalias() = body_a.rotation.transpose() * body_b.rotation;
  a_T_b.translation.noalias() = body_a.rotation.transpose() * (body_b.origin - body_a.origin);
  return a_T_b;
}

Eigen::AlignedBox3d PlacedRobot::boxAround(int part) const {
  const Sphere& sphere = spheres_[part];
  return {sphere.centre.array() - sphere.radius, sphere.centre.array() + sphere.radius};
}

double PlacedRobot::rounding(const Volume& a, const Volume& b, const RelativePose& a_T_b) {
  return kPoseRounding * (a_T_b.translation.norm() + a.bounds.reach + b.bounds.reach);
}

/// In the frame of a, no point of b moves farther than the centre of its sphere, plus the chord of the turn at the
/// radius; and the other way round. A turn by t moves a point at distance 1 from its axis by 2 sin(t/2), which is the
/// Frobenius norm of the difference of the two rotations divided by sqrt(2).
RelativeMotionBound PlacedRobot::relativeMotion(const Part& a, const Part& b, const RelativePose& before,
                                                const RelativePose& now) {
  const double chord = std::sqrt(0.5) * (now.rotation - before.rotation).norm();
  const Vector3d step = now.translation - before.translation;
  if (chord == 0.0 && step.isZero(0.0)) return {0.0, true};

  const Bounds &bounds_a = a.whole().bounds, &bounds_b = b.whole().bounds;
  const auto seenFrom_b = [&](const RelativePose& a_T_b) {
    return Vector3d(a_T_b.rotation.transpose() * (bounds_a.centre - a_T_b.translation));
  };
  const double of_a = (seenFrom_b(now) - seenFrom_b(before)).norm() + chord * bounds_a.radius;
  const double margin = rounding(a.whole(), b.whole(), now);
  // Points on b are kept in the frame of a; the points on a half-space move with the points of a.
  if (b.isUnbounded()) return {of_a + margin, of_a <= margin};
  const double of_b = ((now.rotation - before.rotation) * bounds_b.centre + step).norm() + chord * bounds_b.radius;
  return {std::min(of_a, of_b) + margin, of_b <= margin};
}

narrowphase::SignedDistance PlacedRobot::distanceInBodyA(const Leaf& a, const Leaf& b, const RelativePose& a_T_b,
                                                         const narrowphase::Options& options,
                                                         narrowphase::WarmStart& warm_start) {
  const Piece &piece_a = a.piece, &piece_b = b.piece;
  const Matrix3d rotation_a = piece_a.body_T_piece.linear();
  const Vector3d origin_a = piece_a.body_T_piece.translation();
  Isometry3d piece_a_T_piece_b = Isometry3d::Identity();
  piece_a_T_piece_b.linear() = rotation_a.transpose() * (a_T_b.rotation * piece_b.body_T_piece.linear());
  piece_a_T_piece_b.translation() =
      rotation_a.transpose() * (a_T_b.translation + (a_T_b.rotation * piece_b.body_T_piece.translation() - origin_a));

  const double margin = rounding(a.volume, b.volume, a_T_b);
  narrowphase::Options inner = options;
  // Twice the margin that the bounds lose below, so that these subtractions cannot reverse a decision.
  inner.distance_tolerance = std::max(0.0, options.distance_tolerance - 4.0 * margin);
  inner.stop_above += 2.0 * margin;
  inner.stop_below -= 2.0 * margin;
  narrowphase::SignedDistance in_piece_a =
      signedDistance(piece_a.shape, piece_b.shape, piece_a_T_piece_b, inner, warm_start);
  in_piece_a.lower_bound -= margin;
  in_piece_a.upper_bound += margin;
  if (in_piece_a.status == narrowphase::Status::Converged &&
      in_piece_a.upper_bound - in_piece_a.lower_bound > narrowphase::usableTolerance(options.distance_tolerance))
    in_piece_a.status = narrowphase::Status::Degenerate;
  return transformed(rotation_a, origin_a, in_piece_a);
}

narrowphase::SignedDistance PlacedRobot::inPosesFrame(int a, const narrowphase::SignedDistance& in_body_a) const {
  const BodyPlace& poses_T_body = bodyOf(a);
  return transformed(poses_T_body.rotation, poses_T_body.origin, in_body_a);
}

}  // namespace proximity_server::scene
