#include "proximity_server/scene/separation.h"

#include "proximity_server/scene/derivative/derivatives.h"
#include "scene/objects/placed_object.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace proximity_server::scene {
namespace {

using narrowphase::Status;

constexpr double kRoundedUp = 1.0 + 8.0 * std::numeric_limits<double>::epsilon();
constexpr double kMarginTolerance = 1e-4;  // [m]
constexpr int kMostScales = 12;

void requireLegal(const Tracked& who, const Objects& objects) {
  const Object* object = objects.object(who.object);
  if (!object) throw std::invalid_argument("there is no object " + std::to_string(who.object));
  if (std::holds_alternative<Attached>(object->placement))
    throw std::invalid_argument("'" + object->id + "' is held by a link and does not move on its own");
  const auto require = [&](double value, double smallest, const char* what) {
    if (!(value >= smallest) || !std::isfinite(value))
      throw std::invalid_argument("the " + std::string(what) + " of '" + object->id + "' is " + std::to_string(value));
  };
  require(who.speed, 0.0, "speed");
  require(who.near_speed, who.speed, "speed near the robot");
  require(who.older, std::numeric_limits<double>::lowest(), "age");
  require(who.intrusion, 0.0, "intrusion");
  require(who.uncertainty, 0.0, "uncertainty");
}

/// The pairs of an object with all that a joint moves.
std::vector<ShapeRefPair> pairsWith(const State& start, int object) {
  const RobotModel& robot = start.robot();
  const Objects& objects = *start.objects();
  const ShapeRef other = ShapeRef::ofObject(object);
  std::vector<ShapeRefPair> pairs;
  const auto add = [&](const ShapeRef& ref, int body) {
    if (robot.bodies[body].joint >= 0 && objects.isChecked(ref, other)) pairs.push_back({ref, other});
  };
  for (int link = 0; link < static_cast<int>(robot.links.size()); ++link)
    if (robot.hasGeometry(link)) add(ShapeRef(link), robot.links[link].body);
  for (const int held : objects.searchers())
    if (objects.placed(held)->kind == PlacedObject::Kind::Attached)
      add(ShapeRef::ofObject(held), objects.placed(held)->body);
  return pairs;
}

/// The scale and the margin of one person.
class Approach {
 public:
  Approach(const Tracked& who, MotionSearch& moving, Scene& scene, const State& start, const MovingState& state,
           const Braking& braking, const Deadline& deadline)
      : who_(who),
        moving_(moving),
        scene_(scene),
        start_(start),
        state_(state),
        braking_(braking),
        deadline_(deadline),
        pairs_(pairsWith(start, who.object)) {
    Separation& terms = found_;
    terms.reaction_time = braking.latency;
    terms.stopping_time = brakingTime(start.robot(), state.velocities, braking);
    terms.intrusion = who.intrusion;
    terms.sensor_uncertainty = who.uncertainty;
    terms.robot_uncertainty = state.largest_loss;
  }

  /// `motion` is the motion of the stop.
  Separation find(const Motion& motion) {
    found_.scale = 1.0;
    found_.status = Status::Converged;
    if (pairs_.empty()) return found_;
    if (!findNearest(motion)) return {};
    setTerms();
    if (!(found_.margin >= 0.0)) setScale();
    return found_;
  }

 private:
  /// Finds the smallest distance [m] of a stop; 0 if it leads into contact. Returns false if a pose is missing.
  bool findNearest(const Motion& motion) {
    MotionQuestion question;
    question.tolerance = kMarginTolerance;
    question.deadline = deadline_;
    const RobotTimeOfContact touch = moving_.timeOfContact(pairs_, motion, question);
    if (touch.counts.unknown > 0 || touch.status == Status::Unknown) return false;
    found_.status = touch.status;
    found_.pair = touch.pair;
    nearest_ = 0.0;
    if (touch.contact || touch.status != Status::Converged) return true;
    const RobotMinimum nearest = moving_.minimum(pairs_, motion, question);
    found_.status = nearest.status;
    found_.pair = nearest.pair;
    nearest_ = std::max(0.0, nearest.lower_bound);
    return true;
  }

  double losses() const { return who_.intrusion + who_.uncertainty + state_.largest_loss; }

  /// [s] The time of the person until the robot stands from a scale of its velocities.
  double humanTime(double scale) const {
    return std::max(0.0, who_.older + braking_.latency + scale * found_.stopping_time);
  }

  /// [m] Its way in this time.
  double humanWay(double scale) const {
    const double time = humanTime(scale);
    return kRoundedUp * std::min(who_.near_speed * time, std::max(0.0, kNearPerson - losses()) + who_.speed * time);
  }

