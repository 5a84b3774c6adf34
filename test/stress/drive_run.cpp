#include "stress/drive_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "proximity_server/scene/derivative/constraint_rows.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "scene/example_robots.h"
#include "stress/rounds.h"
#include "stress/yielding_velocity.h"

namespace proximity_server::scene {
namespace {

using Clock = std::chrono::steady_clock;
using Eigen::VectorXd;

constexpr double kStep = 0.01;                    // [s]
constexpr double kApproach = 2.0;                 // [1/s]
constexpr double kMaxSpeed = 0.5;                 // [rad/s, m/s] the norm of the wanted velocity
constexpr double kAllowance = 0.02;               // [m/s]
constexpr double kAtRest = 1e-3;                  // [rad/s, m/s]
constexpr double kArrived = 1e-2;                 // [rad, m]
constexpr double kNoticed = 0.02;                 // [rad/s, m/s] slower, a change of direction is none
constexpr double kOftenest = 5.0;                 // [1/s] changes of direction
constexpr double kLoss = 1e-4;                    // [m] what a step may lose before the rows make up for it
constexpr int kRows = 80;                         // more than are ever needed
constexpr double kStop = 0.02, kInfluence = 0.1;  // [m] as the node's defaults

struct DriveFamily {
  std::string name;
  int rarity;
  std::shared_ptr<const SceneModel> robot;
  VelocityDamper damper{{kStop, kStop}, kInfluence, 0.5};
  std::set<std::pair<int, int>> near_by_design{};  // pairs of links that are below the stop distance in most states
};

/// The stop distances of pairs that are near by design.
enum class Thresholds : unsigned char { Default, Own };

std::pair<int, int> keyOf(const ShapeRefPair& pair) { return std::minmax(pair.a.link(), pair.b.link()); }

VectorXd randomState(const RobotModel& robot, const DegreesOfFreedom& columns, Chance& chance) {
  VectorXd state = VectorXd::Zero(columns.size());
  for (int column = 0; column < columns.size(); ++column) {
    const Joint& joint = robot.joints[columns[column].joint];
    if (hasOnePosition(joint)) state[column] = chance.between(std::max(joint.lower, -3.0), std::min(joint.upper, 3.0));
  }
  return state;
}

BodyPoses posesOf(const RobotModel& robot, const DegreesOfFreedom& columns, const VectorXd& state) {
  std::vector<double> positions(robot.joints.size(), 0.0);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Joint::Mimic leader = robot.leaderOf(static_cast<int>(i));
    if (hasOnePosition(robot.joints[static_cast<std::size_t>(leader.joint)]))
      positions[i] = leader.offset + leader.multiplier * state[columns.columnsOf(leader.joint).first];
  }
  return forwardKinematics(robot, positions);
}

DriveFamily familyOf(const std::string& name, int rarity, RobotModel robot, const std::string& srdf,
                     const PairFilterOptions& options = {}, Thresholds thresholds = Thresholds::Default) {
  constexpr int kStates = 300;
  DriveFamily family{name, rarity, std::make_shared<const SceneModel>(makeSceneModel(std::move(robot), srdf, options))};
  const DegreesOfFreedom columns(family.robot->robot);
  Scene scene(family.robot);
  Chance chance(1);
  struct Seen {
    int times = 0;
    double smallest = kStop;
  };
  std::map<std::pair<int, int>, Seen> seen;
  Question question;
  question.threshold = kStop;
  for (int i = 0; i < kStates; ++i) {
    scene.update(posesOf(family.robot->robot, columns, randomState(family.robot->robot, columns, chance)));
    for (const PairProximity& pair : scene.below(scene.candidates(), question)) {
      Seen& of_pair = seen[keyOf(pair.asked)];
      ++of_pair.times;
      of_pair.smallest = std::min(of_pair.smallest, pair.result.distance);
    }
  }
  for (const auto& [pair, of_pair] : seen) {
    if (2 * of_pair.times < kStates) continue;
    if (thresholds == Thresholds::Own)
      family.damper.stop.setPair(pair.first, pair.second, 0.5 * std::max(0.0, of_pair.smallest));
    else
      family.near_by_design.insert(pair);
  }
  return family;
}

/// What pair_audit --write disables of a UR10, which has no SRDF of its own.
PairFilterOptions auditOfUr10() {
  PairFilterOptions options;
  options.exclude_pairs = {{"base_link", "upper_arm_link"},   {"base_link", "wrist_1_link"},
                           {"shoulder_link", "wrist_1_link"}, {"shoulder_link", "wrist_2_link"},
                           {"wrist_1_link", "wrist_3_link"},  {"wrist_1_link", "ee_link"},
                           {"wrist_2_link", "ee_link"}};
  return options;
}

std::vector<DriveFamily> allFamilies() {
  const std::string demo = PROXIMITY_SOURCE_DIR "/config/demo/robot";
  std::vector<DriveFamily> families;
  families.push_back(
      familyOf("demo", 1,
               loadRobotModel(readFile(demo + ".urdf"), packageResolver({PROXIMITY_SOURCE_DIR "/.."}), quickLoading()),
               readFile(demo + ".srdf")));
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) return families;
  const auto load = [&](const char* file) {
    return loadRobotModel(readFile(exampleRobotFile(resolve, file)), resolve, quickLoading());
  };
  const auto srdf = [&](const char* file) { return readFile(exampleRobotFile(resolve, file)); };
  families.push_back(
      familyOf("Panda", 1, load("panda_description/urdf/panda.urdf"), srdf("panda_description/srdf/panda.srdf")));
  if (kIsSanitized) return families;
  const RobotModel ur10 = load("ur_description/urdf/ur10_robot.urdf");
  families.push_back(familyOf("Ur10", 1, ur10, "", auditOfUr10(), Thresholds::Own));
  families.push_back(familyOf("Ur10, defaults", 1, ur10, "", auditOfUr10()));
  families.push_back(familyOf("Ur10, no SRDF", 1, ur10, ""));
  families.push_back(familyOf("Ur5, no SRDF", 1, load("ur_description/urdf/ur5_robot.urdf"), ""));
  families.push_back(familyOf("Baxter", 2, load("baxter_description/urdf/baxter.urdf"),
                              srdf("baxter_description/srdf/baxter_manipulation.srdf")));
  families.push_back(familyOf("Pr2", 2, load("pr2_description/urdf/pr2.urdf"), srdf("pr2_description/srdf/pr2.srdf")));
  return families;
}

