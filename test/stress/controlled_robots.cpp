#include "stress/controlled_robots.h"

#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "scene/derivative/moved_robot.h"
#include "scene/example_robots.h"
#include "scene/random_objects.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace proximity_server::scene {
namespace {

std::vector<ControlFamily> allFamilies() {
  std::vector<ControlFamily> families{{"random robot", 1, false, nullptr},
                                      {"random robot, objects", 1, true, nullptr},
                                      {"demo, objects", 4, true, quickDemoModel()}};
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) return families;
  for (const ExampleRobot& robot : robotsToTest()) {
    const auto model = exampleModel(resolve, robot.urdf, robot.srdf);
    const int rarity = robot.name == std::string("Pr2") ? 16 : 4;
    families.push_back({robot.name, rarity, false, model});
    families.push_back({robot.name + std::string(", objects"), rarity, true, model});
  }
  families.push_back({"random robot, coupled", 1, false, nullptr, true});
  families.push_back({"demo, coupled", 4, false, families[2].robot, true});
  return families;
}

/// Objects of all placements around the robot, and some that its links hold.
std::shared_ptr<const Objects> someObjects(const std::shared_ptr<const SceneModel>& model, Chance& chance) {
  const auto link = [&] { return chance.oneOf(model->robot.links).name; };
  std::vector<ObjectChange> changes;
  for (int i = 0; i < 4; ++i)
    changes.push_back(AddObject{someObject("fixed " + std::to_string(i), Fixed{chance.pose(0.8)}, chance)});
  changes.push_back(AddObject{someObject("moving", Moving{"cart", chance.pose(0.3)}, chance)});
  for (int i = 0; i < 2; ++i)
    changes.push_back(
        AddObject{someObject("held " + std::to_string(i), Attached{link(), {link()}, chance.pose(0.1)}, chance)});
  return std::make_shared<const Objects>(Objects(model).changed(changes));
}

std::shared_ptr<const SceneModel> robotOf(const ControlFamily& family, Chance& chance) {
  const auto robot = family.robot ? family.robot : someRobot(chance);
  return family.is_coupled ? coupled(*robot, chance) : robot;
}

}  // namespace

double randomPosition(const Joint& joint, Chance& chance) {
  return chance.between(std::max(joint.lower, -3.0), std::min(joint.upper, 3.0));
}

std::shared_ptr<const SceneModel> coupled(const SceneModel& model, Chance& chance) {
  auto copy = std::make_shared<SceneModel>(model);
  std::vector<int> joints;
  for (int i = 0; i < static_cast<int>(model.robot.joints.size()); ++i)
    if (hasOnePosition(model.robot.joints[i]) && !model.robot.joints[i].mimic) joints.push_back(i);
  for (int n = joints.empty() ? 0 : 1 + chance.below(4); n > 0; --n) {
    JointInequality inequality{"inequality " + std::to_string(n), {}, 0.0};
    std::shuffle(joints.begin(), joints.end(), chance);
    const std::size_t terms = std::min<std::size_t>(joints.size(), 1 + chance.below(4));
    for (std::size_t i = 0; i < terms; ++i)
      inequality.terms.push_back({joints[i], chance.eitherSign(chance.between(0.3, 2.0))});
    std::vector<double> positions(model.robot.joints.size());
    double largest = -std::numeric_limits<double>::infinity();
    for (int state = 0; state < 3; ++state) {
      for (const int joint : joints) positions[joint] = randomPosition(model.robot.joints[joint], chance);
      largest = std::max(largest, inequality.excess(positions));
    }
    inequality.bound = largest;
    copy->robot.inequalities.push_back(inequality);
  }
  return copy;
}

std::shared_ptr<const SceneModel> quickDemoModel() {
  const std::string demo = PROXIMITY_SOURCE_DIR "/config/demo/robot";
  const MeshResolver resolve = packageResolver({PROXIMITY_SOURCE_DIR "/.."});
  return std::make_shared<const SceneModel>(
      makeSceneModel(loadRobotModel(readFile(demo + ".urdf"), resolve, quickLoading()), readFile(demo + ".srdf")));
}

std::shared_ptr<const SceneModel> exampleModel(const MeshResolver& resolve, const std::string& urdf,
                                               const std::string& srdf) {
  RobotModel robot = loadRobotModel(readFile(exampleRobotFile(resolve, urdf)), resolve, quickLoading());
  return std::make_shared<const SceneModel>(
      makeSceneModel(std::move(robot), srdf.empty() ? "" : readFile(exampleRobotFile(resolve, srdf))));
}

const std::vector<ControlFamily>& controlFamilies() {
  static const std::vector<ControlFamily> families = allFamilies();
  return families;
}

Chance chanceOf(const stress::Part& part) {
  std::seed_seq mixed{part.seed, static_cast<unsigned>(part.family), static_cast<unsigned>(part.number),
                      static_cast<unsigned>(part.number >> 32)};
  unsigned one = 0;
  mixed.generate(&one, &one + 1);
  return Chance(one);
}

ControlledCell::ControlledCell(const ControlFamily& family, Chance chance)
    : chance_(chance), model_(robotOf(family, chance_)), scene_(model_) {
  if (!family.has_objects) return;
  objects_ = someObjects(model_, chance_);
  scene_.use(objects_);
}

void ControlledCell::moveFrames() {
  frames_.clear();
  if (!objects_) return;
  for (std::size_t i = 0; i < objects_->frames().size(); ++i) frames_.emplace_back(chance_.pose(0.5));
}

double Braked::wayAfter(double time, double scale) const {
  if (time <= latency) return scale * time;
  const double since = time - latency;
  return scale * latency + scale * since - 0.5 * since * since / braking;
}

StoppingCell::StoppingCell(const ControlFamily& family, Chance chance)
    : ControlledCell(family, chance), moving_(model_) {
  if (objects_) moving_.use(objects_);
}

void StoppingCell::choosePositions() {
  positions_.assign(model_->robot.joints.size(), 0.0);
  for (std::size_t i = 0; i < positions_.size(); ++i) positions_[i] = randomPosition(model_->robot.joints[i], chance_);
  moveFrames();
}

void StoppingCell::chooseVelocities() {
  const std::size_t joints = positions_.size();
  state_ = {};
  poses_ = forwardKinematics(model_->robot, positions_);
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
}

std::vector<double> StoppingCell::positionsAfter(double way) const {
  std::vector<double> positions = positions_;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Joint& joint = model_->robot.joints[i];
    if (hasOnePosition(joint))
      positions[i] = std::clamp(positions[i] + way * state_.velocities[i], joint.lower, joint.upper);
  }
  return positions;
}

Braked StoppingCell::brakes() const {
  Braked result{braking_.latency, 0.0};
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    const Joint& joint = model_->robot.joints[i];
    if (!hasOnePosition(joint)) continue;
    const Joint::Mimic leader = model_->robot.leaderOf(static_cast<int>(i));
    const double speed = std::abs(leader.multiplier * state_.velocities[leader.joint]);
    result.braking = std::max(result.braking, speed / braking_.deceleration[i]);
  }
  return result;
}

}  // namespace proximity_server::scene