  void setTerms() {
    const bool is_known = found_.pair.result.status != Status::Unknown;
    const PairProximity* closest = is_known ? nullptr : scene_.minimum(start_, pairs_);
    if (is_known) found_.pair = scene_.proximity(start_, found_.pair.asked);
    if (closest) found_.pair = *closest;
    found_.distance = found_.pair.result.lower_bound;
    found_.robot_speed = approachSpeed(found_.pair);
    found_.human_way = humanWay(1.0);
    found_.human_speed = found_.human_way < who_.near_speed * humanTime(1.0) ? who_.speed : who_.near_speed;
    const double way = std::max(0.0, found_.distance - nearest_);
    found_.reaction_way = std::min(way, found_.robot_speed * braking_.latency);
    found_.stopping_way = way - found_.reaction_way;
    found_.protective_distance = found_.human_way + way + losses();
    found_.margin = found_.distance - found_.protective_distance;
  }

  /// [m/s] How fast the two come nearer now.
  double approachSpeed(const PairProximity& pair) const {
    std::vector<double> row;
    gradient(start_, pair, row);
    if (row.empty()) return 0.0;
    double rate = 0.0;
    for (std::size_t joint = 0; joint < state_.velocities.size(); ++joint) {
      const DegreesOfFreedom::Columns& columns = start_.degreesOfFreedom().columnsOf(static_cast<int>(joint));
      const Joint& model = start_.robot().joints[joint];
      if (!model.mimic && hasOnePosition(model)) rate += row[columns.first] * state_.velocities[joint];
    }
    return std::max(0.0, -rate);
  }

  /// The scale with which the robot stops in time if everybody has the time of a stop from `scale`.
  VelocityScale scaleFor(double scale) {
    const PairDistances distances(0.0, losses() + humanWay(scale) - state_.largest_loss);
    return velocityScale(pairs_, moving_, scene_, start_, state_, braking_, distances, deadline_);
  }

  /// True if a link approaches that is nearer already than the way of the person in the latency alone: in a stop from
  /// kScaleTolerance of the velocities it comes nearer by more than the retreat tolerance.
  bool isTooLate() {
    Question question;
    question.threshold = losses() + humanWay(0.0);
    // [s] of the unscaled velocities, see velocityScale()
    const double length = kScaleTolerance * (braking_.latency + 0.5 * kScaleTolerance * found_.stopping_time);
    const auto approaches = [&](const PairProximity& pair) { return approachSpeed(pair) * length > kRetreatTolerance; };
    const std::vector<PairProximity>& near = scene_.below(start_, pairs_, question);
    return std::any_of(near.begin(), near.end(), approaches);
  }

  /// The scale falls as the time grows for which it is safe. So between a scale and the one that is found for it lies the
  /// one that is asked for, and the smaller of the two is safe.
  void setScale() {
    found_.scale = 0.0;
    if (isTooLate()) return;
    double safe = 0.0, high = 1.0;
    double tried = 1.0, tried_before = 1.0, found_before = 1.0;
    for (int i = 0; i < kMostScales && high - safe > kScaleTolerance; ++i) {
      const VelocityScale found = scaleFor(tried);
      found_.status = std::max(found_.status, found.status);
      if (found.status == Status::Unknown) {
        found_ = {};
        return;
      }
      safe = std::max(safe, std::min(tried, found.scale));
      high = std::max(safe, std::min(high, std::max(tried, found.scale)));
      const bool is_left_open = found.status != Status::Converged && found.scale == 0.0;  // touches a closed mesh
      if (is_left_open || deadline_.hasPassed()) {
        found_.status = std::max(found_.status, Status::IterationLimit);
        break;
      }
      const double slope = i > 0 ? (found.scale - found_before) / (tried - tried_before) : 0.0;
      tried_before = tried;
      found_before = found.scale;
      tried += (found.scale - tried) / (1.0 - slope);  // where the secant gives itself
      if (i > 0 && !(tried > safe && tried < high)) tried = 0.5 * (safe + high);
    }
    found_.scale = safe;
  }

  const Tracked& who_;
  MotionSearch& moving_;
  Scene& scene_;
  const State& start_;
  const MovingState& state_;
  const Braking& braking_;
  const Deadline& deadline_;
  const std::vector<ShapeRefPair> pairs_;
  double nearest_ = 0.0;  ///< [m]
  Separation found_;
};

}  // namespace

Separation separation(MotionSearch& moving, Scene& scene, const State& start, const MovingState& state,
                      const Braking& braking, const std::vector<Tracked>& tracked, const Deadline& deadline) {
  for (const Tracked& who : tracked) requireLegal(who, *start.objects());
  Separation worst;
  worst.status = Status::Converged;
  worst.scale = 1.0;
  const bool is_known =
      std::all_of(state.velocities.begin(), state.velocities.end(), [](double v) { return std::isfinite(v); });
  if (!is_known) return {};
  const Motion motion = stoppingMotion(start, state, braking);
  for (std::size_t i = 0; i < tracked.size(); ++i) {
    Separation found = Approach(tracked[i], moving, scene, start, state, braking, deadline).find(motion);
    if (found.status == Status::Unknown) {
      found.tracked = static_cast<int>(i);
      return found;
    }
    const double scale = std::min(worst.scale, found.scale);
    const Status status = std::max(worst.status, found.status);
    if (found.margin < worst.margin) {
      worst = found;
      worst.tracked = static_cast<int>(i);
    }
    worst.scale = scale;
    worst.status = status;
  }
  return worst;
}

}  // namespace proximity_server::scene
