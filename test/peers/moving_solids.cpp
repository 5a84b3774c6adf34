#include "peers/moving_solids.h"

#include "proximity_server/narrowphase/shape/support.h"
#include "proximity_server/narrowphase/signed_distance.h"

#include <fcl/math/motion/interp_motion.h>
#include <fcl/math/motion/screw_motion.h>
#include <fcl/math/motion/translation_motion.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace proximity_server::peers {

using namespace narrowphase;
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kApartAtStart = 0.05;  // [m]
constexpr double kGraze = 1e-3;         // [m]
constexpr double kShortest = 1e-13;     // of the time: the distance cannot be told apart from that of later

RigidMotion motionOf(MotionKind kind, double slowest, double fastest, double turn, Random& random) {
  RigidMotion motion{kind, Isometry3d(randomTurn(random)), random.between(slowest, fastest) * randomAxis(random),
                     Vector3d::Zero()};
  if (kind != MotionKind::Translation) motion.angular = random.between(0.0, turn) * randomAxis(random);
  return motion;
}

/// Returns a point well inside of a solid, in its frame.
Vector3d innerPoint(const Solid& solid, Random& random) {
  const Vector3d along = randomAxis(random);
  int vertex = 0;
  return random.between(0.0, 0.9) * (supportPoint(solid.ours, along, vertex) + solid.ours.margin() * along);
}

/// Returns a motion of both in which a point of b meets a point of a at one time.
MovingSolidPair meeting(const Solid& a, const Solid& b, MotionKind kind, Random& random) {
  const RigidMotion a_motion = motionOf(kind, 0.0, 0.5, 1.0, random);
  RigidMotion b_motion = motionOf(kind, 2.0, 4.0, 2.5, random);
  const double time = random.between(0.4, 0.9);
  const Vector3d on_a = poseAt(chainOf(a_motion), time) * innerPoint(a, random);
  const Vector3d on_b = poseAt(chainOf(b_motion), time) * innerPoint(b, random);
  b_motion.start.pretranslate(on_a - on_b);
  return {MovingSolid(a, a_motion), MovingSolid(b, b_motion)};
}

/// Moves the whole motion of b aside until the smallest signed distance is `wanted`. Returns nullopt if that fails.
std::optional<MovingSolidPair> pushedTo(MovingSolidPair pair, double wanted, double accuracy) {
  for (int i = 0; i < 30; ++i) {
    const Lowest lowest = lowestOf(pair, 64);
    const double step = wanted - lowest.distance;
    const bool at_end = lowest.time < 0.02 || lowest.time > 0.98;
    if (std::abs(step) < accuracy) return at_end ? std::nullopt : std::optional(pair);
    const Vector3d normal = poseAt(pair.a.ours, lowest.time).linear() * signedDistanceAt(pair, lowest.time).normal;
    RigidMotion moved = pair.b.motion;
    moved.start.pretranslate(step * normal);
    pair.b = MovingSolid(*pair.b.solid, moved);
  }
  return std::nullopt;
}

std::optional<MovingSolidPair> withOutcome(const MovingSolidPair& pair, Outcome outcome, Random& random) {
  if (outcome == Outcome::Miss) return pushedTo(pair, random.between(0.02, 0.3), 1e-3);
  if (outcome == Outcome::Grazing) return pushedTo(pair, random.between(-kGraze, kGraze), 1e-6);
  return pair;
}

/// Returns a lower bound of the distance; 0 or less is an overlap, of any depth.
double certifiedDistance(const MovingSolidPair& pair, double time) {
  Options options = Options::apart();
  options.distance_tolerance = 1e-13;
  return signedDistanceAt(pair, time, options).lower_bound;
}

class FirstContactSearch {
 public:
  explicit FirstContactSearch(const MovingSolidPair& pair) : pair_(pair), speed_(pair.speedBound()) {}

  struct Sample {
    double time, distance;
  };
  Sample at(double time) const { return {time, certifiedDistance(pair_, time)}; }

  FirstContact between(const Sample& begin, const Sample& end) const {
    const FirstContact none{false, 1.0, 1.0};
    if (begin.distance <= 0.0) return {true, begin.time, begin.time};
    if (end.distance > 0.0 && begin.distance + end.distance > speed_ * (end.time - begin.time)) return none;
    if (end.time - begin.time <= kShortest) return {true, begin.time, end.time};
    const Sample middle = at(0.5 * (begin.time + end.time));
    const FirstContact earlier = between(begin, middle);
    return earlier.contact ? earlier : between(middle, end);
  }

