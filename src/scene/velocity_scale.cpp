#include "proximity_server/scene/velocity_scale.h"

#include "proximity_server/scene/motion/limited_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {
namespace {

constexpr double kRoundedDown = 1.0 - 8.0 * std::numeric_limits<double>::epsilon();

/// The length of the way to a stop, in the time [s] that it takes at the full velocities.
struct Stop {
  double latency, braking;  ///< [s] T and tau

  double length() const { return latency + 0.5 * braking; }

  /// The scale at which the way to a stop has a given length, rounded down.
  double scaleOf(double length) const {
    if (!(length > 0.0)) return 0.0;
    const double scale = 2.0 * length / (latency + std::sqrt(latency * latency + 2.0 * braking * length));
    return std::min(1.0, kRoundedDown * scale);
  }
};

void requireCount(std::size_t count, std::size_t joints, const char* what) {
  if (count != joints)
    throw std::invalid_argument("the robot has " + std::to_string(joints) + " movable joints, but there are " +
                                std::to_string(count) + " " + what);
}

void requireLegal(const RobotModel& model, const MovingState& state, const Braking& braking,
                  const PairDistances& stop) {
  requireCount(state.velocities.size(), model.joints.size(), "velocities");
  requireCount(braking.deceleration.size(), model.joints.size(), "decelerations");
  if (!(braking.latency >= 0.0) || !std::isfinite(braking.latency))
    throw std::invalid_argument("the latency is " + std::to_string(braking.latency) + ", but must not be negative");
  for (std::size_t i = 0; i < model.joints.size(); ++i)
    if (!(braking.deceleration[i] > 0.0))
      throw std::invalid_argument("the deceleration of joint " + model.joints[i].name + " is " +
                                  std::to_string(braking.deceleration[i]) + ", but must be positive");
  if (!stop.areFinite()) throw std::invalid_argument("the stop distances must be finite");
  if (!(state.largest_loss >= 0.0) || !std::isfinite(state.largest_loss))
    throw std::invalid_argument("how far the distances may be off is " + std::to_string(state.largest_loss) +
                                ", but must be finite and not negative");
  for (const RobotMotion::Segment& frame : state.frames.moving)
    if (frame.is_known && !frame.motion.isRest()) throw std::invalid_argument("a frame of objects moves on its own");
  if (state.frames.world.is_known && !state.frames.world.motion.isRest())
    throw std::invalid_argument("the world moves on its own");
}

/// The velocities of the joints that are leaders. All others are ignored, and are set to 0.
std::vector<double> leadersOnly(const RobotModel& model, std::vector<double> velocities) {
  for (std::size_t i = 0; i < model.joints.size(); ++i)
    if (model.joints[i].mimic || !hasOnePosition(model.joints[i])) velocities[i] = 0.0;
  return velocities;
}

bool areFinite(const std::vector<double>& velocities) {
  return std::all_of(velocities.begin(), velocities.end(), [](double v) { return std::isfinite(v); });
}

Stop stopOf(const RobotModel& model, const std::vector<double>& velocities, const Braking& braking) {
  Stop stop{braking.latency, 0.0};
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint::Mimic leader = model.leaderOf(static_cast<int>(i));
    const double own = std::abs(leader.multiplier * velocities[leader.joint]);
    stop.braking = std::max(stop.braking, own / braking.deceleration[i]);
  }
  return stop;
}

/// The motion for a length [s] at constant velocities; a joint stops at its limit.
LimitedMotion motionAlong(const State& start, const MovingState& state, std::vector<double> velocities, double length) {
  for (double& joint : velocities) joint *= length;
  LimitedMotion limited = motionWithinLimits(start.robot(), start.poses(), velocities, state.positions);
  limited.motion.carryObjects(state.frames);
  return limited;
}