const std::vector<DriveFamily>& driveFamilies() {
  static const std::vector<DriveFamily> families = allFamilies();
  return families;
}

/// As src/demo/avoiding_controller/remembered_rows.py, where it is explained, with the same constants.
class RememberedRows {
 public:
  using Key = std::pair<int, int>;
  struct Place {
    VectorXd gradient;
    double distance;
    VectorXd state;
  };

  /// The gradients to heed as well.
  std::vector<std::pair<Key, VectorXd>> update(const std::map<Key, Place>& latest) {
    std::map<Key, std::vector<Place>> others;
    std::vector<std::pair<Key, VectorXd>> gradients;
    for (const auto& [pair, now] : latest) {
      std::vector<Place>& kept = others[pair];
      const auto previous = latest_.find(pair);
      if (previous != latest_.end()) keep(previous->second, now, kept);
      for (const Place& place : others_[pair]) keep(place, now, kept);
      for (const Place& place : kept) gradients.emplace_back(pair, place.gradient);
    }
    others_ = std::move(others);
    latest_ = latest;
    return gradients;
  }

 private:
  static constexpr std::size_t kMost = 4;
  static constexpr double kSame = 0.02, kChange = 20.0, kMostAlike = 0.1, kBand = 1e-3, kReach = 0.1;

  static void keep(const Place& place, const Place& now, std::vector<Place>& kept) {
    const auto is_another = [&](const Place& other) { return jumps(place, other); };
    if (kept.size() < kMost && isAboutAsNear(place, now) && is_another(now) &&
        std::all_of(kept.begin(), kept.end(), is_another))
      kept.push_back(place);
  }
  static bool jumps(const Place& place, const Place& other) {
    const double norm = std::max(other.gradient.norm(), place.gradient.norm());
    const double same = std::min(kSame + kChange * (other.state - place.state).norm(), kMostAlike);
    return (other.gradient - place.gradient).norm() > same * norm;
  }
  static bool isAboutAsNear(const Place& place, const Place& now) {
    const VectorXd way = now.state - place.state;
    return place.distance + place.gradient.dot(way) <= now.distance + kBand && way.norm() <= kReach;
  }

  std::map<Key, Place> latest_;
  std::map<Key, std::vector<Place>> others_;
};

