#include "stress/stop_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "proximity_server/scene/derivative/velocity_scale.h"
#include "scene/derivative/moved_robot.h"
#include "stress/controlled_robots.h"
#include "stress/rounds.h"

namespace proximity_server::scene {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kSteps = 24;  // of a stop

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Parts of the time of a stop.
std::vector<double> evenSteps() {
  std::vector<double> steps;
  for (int i = 1; i <= kSteps; ++i) steps.push_back(static_cast<double>(i) / kSteps);
  return steps;
}

/// The same, each 2 % longer than the one before.
std::vector<double> stepsFromTheStart() {
  std::vector<double> steps;
  for (double step = 1e-8; step < 1.0; step *= 1.02) steps.push_back(step);
  steps.push_back(1.0);
  return steps;
}

/// A stop as the robot makes it.
struct Braked {
  double latency, braking;  ///< [s] with the unscaled velocities

  double duration(double scale) const { return latency + scale * braking; }

  /// [s] How long the unscaled velocities would need to get as far as the robot got after a time.
  double wayAfter(double time, double scale) const {
    if (time <= latency) return scale * time;
    const double since = time - latency;
    return scale * latency + scale * since - 0.5 * since * since / braking;
  }
};

class Cell {
 public:
  Cell(const ControlFamily& family, Chance chance, StopSummary& summary)
      : chance_(chance),
        model_(family.robot ? family.robot : someRobot(chance_)),
        scene_(model_),
        moving_(model_),
        summary_(summary) {
    if (!family.has_objects) return;
    objects_ = someObjects(model_, chance_);
    scene_.use(objects_);
    moving_.use(objects_);
  }

  void observe() {
    for (int i = 0; i < kStopsOfCell && failure.empty(); ++i) {
      if (i % 5 == 0) choosePositions();
      chooseStop();
      observeStop();
    }
  }

  std::string failure;

 private:
  using Key = std::tuple<int, int, int, int>;
  static Key keyOf(const ShapeRefPair& pair) {
    return {pair.a.link(), pair.a.object(), pair.b.link(), pair.b.object()};
  }

  void choosePositions() {
    positions_.assign(model_->robot.joints.size(), 0.0);
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      const Joint& joint = model_->robot.joints[i];
      positions_[i] = chance_.between(std::max(joint.lower, -3.0), std::min(joint.upper, 3.0));
    }
    frames_.clear();
    if (objects_) frames_ = someFrames(*objects_, chance_);
  }

  void chooseStop() {
    const std::size_t joints = positions_.size();
    state_ = {};
    state_.poses = forwardKinematics(model_->robot, positions_);
    state_.velocities.assign(joints, 0.0);
    for (const std::optional<Eigen::Isometry3d>& frame : frames_)
      state_.frames.moving.push_back(RobotMotion::atRest(frame));
    state_.positions.assign(positions_.begin(), positions_.end());
    braking_.latency = chance_.below(4) == 0 ? 0.0 : chance_.between(0.0, 0.2);
    braking_.deceleration.assign(joints, 0.0);
    const int only = chance_.below(2) == 0 ? -1 : chance_.below(static_cast<int>(joints));
    for (std::size_t i = 0; i < joints; ++i) {
      if (only < 0 || only == static_cast<int>(i)) state_.velocities[i] = chance_.between(-2, 2);
      braking_.deceleration[i] = chance_.between(0.5, 10.0);
    }
    place(state_.poses);
    const auto nearestOf = [&](PairKind kind) {
      const PairProximity* nearest = scene_.minimum(Pairs(scene_.candidates(), kind));
      return nearest ? nearest->result.lower_bound : 0.0;
    };
    const auto beside = [&](double distance) {
      const double choices[] = {distance - chance_.between(0, 0.2), distance - 1e-4, distance + 1e-7,
                                distance + chance_.between(0, 0.1)};
      // Below 0 there is no first contact of closed meshes.
      const double chosen = choices[chance_.below(4)];
      return chosen < 0.0 && chance_.below(8) != 0 ? chance_.between(0, 0.05) : chosen;
    };
    stop_ = {beside(nearestOf(PairKind::OfLinks)), objects_ ? beside(nearestOf(PairKind::WithObject)) : 0.0};
  }

  void place(const BodyPoses& poses) { objects_ ? scene_.update(poses, frames_) : scene_.update(poses); }

  double stopDistanceOf(const ShapeRefPair& pair) const { return !pair.areLinks() ? stop_.objects : stop_.links; }