/// Returns whether it is known how far the inequalities are from being broken, of which a joint moves.
bool areInequalitiesKnown(const State& start, const MovingState& state, const std::vector<double>& velocities) {
  const RobotModel& model = start.robot();
  const auto moves = [&](const JointInequality::Term& term) { return velocities[term.joint] != 0.0; };
  return std::all_of(model.inequalities.begin(), model.inequalities.end(), [&](const JointInequality& inequality) {
    return std::none_of(inequality.terms.begin(), inequality.terms.end(), moves) ||
           excessAt(model, inequality, start.poses(), state.positions);
  });
}

/// Searches for the first pair at its stop distance.
class StopSearch {
 public:
  StopSearch(const Pairs& pairs, MotionSearch& moving, Scene& scene, const State& start, const PairDistances& stop,
             double largest_loss, const Deadline& deadline)
      : pairs_(pairs), moving_(moving), scene_(scene), start_(start) {
    question_.contact_distance = largest_loss;
    question_.thresholds = &stop;
    question_.tolerance = 0.25 * kRetreatTolerance;
    question_.deadline = deadline;
  }

  RobotTimeOfContact contact(const Motion& motion) {
    Question near;
    near.threshold = question_.contact_distance + kRetreatTolerance;
    near.thresholds = question_.thresholds;
    near.deadline = question_.deadline;
    near_ = scene_.below(start_, pairs_, near);
    for (const PairProximity& pair : near_)
      question_.nearer_pairs.push_back({pair.asked, pair.result.upper_bound - kRetreatTolerance});
    const RobotTimeOfContact found = moving_.timeOfContact(pairs_, motion, question_);
    const bool is_left_open = found.status != narrowphase::Status::Converged && found.t_free == 0.0;
    return is_left_open && leaveOutRetreats(motion) ? moving_.timeOfContact(pairs_, motion, question_) : found;
  }

  /// The pair of a contact as it is at the start, if it is one of those that are too near at the start; otherwise
  /// nullptr.
  const PairProximity* nearAtStart(const PairProximity& pair) const {
    const auto isIt = [&](const PairProximity& near) { return near.asked.isSameAs(pair.asked); };
    const auto found = std::find_if(near_.begin(), near_.end(), isIt);
    return found == near_.end() ? nullptr : &*found;
  }

  /// True if a pair that comes nearer than at the start does so already in the first half of its way. Even if the
  /// approach begins without velocity, the pair has come nearer by a quarter of kRetreatTolerance after half of the
  /// way, and only a sixteenth is asked for.
  bool approaches(const PairProximity& near, const Motion& first_half) {
    MotionQuestion question = question_;
    question.tolerance = kRetreatTolerance / 100.0;
    const std::vector<ShapeRefPair> pair{near.asked};
    return moving_.minimum(pair, first_half, question).lower_bound < near.result.upper_bound - kRetreatTolerance / 16.0;
  }

 private:
  /// Contacts of overlaps with closed meshes are left open. This leaves out those that come no nearer during the whole
  /// motion. Returns true if there are any.
  bool leaveOutRetreats(const Motion& motion) {
    MotionQuestion question = question_;
    question.nearer_pairs.clear();
    bool is_any = false;
    for (PairContactDistance& own : question_.nearer_pairs) {
      const std::vector<ShapeRefPair> pair{own.pair};
      if (own.contact_distance >= 0.0 || !(moving_.minimum(pair, motion, question).lower_bound > own.contact_distance))
        continue;
      own.contact_distance = -std::numeric_limits<double>::infinity();
      is_any = true;
    }
    return is_any;
  }

  const Pairs& pairs_;
  MotionSearch& moving_;
  Scene& scene_;
  const State& start_;
  MotionQuestion question_;
  std::vector<PairProximity> near_;
};

