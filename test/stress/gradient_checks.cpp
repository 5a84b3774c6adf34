#include "stress/gradient_checks.h"

#include "scene/objects/placed_object.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kSmoothWithin = 1e-8;  // two extrapolations of a smooth function are as near as this
constexpr double kResolved = 2e-8;      // error of a difference that is of use

/// [s] the largest steps of time that are tried, at a speed of 1 m/s
constexpr std::array<double, 5> kSteps{2e-3, 2e-4, 2e-5, 2e-6, 2e-7};

double gapOf(const PairProximity& pair) { return pair.result.upper_bound - pair.result.lower_bound; }

bool isUsable(const PairProximity& pair, const PairProximity& other) {
  return pair.result.status != narrowphase::Status::Unknown && pair.result.has_points && pair.result.unique &&
         pair.collision_a == other.collision_a && pair.collision_b == other.collision_b;
}

/// The difference of two distances over a time.
using Slope = Difference;
Slope slopeOf(const PairProximity& later, const PairProximity& earlier, double time) {
  return {(later.result.distance - earlier.result.distance) / time, (gapOf(later) + gapOf(earlier)) / time};
}

/// Extrapolates from two slopes, the second with half the step: the error that is proportional to a power of the step
/// vanishes. `ratio` is two to that power.
Slope extrapolated(const Slope& whole, const Slope& half, double ratio) {
  return {(ratio * half.value - whole.value) / (ratio - 1.0), (ratio * half.error + whole.error) / (ratio - 1.0)};
}

enum class Sides : unsigned char { Both, Future };

/// Extrapolates (Richardson) from steps of time that halve; the error of a slope has even powers of the step only if it
/// is two-sided. Returns nullopt if a distance is not usable, or if the extrapolation is too far from that of all steps
/// but the first.
std::optional<Difference> difference(const DistanceAlong& distance, double step, Sides sides) {
  const bool both = sides == Sides::Both;
  const PairProximity first = distance.after(step);
  if (!isUsable(first, first)) return std::nullopt;
  const PairProximity now = both ? first : distance.after(0.0);
  std::vector<Slope> slopes;
  for (int i = 0; i < (both ? 3 : 4); ++i) {
    const double time = std::ldexp(step, -i);
    const PairProximity after = i == 0 ? first : distance.after(time), before = both ? distance.after(-time) : now;
    if (!isUsable(after, first) || (both && !isUsable(before, first))) return std::nullopt;
    slopes.push_back(slopeOf(after, before, both ? 2.0 * time : time));
  }
  for (std::size_t order = 1; order < slopes.size(); ++order)
    for (std::size_t i = 0; i < slopes.size() - order; ++i)
      slopes[i] = extrapolated(slopes[i], slopes[i + 1], std::pow(both ? 4.0 : 2.0, order));
  if (!(std::abs(slopes[0].value - slopes[1].value) <= kSmoothWithin)) return std::nullopt;
  return slopes[0];
}

/// Returns the first difference that agrees with the one of the next size of step.
std::optional<Difference> agreed(const DistanceAlong& distance, Sides sides) {
  std::optional<Difference> last;
  for (const double step : kSteps) {
    const std::optional<Difference> next = difference(distance, step, sides);
    if (last && next && std::abs(last->value - next->value) <= kSmoothWithin) return last;
    last = next;
  }
  return std::nullopt;
}

}  // namespace

PairProximity DistanceAlong::after(double time) const {
  Question question;
  question.tolerance = 1e-14;
  scene_.update(posesAfter(time));
  return scene_.proximity(sample_.pair, question);
}

std::optional<Difference> centralDifference(const DistanceAlong& distance) { return agreed(distance, Sides::Both); }

std::optional<Difference> forwardDifference(const DistanceAlong& distance) { return agreed(distance, Sides::Future); }

GradientObserver::GradientObserver(const GradientFamily& family, double tolerance)
    : family_(family), scene_(family.model), exact_scene_(family.model) {
  question_.tolerance = tolerance;
  row_.resize(scene_.state.degreesOfFreedom().size());
  if (!family.objects) return;
  scene_.use(family.objects);
  exact_scene_.use(family.objects);
}

GradientObservation GradientObserver::observe(unsigned seed) {
  using Kind = GradientObservation::Kind;
  Chance chance(seed);
  const GradientSample sample = family_.draw(scene_, chance);
  VectorXd velocity(row_.size());
  for (Eigen::Index i = 0; i < velocity.size(); ++i) velocity[i] = chance.between(-1.0, 1.0);
  poses_ = sample.posture.poses();
  scene_.update(poses_);
  pair_ = scene_.proximity(sample.pair, question_);
  if (!gradient(scene_.state, pair_, row_)) return {Kind::Unmoved};
  if (!pair_.result.unique) return {Kind::NotUnique, pair_.result.distance};
  velocity_ = scaledVelocity(sample, velocity);
  if (velocity_.size() == 0) return {Kind::Unmoved, pair_.result.distance};
  const auto reference =
      centralDifference(DistanceAlong(exact_scene_, scene_.state.degreesOfFreedom(), sample, velocity_));
  if (!reference) return {Kind::Kink, pair_.result.distance};
  reference_ = reference->value;
  const double error = std::abs(row_.dot(velocity_) - reference_);
  const bool is_resolved = reference->error <= kResolved;
  return {is_resolved ? Kind::Judged : Kind::Unresolved, pair_.result.distance, error, reference->error};
}

double GradientObserver::errorWith(const Vector3d& point_a, const Vector3d& point_b, const Vector3d& normal) {
  PairProximity other = pair_;
  other.result.point_a = point_a;
  other.result.point_b = point_b;
  other.result.normal = normal;
  gradient(scene_.state, other, row_);
  return std::abs(row_.dot(velocity_) - reference_);
}

/// The velocity at which the two witness points, each as a point of its body, move by 1 m/s against each other; nothing
/// where they do not.
VectorXd GradientObserver::scaledVelocity(const GradientSample& sample, const VectorXd& velocity) const {
  constexpr double kTime = 1e-5;
  const DegreesOfFreedom& columns = scene_.state.degreesOfFreedom();
  const BodyPoses before = sample.posture.moved(columns, velocity, -kTime).poses();
  const BodyPoses after = sample.posture.moved(columns, velocity, kTime).poses();
  const Vector3d shift = shiftOf(sample.pair.b, pair_.result.point_b, before, after) -
                         shiftOf(sample.pair.a, pair_.result.point_a, before, after);
  const double speed = shift.norm() / (2.0 * kTime);
  if (speed < 1e-6) return {};
  return velocity / speed;
}

/// [m] By which a point of the body that carries a shape has moved.
Vector3d GradientObserver::shiftOf(const ShapeRef& ref, const Vector3d& point, const BodyPoses& before,
                                   const BodyPoses& after) const {
  int body = -1;
  if (ref.isLink())
    body = family_.model->robot.links[ref.link()].body;
  else
    body = family_.objects->placed(ref.object())->body;
  if (body < 0) return Vector3d::Zero();
  const auto index = static_cast<std::size_t>(body);
  const Vector3d in_body = poses_[index]->inverse(Eigen::Isometry) * point;
  return *after[index] * in_body - *before[index] * in_body;
}

}  // namespace proximity_server::scene
