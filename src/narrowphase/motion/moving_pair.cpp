#include "narrowphase/motion/moving_pair.h"

#include "proximity_server/narrowphase/assertion.h"
#include "proximity_server/narrowphase/shape/rigid_pose.h"
#include "proximity_server/narrowphase/shape/support.h"
#include "proximity_server/narrowphase/signed_distance.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

bool isRigidChain(const MotionChain& chain) {
  return std::all_of(chain.begin(), chain.end(), [](const ScrewMotion& screw) {
    return rigidPose(screw.start) && (0.0 * (screw.linear + screw.angular)).sum() == 0.0;
  });
}

Vector3d originOf(const MotionChain& chain) {
  return chain.empty() ? Vector3d(Vector3d::Zero()) : Vector3d(chain.front().start.translation());
}

/// The shapes with symmetry have their centre on the axis.
Symmetry symmetryOf(const Shape& shape) {
  const bool is_round = shape.halfExtents().x() == shape.halfExtents().y();
  switch (shape.kind()) {
    case Shape::Kind::Segment:
    case Shape::Kind::Cylinder:
    case Shape::Kind::Cone:
      return Symmetry::AboutZ;
    case Shape::Kind::Ellipsoid:
      return is_round ? Symmetry::AboutZ : Symmetry::None;
    default:
      return Symmetry::None;  // a point has no radius that a turn could move
  }
}

}  // namespace

AxisBound::AxisBound(const End& begin, const End& end, const MotionBound& motion, double duration)
    : begin_(begin.gap), end_(end.gap), duration_(duration) {
  const Vector3d turn = end.normal - begin.normal;
  const double fastest = turn.dot(motion.velocity) + turn.norm() * motion.deviation;
  curvature_ = std::max(0.0, motion.acceleration + 2.0 * fastest / duration);
  shortest_ = std::sqrt(std::max(0.0, 1.0 - 0.25 * turn.squaredNorm()));
}

/// Solves d + m t + 1/2 k t^2 = 0 without cancellation, with d = begin - level, the slope m at time 0 and the curvature
/// k.
double AxisBound::firstTimeAt(double level) const {
  const double above = begin_ - (level < 0.0 ? level * shortest_ : level);
  const double discriminant = slope() * slope() - 2.0 * curvature_ * above;
  if (!(above > 0.0) || !std::isfinite(end_ + curvature_)) return 0.0;  // a bound that overflows proves nothing
  if (!(slope() < 0.0) || discriminant < 0.0) return duration_;
  return std::min(duration_, 2.0 * above / (std::sqrt(discriminant) - slope()));
}

double AxisBound::lowestTime() const {
  if (slope() >= 0.0) return 0.0;
  return slope() + curvature_ * duration_ <= 0.0 ? duration_ : -slope() / curvature_;
}

double AxisBound::at(double time) const {
  const double gap = begin_ + slope() * time + 0.5 * curvature_ * time * time;
  return gap < 0.0 ? gap / shortest_ : gap;
}

MovingPair::MovingPair(const Shape& a, const MotionChain& a_motion, const Shape& b, const MotionChain& b_motion)
    : a_(a),
      b_(b),
      a_motion_(a_motion),
      b_motion_(b_motion),
      origin_(originOf(a_motion)),
      a_path_(a_motion, origin_),
      b_path_(b_motion, origin_) {
  // To first order in eps, the error of a support point with its pose is less than 32 eps of each length.
  rounding_ = 32.0 * std::numeric_limits<double>::epsilon() *
              (roundedLengths(a_motion, a.coreReach() + a.margin(), origin_) +
               roundedLengths(b_motion, b.coreReach() + b.margin(), origin_));
}

bool MovingPair::isRigid() const { return isRigidChain(a_motion_) && isRigidChain(b_motion_); }

SignedDistance MovingPair::distance(const Poses& poses, const Options& options) {
  Options inner = options;
  inner.distance_tolerance = std::max(0.0, options.distance_tolerance - 2.0 * rounding_);
  // The first query of a motion has no warm start, the others have one. If their digits differed, a constant distance
  // would seem to change, and a later time could be taken for its minimum.
  inner.repeatability = Repeatability::OfClearFeatures;
  Isometry3d a_T_b = Isometry3d::Identity();
  a_T_b.linear() = poses.a.rotation.transpose() * poses.b.rotation;
  a_T_b.translation() = poses.a.rotation.transpose() * (poses.b.origin - poses.a.origin);
  SignedDistance result = signedDistance(a_, b_, a_T_b, inner, warm_start_);
  result.lower_bound -= rounding_;
  result.upper_bound += rounding_;
  result.normal = (poses.a.rotation * result.normal).normalized();
  result.point_a = poses.a.origin + poses.a.rotation * result.point_a;
  result.point_b = result.point_a + result.distance * result.normal;
  return result;
}

double MovingPair::gapAlong(const Vector3d& normal, const Poses& poses) {
  PROXIMITY_ASSERT(isUnit(normal), "The normal has another length than 1, which would scale the gap: normalise it.");
  const Vector3d on_a = supportPoint(a_, poses.a.rotation.transpose() * normal, vertex_a_);
  const Vector3d on_b = supportPoint(b_, -(poses.b.rotation.transpose() * normal), vertex_b_);
  const Vector3d between = poses.b.origin - poses.a.origin + (poses.b.rotation * on_b - poses.a.rotation * on_a);
  return normal.dot(between) - a_.margin() - b_.margin() - rounding_;
}

MotionBound MovingPair::motion(double begin, double end) const {
  const MotionBound of_a = a_path_.bound(a_.centre(), a_.coreRadius(), begin, end, symmetryOf(a_));
  const MotionBound of_b = b_path_.bound(b_.centre(), b_.coreRadius(), begin, end, symmetryOf(b_));
  return {of_b.velocity - of_a.velocity, of_a.deviation + of_b.deviation, of_a.acceleration + of_b.acceleration};
}

SignedDistance MovingPair::inChainsFrame(SignedDistance result) const {
  result.point_a += origin_;
  result.point_b = result.point_a + result.distance * result.normal;
  return result;
}

}  // namespace proximity_server::narrowphase