/// The scale with which all pairs stay above their stop distances. `motion` is the way to the stop.
VelocityScale scaleOfPairs(StopSearch& search, const State& start, const MovingState& state,
                           const std::vector<double>& velocities, const Stop& to_stop, const Motion& motion) {
  const bool rests =
      to_stop.length() == 0.0 || std::all_of(velocities.begin(), velocities.end(), [](double v) { return v == 0.0; });
  const RobotTimeOfContact found = search.contact(motion);
  if (found.counts.unknown > 0) return {};
  if (found.counts.pairs == 0 || rests || !(found.t_free < 1.0)) return {narrowphase::Status::Converged, 1.0, {}};
  const double free = kRoundedDown * found.t_free * to_stop.length();
  const bool ends_in_contact = found.contact && found.status == narrowphase::Status::Converged;
  const PairProximity* near = ends_in_contact ? search.nearAtStart(found.pair) : nullptr;
  if (near && search.approaches(*near, motionAlong(start, state, velocities, 0.5 * free).motion))
    return {found.status, 0.0, *near};
  return {found.status, to_stop.scaleOf(free), ends_in_contact ? found.pair : PairProximity()};
}

/// The scale with which the robot stops before it breaks an inequality.
double scaleOfInequalities(const State& start, const MovingState& state, const std::vector<double>& velocities,
                           const Stop& to_stop) {
  if (start.robot().inequalities.empty()) return 1.0;
  const Stop since_poses{to_stop.latency + state.age, to_stop.braking};
  const auto broken = motionAlong(start, state, velocities, since_poses.length()).broken;
  return broken ? since_poses.scaleOf(kRoundedDown * broken->time * since_poses.length()) : 1.0;
}

}  // namespace

std::vector<double> stoppingTravel(const RobotModel& model, const std::vector<double>& velocities,
                                   const Braking& braking) {
  std::vector<double> travel = leadersOnly(model, velocities);
  const double length = stopOf(model, travel, braking).length();
  for (double& joint : travel) joint = std::abs(joint) * length;
  return travel;
}

double brakingTime(const RobotModel& model, const std::vector<double>& velocities, const Braking& braking) {
  return stopOf(model, leadersOnly(model, velocities), braking).braking;
}

Motion stoppingMotion(const State& start, const MovingState& state, const Braking& braking) {
  requireLegal(start.robot(), state, braking, {});
  const std::vector<double> velocities = leadersOnly(start.robot(), state.velocities);
  return motionAlong(start, state, velocities, stopOf(start.robot(), velocities, braking).length()).motion;
}

VelocityScale velocityScale(const Pairs& pairs, MotionSearch& moving, Scene& scene, const State& start,
                            const MovingState& state, const Braking& braking, const PairDistances& stop,
                            const Deadline& deadline) {
  const RobotModel& model = scene.model().robot;
  requireLegal(model, state, braking, stop);
  const std::vector<double> velocities = leadersOnly(model, state.velocities);
  if (!areFinite(velocities)) return {};
  const Stop to_stop = stopOf(model, velocities, braking);
  const Motion motion = motionAlong(start, state, velocities, to_stop.length()).motion;
  StopSearch search(pairs, moving, scene, start, stop, state.largest_loss, deadline);
  return scaleOfPairs(search, start, state, velocities, to_stop, motion);
}

VelocityScale velocityScale(MotionSearch& moving, Scene& scene, const State& start, const MovingState& state,
                            const Braking& braking, const PairDistances& stop, const Deadline& deadline) {
  const RobotModel& model = scene.model().robot;
  requireLegal(model, state, braking, stop);
  const std::vector<double> velocities = leadersOnly(model, state.velocities);
  if (!areFinite(velocities) || !areInequalitiesKnown(start, state, velocities)) return {};

  const VelocityScale of_pairs =
      velocityScale(Pairs(scene.candidates()), moving, scene, start, state, braking, stop, deadline);
  const double of_inequalities = scaleOfInequalities(start, state, velocities, stopOf(model, velocities, braking));
  if (of_pairs.status == narrowphase::Status::Unknown || of_pairs.scale <= of_inequalities) return of_pairs;
  return {narrowphase::Status::Converged, of_inequalities, {}};
}

}  // namespace proximity_server::scene
