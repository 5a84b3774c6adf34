// ./dev stress drives: drives robots from random states to random targets as the example avoiding_controller does, with
// its defaults and those of the node, and looks at the distance of every pair after each step.
//
// 1. Take a random state in which no pair is below its stop distance, unless it is in most states (links that are near
//    by design), and a random target. Where joint inequalities leave no such state, there is no drive.
// 2. In each step of 10 ms take the rows of the state, the velocity of yieldingVelocity(), and move on.
//
// Some robots have random joint inequalities, whose rows are taken without an allowance.
//
// A failure is a broken inequality; a pair below its stop distance, or, where it was below it at the start, nearer than
// there, both by more than 0.1 mm; a joint that is faster than the URDF allows; one that changes its direction more
// than five times a second, at more than 0.02 rad/s or m/s; a rest before the target that no pair explains; a step
// without a velocity.
// Limit: links that are below their stop distance by design and have no stop distance of their own may lose up to
// 0.25 mm of it, and a joint may still change its direction more often where several of them have many places that are
// equally near. Such drives are failures, too.
#include "proximity_server/scene/derivative/constraint_rows.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "scene/example_robots.h"
#include "scene/posed_scene.h"
#include "stress/controlled_robots.h"
#include "stress/yielding_velocity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace proximity_server::scene {
namespace {

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
  bool is_coupled = false;                         // each drive has joint inequalities of its own
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
    if (hasOnePosition(robot.joints[leader.joint]))
      positions[i] = leader.offset + leader.multiplier * state[columns.columnsOf(leader.joint).first];
  }
  return forwardKinematics(robot, positions);
}