class Drive {
 public:
  Drive(const DriveFamily& family, Chance chance, DriveSummary& summary)
      : family_(family),
        chance_(chance),
        robot_(family.robot->robot),
        columns_(robot_),
        scene_(family.robot),
        derivatives_(family.robot),
        rows_(family.robot, kRows),
        summary_(summary) {
    const Eigen::Index joints = columns_.size();
    lower_.setZero(joints), upper_.setZero(joints), speeds_.setZero(joints);
    for (int column = 0; column < columns_.size(); ++column) {
      const Joint& joint = robot_.joints[columns_[column].joint];
      if (!hasOnePosition(joint)) continue;  // it rests
      lower_[column] = joint.lower, upper_[column] = joint.upper, speeds_[column] = joint.max_velocity;
    }
    directions_.setZero(joints);
    changes_.setZero(joints);
  }

  void observe(double duration) {
    if (!chooseStart()) return;
    ++summary_.drives;
    const VectorXd target = randomState(robot_, columns_, chance_);
    const int steps = static_cast<int>(std::lround(duration / kStep));
    int step = 0;
    bool is_there = false;
    while (!is_there && step < steps && failure.empty()) {
      is_there = !this->step(target);
      ++step;
    }
    summary_.steps += step;
    const double often = changes_.maxCoeff() / (step * kStep);
    summary_.sign_changes = std::max(summary_.sign_changes, changes_.maxCoeff() > 3.0 ? often : 0.0);
    if (changes_.maxCoeff() > 3.0 && often > kOftenest) fail("a joint goes back and forth", often);
    if (is_there)
      ++summary_.arrived;
    else if (velocity_.norm() >= kAtRest)
      ++summary_.moving;
    else if (is_held_)
      ++summary_.held;
    else
      fail("it rests, and no pair holds it back; the way that is left is", (target - state_).norm());
  }

  std::string failure;

 private:
  void fail(const std::string& what, double number) {
    if (failure.empty()) failure = what + " " + std::to_string(number);
  }

  void place(const VectorXd& state) {
    state_ = state;
    const BodyPoses poses = posesOf(robot_, columns_, state);
    scene_.update(poses);
    derivatives_.update(poses);
  }

  const std::vector<PairProximity>& below(double distance) {
    Question question;
    question.threshold = distance;
    return scene_.below(scene_.candidates(), question);
  }

  double stopOf(const PairProximity& pair) const { return family_.damper.stop.of(pair.asked); }

  bool chooseStart() {
    for (int attempt = 0; attempt < 5000; ++attempt) {
      place(randomState(robot_, columns_, chance_));
      const std::vector<PairProximity>& near = below(kStop);
      const auto is_too_near = [&](const PairProximity& pair) { return pair.result.distance < stopOf(pair); };
      if (std::any_of(near.begin(), near.end(), [&](const PairProximity& pair) {
            return is_too_near(pair) && family_.near_by_design.count(keyOf(pair.asked)) == 0;
          }))
        continue;
      for (const PairProximity& pair : near)
        if (is_too_near(pair)) least_[keyOf(pair.asked)] = pair.result.distance;
      return true;
    }
    fail("no start is free after so many attempts:", 5000);
    return false;
  }

  VectorXd wanted(const VectorXd& target) const {
    const VectorXd velocity = kApproach * (target - state_);
    const double speed = velocity.norm();
    return speed <= kMaxSpeed ? velocity : VectorXd(velocity * (kMaxSpeed / speed));
  }

  /// False: the target is reached.
  bool step(const VectorXd& target) {
    if ((target - state_).norm() < kArrived) return false;
    rows_.update(scene_, derivatives_, family_.damper);
    summary_.left_out += rows_.leftOut() > 0;
    std::optional<YieldingVelocity> found = yieldingVelocity(program(target));
    if (!found) found = yieldingVelocity(presentProgram(target));
    summary_.not_solved += !found;
    if (!found) fail("no velocity was found at the distance", state_.norm());
    velocity_ = found ? found->velocity : VectorXd(VectorXd::Zero(state_.size()));
    is_held_ = found && found->pushes.maxCoeff() > 0.0;
    countDirections();
    for (Eigen::Index i = 0; i < velocity_.size(); ++i)
      if (speeds_[i] > 0.0) summary_.fastest = std::max(summary_.fastest, std::abs(velocity_[i]) / speeds_[i]);
    if (!(velocity_.cwiseAbs().array() <= (1.0 + 1e-9) * speeds_.array() + 1e-9).all())
      fail("a joint is faster than its limit:", velocity_.cwiseAbs().maxCoeff());
    place((state_ + kStep * velocity_).cwiseMax(lower_).cwiseMin(upper_));
    lookAround();
    return true;
  }