  /// Where the joints are after they moved as long as the velocities need for a way; at their limits they rest.
  BodyPoses posesAfter(double way) const {
    std::vector<double> positions = positions_;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const Joint& joint = model_->robot.joints[i];
      if (hasOnePosition(joint))
        positions[i] = std::clamp(positions[i] + way * state_.velocities[i], joint.lower, joint.upper);
    }
    return forwardKinematics(model_->robot, positions);
  }

  /// All pairs below a distance [m] of each kind above the stop distances.
  std::map<Key, PairProximity> near(double above) {
    std::map<Key, PairProximity> pairs;
    for (const PairKind kind : {PairKind::OfLinks, PairKind::WithObject}) {
      Question question;
      question.threshold = (kind == PairKind::OfLinks ? stop_.links : stop_.objects) + above;
      for (const PairProximity& pair : scene_.below(Pairs(scene_.candidates(), kind), question))
        pairs.emplace(keyOf(pair.asked), pair);
    }
    return pairs;
  }

  Braked brakes() const {
    Braked result{braking_.latency, 0.0};
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      const Joint& joint = model_->robot.joints[i];
      if (!hasOnePosition(joint)) continue;
      const Joint::Mimic leader = model_->robot.leaderOf(static_cast<int>(i));
      const double speed = std::abs(leader.multiplier * state_.velocities[static_cast<std::size_t>(leader.joint)]);
      result.braking = std::max(result.braking, speed / braking_.deceleration[i]);
    }
    return result;
  }

  void observeStop() {
    const auto start = Clock::now();
    const VelocityScale answer = velocityScale(moving_, scene_, state_, braking_, stop_);
    summary_.microseconds += 1e6 * secondsSince(start);
    ++summary_.stops;
    summary_.slowed += answer.scale > 0.0 && answer.scale < 1.0 ? 1 : 0;
    summary_.halted += answer.scale == 0.0 ? 1 : 0;
    summary_.open += answer.status != narrowphase::Status::Converged ? 1 : 0;
    if (answer.status == narrowphase::Status::Unknown) failure = "a scale is unknown";
    place(state_.poses);
    const std::map<Key, PairProximity> too_near = near(kRetreatTolerance);
    if (answer.scale > 0.0) stopFrom(answer.scale, too_near);
    const bool is_retreat = isRetreat(too_near, evenSteps());
    summary_.retreats += is_retreat && !too_near.empty() ? 1 : 0;
    if (answer.scale == 1.0 || !is_retreat) return;
    // A depth may grow at first, until another direction is the shortest way out.
    if (answer.status == narrowphase::Status::Converged && isRetreat(too_near, stepsFromTheStart()))
      failure = "a retreat is slowed to " + std::to_string(answer.scale);
    const bool is_below_zero = stop_.links < 0.0 || stop_.objects < 0.0;
    summary_.unneeded += answer.status == narrowphase::Status::Converged || is_below_zero ? 0 : 1;
  }

  void stopFrom(double scale, const std::map<Key, PairProximity>& too_near) {
    const Braked brake = brakes();
    for (int step = 0; step <= kSteps && failure.empty(); ++step) {
      place(posesAfter(brake.wayAfter(brake.duration(scale) * step / kSteps, scale)));
      for (const auto& [key, pair] : near(0.0)) {
        const auto before = too_near.find(key);
        const double least = before == too_near.end() ? stopDistanceOf(pair.asked)
                                                      : std::min(stopDistanceOf(pair.asked),
                                                                 before->second.result.lower_bound - kRetreatTolerance);
        if (pair.result.upper_bound < least - kRounding)
          failure = "a stop leads below the distance by " + std::to_string(1e9 * (least - pair.result.upper_bound)) +
                    " nm, the scale is " + std::to_string(scale);
      }
    }
  }

  /// Whether every pair that is too near only goes away during the whole unscaled stop, and no other one comes near.
  bool isRetreat(const std::map<Key, PairProximity>& too_near, const std::vector<double>& steps) {
    constexpr double kMargin = 1e-3;  // [m] by which others stay away
    const Braked brake = brakes();
    std::map<Key, double> last;
    for (const auto& [key, pair] : too_near) last[key] = pair.result.lower_bound - 1e-9;
    for (const double step : steps) {
      place(posesAfter(brake.wayAfter(brake.duration(1.0) * step, 1.0)));
      for (const auto& [key, pair] : near(kMargin)) {
        const auto before = last.find(key);
        if (before == last.end() || pair.result.lower_bound < before->second) return false;
        before->second = pair.result.lower_bound - 1e-9;
      }
    }
    return true;
  }

  // [m] The poses of a motion are products of screws, and those of forwardKinematics() of its joints: both are rounded, in lengths
  // of a few metres.
  static constexpr double kRounding = 1e-13;

  Chance chance_;
  const std::shared_ptr<const SceneModel> model_;
  Scene scene_;
  MovingScene moving_;
  std::shared_ptr<const Objects> objects_;
  std::vector<double> positions_;
  FramePoses frames_;
  MovingState state_;
  Braking braking_;
  PairDistances stop_;
  StopSummary& summary_;
};

}  // namespace

void StopSummary::merge(const StopSummary& other) {
  stops += other.stops;
  slowed += other.slowed;
  halted += other.halted;
  retreats += other.retreats;
  open += other.open;
  unneeded += other.unneeded;
  microseconds += other.microseconds;
  seconds += other.seconds;
  failed += other.failed;
  failures.insert(failures.end(), other.failures.begin(), other.failures.end());
}

std::vector<StopSummary> runStops(const StopRun& run, std::atomic<std::int64_t>& done) {
  const narrowphase::Rounds rounds(controlFamilies(), run.family, static_cast<double>(run.stops) / kStopsOfCell);
  return rounds.observe<StopSummary>(run.threads, [&](std::size_t family, std::int64_t number, StopSummary& summary) {
    const auto start = Clock::now();
    const std::int64_t before = summary.stops;
    Cell cell(controlFamilies()[family], chanceOf(run.seed, family, number), summary);
    cell.observe();
    summary.seconds += secondsSince(start);
    done += summary.stops - before;
    if (cell.failure.empty()) return;
    ++summary.failed;
    if (summary.failures.size() < narrowphase::kFailuresKept) summary.failures.push_back({number, cell.failure});
  });
}

}  // namespace proximity_server::scene