DriveFamily familyOf(const std::string& name, int rarity, const std::shared_ptr<const SceneModel>& robot,
                     Thresholds thresholds = Thresholds::Default) {
  constexpr int kStates = 300;
  DriveFamily family{name, rarity, robot};
  const DegreesOfFreedom columns(family.robot->robot);
  PosedScene scene(family.robot);
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

/// Disables the pairs that pair_audit --write disables of a UR10, which has no SRDF of its own.
std::shared_ptr<const SceneModel> audited(const std::shared_ptr<const SceneModel>& ur10) {
  PairFilterOptions options;
  options.exclude_pairs = {{"base_link", "upper_arm_link"},   {"base_link", "wrist_1_link"},
                           {"shoulder_link", "wrist_1_link"}, {"shoulder_link", "wrist_2_link"},
                           {"wrist_1_link", "wrist_3_link"},  {"wrist_1_link", "ee_link"},
                           {"wrist_2_link", "ee_link"}};
  return std::make_shared<const SceneModel>(makeSceneModel(ur10->robot, "", options));
}

/// The same robot with inequalities.
DriveFamily coupledFamily(DriveFamily family) {
  family.name += ", coupled";
  family.is_coupled = true;
  return family;
}

std::vector<DriveFamily> allFamilies() {
  std::vector<DriveFamily> families{familyOf("demo", 1, quickDemoModel())};
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) return families;
  const auto example = [&](const std::string& urdf, const std::string& srdf) {
    return exampleModel(resolve, urdf, srdf);
  };
  families.push_back(
      familyOf("Panda", 1, example("panda_description/urdf/panda.urdf", "panda_description/srdf/panda.srdf")));
  if (kIsSanitized) return families;
  const auto ur10 = example("ur_description/urdf/ur10_robot.urdf", "");
  families.push_back(familyOf("Ur10", 1, audited(ur10), Thresholds::Own));
  families.push_back(familyOf("Ur10, defaults", 1, audited(ur10)));
  families.push_back(familyOf("Ur10, no SRDF", 1, ur10));
  families.push_back(familyOf("Ur5, no SRDF", 1, example("ur_description/urdf/ur5_robot.urdf", "")));
  families.push_back(familyOf(
      "Baxter", 2, example("baxter_description/urdf/baxter.urdf", "baxter_description/srdf/baxter_manipulation.srdf")));
  families.push_back(familyOf("Pr2", 2, example("pr2_description/urdf/pr2.urdf", "pr2_description/srdf/pr2.srdf")));
  families.push_back(coupledFamily(families[0]));
  families.push_back(coupledFamily(families[1]));
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

std::vector<int> allColumns(const DegreesOfFreedom& columns) {
  std::vector<int> all;
  for (int column = 0; column < columns.size(); ++column) all.push_back(column);
  return all;
}

class Drive {
 public:
  Drive(const DriveFamily& family, Chance chance, stress::Tally& tally)
      : family_(family),
        chance_(chance),
        model_(family.is_coupled ? coupled(*family.robot, chance_) : family.robot),
        robot_(model_->robot),
        columns_(robot_),
        scene_(model_),
        rows_(model_, kRows),
        inequality_rows_(model_, allColumns(columns_)),
        tally_(tally) {
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
    tally_.add("drives");
    const VectorXd target = randomState(robot_, columns_, chance_);
    const int steps = static_cast<int>(std::lround(duration / kStep));
    int step = 0;
    bool is_there = false;
    while (!is_there && step < steps && failure.empty()) {
      is_there = !this->step(target);
      ++step;
    }
    tally_.add("steps", step);
    const double often = changes_.maxCoeff() / (step * kStep);
    tally_.raise("turns", changes_.maxCoeff() > 3.0 ? often : 0.0);
    if (changes_.maxCoeff() > 3.0 && often > kOftenest) fail("a joint goes back and forth", often);
    const bool is_moving = !is_there && velocity_.norm() >= kAtRest;
    tally_.add("arrived", is_there);
    tally_.add("moving", is_moving);
    tally_.add("held", !is_there && !is_moving && is_held_);
    if (!is_there && !is_moving && !is_held_)
      fail("it rests, and no pair holds it back; the way that is left is", (target - state_).norm());
  }

  std::string failure;

 private:
  void fail(const std::string& what, double number) {
    if (failure.empty()) failure = what + " " + std::to_string(number);
  }

  void place(const VectorXd& state) {
    state_ = state;
    poses_ = posesOf(robot_, columns_, state);
    scene_.update(poses_);
  }

  /// The largest excess of an inequality, in its tolerances.
  double largestExcess() const {
    std::vector<double> positions(robot_.joints.size(), 0.0);
    for (int column = 0; column < columns_.size(); ++column) positions[columns_[column].joint] = state_[column];
    double largest = -std::numeric_limits<double>::infinity();
    for (const JointInequality& inequality : robot_.inequalities)
      largest = std::max(largest, inequality.excess(positions) / inequality.tolerance());
    return largest;
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
      if (largestExcess() > 0.0) continue;
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
    if (!family_.is_coupled) fail("no start is free after so many attempts:", 5000);
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
    rows_.find(scene_.scene, scene_.state, family_.damper);
    inequality_rows_.update(poses_, {}, family_.damper.gain / (kInfluence - kStop));
    tally_.add("left_out", rows_.leftOut() > 0);
    std::optional<YieldingVelocity> found = yieldingVelocity(program(target));
    if (!found) found = yieldingVelocity(presentProgram(target));
    tally_.add("not_solved", !found);
    if (!found) fail("no velocity was found at the distance", state_.norm());
    velocity_ = found ? found->velocity : VectorXd(VectorXd::Zero(state_.size()));
    is_held_ = found && found->pushes.maxCoeff() > 0.0;
    countDirections();
    for (Eigen::Index i = 0; i < velocity_.size(); ++i)
      if (speeds_[i] > 0.0) tally_.raise("fastest", std::abs(velocity_[i]) / speeds_[i]);
    if (!(velocity_.cwiseAbs().array() <= (1.0 + 1e-9) * speeds_.array() + 1e-9).all())
      fail("a joint is faster than its limit:", velocity_.cwiseAbs().maxCoeff());
    place((state_ + kStep * velocity_).cwiseMax(lower_).cwiseMin(upper_));
    lookAround();
    if (largestExcess() > 1e-3) fail("a joint inequality is broken, by so many tolerances:", largestExcess());
    if (largestExcess() > -1e3) tally_.add("coupled");
    return true;
  }

  VelocityProgram program(const VectorXd& target) {
    std::map<std::pair<int, int>, RememberedRows::Place> places;
    std::map<std::pair<int, int>, int> index;
    for (int i = 0; i < rows_.capacity(); ++i) {
      const ConstraintRows::Row& row = rows_.rows()[i];
      if (!row.is_used) continue;
      index[keyOf(row.pair)] = i;
      places.emplace(keyOf(row.pair), RememberedRows::Place{rows_.matrix().row(i).transpose(), row.distance, state_});
    }
    const std::vector<std::pair<RememberedRows::Key, VectorXd>> also = remembered_.update(places);
    VelocityProgram program = presentProgram(target);
    Eigen::Index next = program.matrix.rows();
    program.matrix.conservativeResize(next + static_cast<Eigen::Index>(also.size()), Eigen::NoChange);
    program.lower_bounds.conservativeResize(program.matrix.rows());
    for (const auto& [pair, gradient] : also) {
      program.matrix.row(next) = gradient.transpose();
      program.lower_bounds[next++] = program.lower_bounds[index.at(pair)];
    }
    return program;
  }

  /// Without remembered rows.
  VelocityProgram presentProgram(const VectorXd& target) const {
    Eigen::MatrixXd matrix(rows_.matrix().rows() + inequality_rows_.matrix().rows(), columns_.size());
    matrix << rows_.matrix(), inequality_rows_.matrix();
    VectorXd bounds(matrix.rows());
    bounds << (rows_.bounds().array() + kAllowance).matrix(), inequality_rows_.bounds();
    return {wanted(target), matrix, bounds, ((lower_ - state_) / kStep).cwiseMax(-speeds_).cwiseMin(0.0),
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
      tally_.lower("nearest", above);
      if (above < -kLoss)
        fail(robot_.links[pair.asked.a.link()].name + " - " + robot_.links[pair.asked.b.link()].name +
                 " come too near, by [m]",
             -above);
    }
  }

  const DriveFamily& family_;
  Chance chance_;
  const std::shared_ptr<const SceneModel> model_;
  const RobotModel& robot_;
  const DegreesOfFreedom columns_;
  PosedScene scene_;
  ConstraintRows rows_;
  InequalityRows inequality_rows_;
  RememberedRows remembered_;
  stress::Tally& tally_;
  VectorXd lower_, upper_, speeds_;
  BodyPoses poses_;
  VectorXd state_, velocity_, directions_, changes_;
  std::map<std::pair<int, int>, double> least_;  // the distance of pairs that are below the stop distance at the start
  bool is_held_ = false;
};

}  // namespace

}  // namespace proximity_server::scene