  VelocityProgram program(const VectorXd& target) {
    std::map<std::pair<int, int>, RememberedRows::Place> places;
    std::map<std::pair<int, int>, int> index;
    for (int i = 0; i < rows_.capacity(); ++i) {
      const ConstraintRows::Row& row = rows_.rows()[static_cast<std::size_t>(i)];
      if (!row.is_used) continue;
      index[keyOf(row.pair)] = i;
      places.emplace(keyOf(row.pair), RememberedRows::Place{rows_.matrix().row(i).transpose(), row.distance, state_});
    }
    const std::vector<std::pair<RememberedRows::Key, VectorXd>> also = remembered_.update(places);
    VelocityProgram program = presentProgram(target);
    const Eigen::Index rows = rows_.capacity() + static_cast<Eigen::Index>(also.size());
    program.matrix.conservativeResize(rows, Eigen::NoChange);
    program.lower_bounds.conservativeResize(rows);
    int next = rows_.capacity();
    for (const auto& [pair, gradient] : also) {
      program.matrix.row(next) = gradient.transpose();
      program.lower_bounds[next++] = program.lower_bounds[index.at(pair)];
    }
    return program;
  }

  /// Without remembered rows.
  VelocityProgram presentProgram(const VectorXd& target) const {
    return {wanted(target), rows_.matrix(), rows_.bounds().array() + kAllowance,
            ((lower_ - state_) / kStep).cwiseMax(-speeds_).cwiseMin(0.0),
            ((upper_ - state_) / kStep).cwiseMin(speeds_).cwiseMax(0.0)};
  }

  void countDirections() {
    for (Eigen::Index i = 0; i < velocity_.size(); ++i) {
      if (std::abs(velocity_[i]) < kNoticed) continue;
      if (directions_[i] * velocity_[i] < 0.0) changes_[i] += 1.0;
      directions_[i] = velocity_[i];
    }
  }

  void lookAround() {
    for (const PairProximity& pair : below(kStop + 0.005)) {
      const auto start = least_.find(keyOf(pair.asked));
      const double above = pair.result.distance - (start == least_.end() ? stopOf(pair) : start->second);
      summary_.nearest = std::min(summary_.nearest, above);
      if (above < -kLoss)
        fail(robot_.links[pair.asked.a.link()].name + " - " + robot_.links[pair.asked.b.link()].name +
                 " come too near, by [m]",
             -above);
    }
  }

  const DriveFamily& family_;
  Chance chance_;
  const RobotModel& robot_;
  const DegreesOfFreedom columns_;
  Scene scene_;
  Derivatives derivatives_;
  ConstraintRows rows_;
  RememberedRows remembered_;
  DriveSummary& summary_;
  VectorXd lower_, upper_, speeds_;
  VectorXd state_, velocity_, directions_, changes_;
  std::map<std::pair<int, int>, double> least_;  // the distance of pairs that are below the stop distance at the start
  bool is_held_ = false;
};

}  // namespace

void DriveSummary::merge(const DriveSummary& other) {
  drives += other.drives;
  steps += other.steps;
  arrived += other.arrived;
  held += other.held;
  moving += other.moving;
  fastest = std::max(fastest, other.fastest);
  nearest = std::min(nearest, other.nearest);
  sign_changes = std::max(sign_changes, other.sign_changes);
  not_solved += other.not_solved;
  left_out += other.left_out;
  seconds += other.seconds;
  failed += other.failed;
  failures.insert(failures.end(), other.failures.begin(), other.failures.end());
}

std::vector<DriveSummary> runDrives(const DriveRun& run, std::atomic<std::int64_t>& done) {
  const narrowphase::Rounds rounds(driveFamilies(), run.family, static_cast<double>(run.drives));
  return rounds.observe<DriveSummary>(run.threads, [&](std::size_t family, std::int64_t number, DriveSummary& summary) {
    const auto start = Clock::now();
    Drive drive(driveFamilies()[family], chanceOf(run.seed, family, number), summary);
    drive.observe(run.duration);
    summary.seconds += std::chrono::duration<double>(Clock::now() - start).count();
    ++done;
    if (drive.failure.empty()) return;
    ++summary.failed;
    if (summary.failures.size() < narrowphase::kFailuresKept) summary.failures.push_back({number, drive.failure});
  });
}

}  // namespace proximity_server::scene