 private:
  const MovingSolidPair& pair_;
  double speed_;
};

Lowest goldenSection(const MovingSolidPair& pair, double begin, double end) {
  const double ratio = 0.5 * (std::sqrt(5.0) - 1.0);
  const auto at = [&](double time) { return signedDistanceAt(pair, time).distance; };
  double left = end - ratio * (end - begin), right = begin + ratio * (end - begin);
  double at_left = at(left), at_right = at(right);
  while (end - begin > 1e-9) {
    if (at_left <= at_right) {
      end = right, right = left, at_right = at_left;
      left = end - ratio * (end - begin), at_left = at(left);
    } else {
      begin = left, left = right, at_left = at_right;
      right = begin + ratio * (end - begin), at_right = at(right);
    }
  }
  return at_left <= at_right ? Lowest{at_left, left} : Lowest{at_right, right};
}

}  // namespace

MotionChain chainOf(const RigidMotion& motion) {
  if (motion.kind != MotionKind::Linear) return {{motion.start, motion.linear, motion.angular}};
  const Vector3d in_own_frame = motion.start.linear().transpose() * motion.angular;
  return {{motion.start, motion.linear, Vector3d::Zero()}, {Isometry3d::Identity(), Vector3d::Zero(), in_own_frame}};
}

std::shared_ptr<const fcl::MotionBased> fclMotionOf(const RigidMotion& motion) {
  const Isometry3d end = poseAt(chainOf(motion), 1.0);
  switch (motion.kind) {
    case MotionKind::Translation:
      return std::make_shared<fcl::TranslationMotiond>(motion.start, end);
    case MotionKind::Linear:
      // With the origin as reference point: the constructor from two poses leaves that point unset.
      return std::make_shared<fcl::InterpMotion<double>>(motion.start.linear(), motion.start.translation(),
                                                         end.linear(), end.translation(), Vector3d::Zero());
    case MotionKind::Screw:
      break;
  }
  return std::make_shared<fcl::ScrewMotion<double>>(motion.start, end);
}

MovingSolid::MovingSolid(const Solid& moved, const RigidMotion& its_motion)
    : solid(&moved), motion(its_motion), ours(chainOf(its_motion)), fcl(fclMotionOf(its_motion)) {}

double MovingSolid::speedBound() const {
  // The origin's speed is constant, along a helix too.
  return motion.linear.norm() + motion.angular.norm() * (solid->ours.coreReach() + solid->ours.margin());
}

Isometry3d MovingSolidPair::poseOfBInA(double time) const {
  return poseAt(a.ours, time).inverse(Eigen::Isometry) * poseAt(b.ours, time);
}

SignedDistance signedDistanceAt(const MovingSolidPair& pair, double time, const Options& options) {
  return signedDistance(pair.a.solid->ours, pair.b.solid->ours, pair.poseOfBInA(time), options);
}

MovingSolidPair randomMotion(const Solid& a, const Solid& b, MotionKind kind, Outcome outcome, Random& random) {
  for (;;) {
    const std::optional<MovingSolidPair> pair = withOutcome(meeting(a, b, kind, random), outcome, random);
    if (pair && signedDistanceAt(*pair, 0.0).distance >= kApartAtStart) return *pair;
  }
}

FirstContact firstContactOf(const MovingSolidPair& pair) {
  const FirstContactSearch search(pair);
  return search.between(search.at(0.0), search.at(1.0));
}

Lowest lowestOf(const MovingSolidPair& pair, int samples) {
  const double step = 1.0 / samples;
  std::vector<Lowest> sampled;
  for (int i = 0; i <= samples; ++i) sampled.push_back({signedDistanceAt(pair, i * step).distance, i * step});
  std::partial_sort(sampled.begin(), sampled.begin() + 3, sampled.end(),
                    [](const Lowest& one, const Lowest& other) { return one.distance < other.distance; });
  Lowest lowest = sampled.front();
  for (int i = 0; i < 3; ++i) {
    const double time = sampled[i].time;
    const Lowest valley = goldenSection(pair, std::max(0.0, time - step), std::min(1.0, time + step));
    if (valley.distance < lowest.distance) lowest = valley;
  }
  return lowest;
}

}  // namespace proximity_server::peers