namespace proximity_server::stress {

Campaign driveCampaign(double duration) {
  using namespace scene;
  Campaign campaign{"drive_stress", "Looks for drives with ~constraints that come too near, race, tremble or rest.",
                    "drives", "cell"};
  campaign.option = "--drives";
  campaign.usual = 50;
  campaign.record_file = "recorded_drives.jsonl";
  campaign.families = namesOf(driveFamilies());
  campaign.ask = [duration](const Part& part, Tally& tally) {
    const Stopwatch watch;
    Drive drive(driveFamilies()[part.family], chanceOf(part), tally);
    drive.observe(duration);
    tally.add("seconds", watch.seconds());
    if (!drive.failure.empty()) tally.fail({part.number, drive.failure, {}});
  };
  campaign.name_width = 16;
  campaign.columns = {count("drives", 7, "drives"),
                      count("arrived", 8, "arrived"),
                      count("held", 7, "held"),
                      count("moving", 7, "moving"),
                      count("coupled", 8, "coupled"),
                      number("fastest", 8, "%*.3f", "fastest"),
                      {"nearest mm", 10, "%*.3f",
                       [](const Tally& tally) {
                         const bool is_near = tally.numbers().count("nearest") > 0;
                         return is_near ? 1e3 * tally["nearest"] : std::numeric_limits<double>::infinity();
                       }},
                      number("turns/s", 8, "%*.2f", "turns"),
                      count("unsolved", 8, "not_solved"),
                      ratio("ms/step", 9, "%*.3f", "seconds", "steps", 1e3),
                      failures(8)};
  campaign.legend =
      "coupled: steps at an inequality; held: rests before the target, and the pairs that hold it are named; moving: "
      "the time was over; fastest: "
      "velocity of a joint,\n"
      "as a part of the URDF's limit; nearest: smallest distance less the stop distance, or less that at the start, if "
      "it is below;\n"
      "turns/s: changes of direction of one joint. A failure ends its drive.";
  return campaign;
}

Campaign driveCampaign() { return driveCampaign(20.0); }

}  // namespace proximity_server::stress
