#include "scene/guaranteed/reached.h"

#include "scene/model/numbers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace proximity_server::scene {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::SignedDistance;

namespace {

/// The motion that turns by a rotation vector about a point, and then shifts.
Isometry3d movedFrame(const Vector3d& shift, const Vector3d& turn, const Vector3d& origin) {
  const double angle = turn.norm();
  Isometry3d motion = Isometry3d::Identity();
  if (angle > 0.0) motion.linear() = rotationAbout(turn / angle, angle);
  motion.translation() = shift + (origin - motion.linear() * origin);
  return motion;
}

}  // namespace

ReachedStates::ReachedStates(const UncertainPlaces& places, DisplacedPair& pair)
    : places_(places), pair_(pair), moved_(places.robot().bodies.size() + 2), closing_(places.robot().joints.size()) {}

/// Sets one displacement so that the point of the shape moves along the unit vector `towards` as far as it can.
void ReachedStates::displace(const Displacement& own, const Vector3d& point, const Vector3d& towards) {
  Moved& place = moved_[own.place];
  switch (own.kind) {
    case Displacement::Kind::Turn:
    case Displacement::Kind::Slide: {
      const Joint::Mimic& leader = *places_.leaderOf(own);
      closing_[leader.joint] += leader.multiplier * towards.dot(own.velocityAt(point));
      return;
    }
    case Displacement::Kind::Tilt:
      place.turn = own.width * (point - own.origin).cross(towards).normalized();
      place.origin = own.origin;
      return;
    case Displacement::Kind::Shift:
      place.shift = own.width * towards;
      return;
  }
}

/// Sets the positions of all joints from the positions of the leaders, relative to the present ones.
void ReachedStates::moveLeaders(const std::vector<double>& positions) {
  for (std::size_t i = 0; i < places_.robot().bodies.size(); ++i) {
    const int joint = places_.robot().bodies[i].joint;
    if (joint >= 0)
      moved_[i].position = places_.leaders()[joint].multiplier * positions[places_.leaders()[joint].joint];
  }
}

double ReachedStates::bringTogether(DisplacedPair::Where& where) {
  std::fill(closing_.begin(), closing_.end(), 0.0);
  std::fill(moved_.begin(), moved_.end(), Moved());
  for (const Displacement& own : pair_.a.chain) displace(own, where.point_a, where.normal);
  for (const Displacement& own : pair_.b.chain) displace(own, where.point_b, -where.normal);
  for (std::size_t joint = 0; joint < closing_.size(); ++joint)
    if (closing_[joint] != 0.0)
      closing_[joint] = std::copysign(places_.uncertainty().positions[joint], closing_[joint]);
  moveLeaders(closing_);
  return upperBoundDisplaced(where);
}

/// Makes the state of all displacements.
void ReachedStates::placeDisplaced() {
  const RobotModel& robot = places_.robot();
  const auto onParent = [&](int parent, const Moved& own) {
    const Isometry3d frame = movedFrame(own.shift, own.turn, own.origin);
    return parent < 0 ? frame : moved_[parent].displacement * frame;
  };
  reached_.displacements.assign(robot.joints.size(), 0.0);
  reached_.poses.resize(robot.bodies.size());
  for (std::size_t i = 0; i < robot.bodies.size(); ++i) {
    Moved& own = moved_[i];
    const Body& body = robot.bodies[i];
    own.displacement = onParent(body.parent, own);
    if (body.joint >= 0) reached_.displacements[body.joint] = own.position;
    if (own.position != 0.0 && places_.state().poses()[i]) {
      const UnitTwist twist = places_.state().twistOf(static_cast<int>(i));
      own.displacement =
          own.displacement * movedFrame(own.position * twist.linear, own.position * twist.angular, twist.origin);
    }
    reached_.poses[i] = places_.state().poses()[i];
    if (reached_.poses[i]) reached_.poses[i] = own.displacement * *reached_.poses[i];
  }
  const auto displacementOf = [&](const ShapeRef& ref, const Moved& object) {
    const int body = places_.state().bodyOf(ref);
    return ref.isObject() ? onParent(body, object) : moved_[body].displacement;
  };
  reached_.displacement_a = displacementOf(pair_.asked.a, moved_[robot.bodies.size()]);
  reached_.displacement_b = displacementOf(pair_.asked.b, moved_[robot.bodies.size() + 1]);
}

/// The motion of a shape relative to the body that carries both, in the state of all displacements.
Isometry3d ReachedStates::motionOf(const DisplacedShape& shape) const {
  Isometry3d motion = Isometry3d::Identity();
  for (auto own = shape.chain.rbegin(); own != shape.chain.rend(); ++own) {
    const Moved& place = moved_[own->place];
    if (own->kind == Displacement::Kind::Tilt)
      motion = motion * movedFrame(Vector3d::Zero(), place.turn, place.origin);
    else if (own->kind == Displacement::Kind::Shift)
      motion.translation() += motion.linear() * place.shift;
    else
      own->displaceAfter(motion, place.position);
  }
  return motion;
}

/// The distance of the pieces [m] in the state of all displacements; see bringTogether().
double ReachedStates::upperBoundDisplaced(DisplacedPair::Where& where) {
  const Isometry3d pose_a = motionOf(pair_.a) * pair_.a.pose;
  const RelativePose a_T_b = DisplacedPair::relative(pose_a, motionOf(pair_.b) * pair_.b.pose);
  const SignedDistance result = pair_.measured(where.leaves, a_T_b, kInfinity);
  where.normal = pose_a.linear() * result.normal;
  if (!result.has_points) where.normal.setConstant(std::numeric_limits<double>::quiet_NaN());
  where.point_a = pair_.a.pose * result.point_a;
  where.point_b = pair_.b.pose * (a_T_b.rotation.transpose() * (result.point_b - a_T_b.translation));
  return result.upper_bound - pair_.swelling;
}

/// Makes the answer of the state of all displacements. The poses of all bodies have other last digits than motionOf(), so
/// the pieces are measured in these. Returns whether they are closer than the threshold.
bool ReachedStates::isReachedBelow(double threshold, const LeafPair& leaves) {
  placeDisplaced();
  Isometry3d displacement_a = reached_.displacement_a, displacement_b = reached_.displacement_b;
  if (pair_.is_exchanged) std::swap(displacement_a, displacement_b);
  const RelativePose a_T_b = DisplacedPair::relative(displacement_a * pair_.a.pose, displacement_b * pair_.b.pose);
  reached_.upper_bound = pair_.measured(leaves, a_T_b, kInfinity).upper_bound - pair_.swelling;
  return reached_.upper_bound < threshold;
}

const ReachedState* ReachedStates::find(double threshold, double upper_bound, const std::vector<double>& leaders,
                                        const DisplacedPair::Where& deciding) {
  std::fill(moved_.begin(), moved_.end(), Moved());
  if (upper_bound - pair_.swelling < threshold) {
    placeDisplaced();
    reached_.upper_bound = upper_bound - pair_.swelling;
    return &reached_;
  }
  DisplacedPair::Where where = deciding;
  if (!leaders.empty()) {
    moveLeaders(leaders);
    if (upperBoundDisplaced(where) < threshold && isReachedBelow(threshold, where.leaves)) return &reached_;
    where = deciding;
  }
  constexpr int kTries = 4;
  for (int i = 0; i < kTries && where.leaves.a >= 0 && where.normal.allFinite(); ++i)
    if (bringTogether(where) < threshold && isReachedBelow(threshold, where.leaves)) return &reached_;
  return nullptr;
}

}  // namespace proximity_server::scene
