// Records of random robots, parameters, objects and motions, which a replay has to answer in the same way.
#include "chance.h"
#include "from_environment.h"
#include "node/answers/guarantees.h"
#include "node/object_messages.h"
#include "node/record/recorder.h"
#include "node/replay/replay.h"
#include "node/robot/load_config.h"
#include "node/robot/query_status.h"
#include "robots/robots.h"
#include "robots/urdf.h"
#include "sanitized.h"
#include "scene/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::node::random_records_test {

constexpr int kCycles = 60;
constexpr char kCart[] = "cart", kCamera[] = "camera";  // frames of tf that carry objects

std::string someShape(Chance& chance) {
  const auto length = [&] { return std::to_string(chance.between(0.05, 0.3)); };
  const std::string place = std::to_string(chance.between(-0.1, 0.1)) + " 0 0";
  switch (chance.below(3)) {
    case 0:
      return robots::ball(length(), place);
    case 1:
      return robots::box(length() + " " + length() + " " + length(), place, "0.3 0.2 0.1");
    default:
      return robots::cylinder(length(), length(), place);
  }
}

/// A tree of three to six links, joined by any joint with one position.
std::string someUrdf(Chance& chance) {
  const char* const types[] = {"revolute", "prismatic", "continuous"};
  std::string parts = robots::link("l0", someShape(chance));
  for (int i = 1, count = 3 + chance.below(4); i < count; ++i) {
    const std::string name = std::to_string(i);
    parts += robots::link("l" + name, someShape(chance));
    parts += robots::joint("j" + name, chance.oneOf(types), "l" + std::to_string(chance.below(i)), "l" + name,
                           robots::origin(std::to_string(chance.between(-0.4, 0.4)) + " 0.1 0.2") +
                               robots::axis("0 0.6 0.8") + robots::limits("-1.5", "1.5"));
  }
  return robots::urdfOf(parts);
}

/// The robot of the demo, one of test/robots, or a random one.
RobotTexts someRobot(Chance& chance) {
  const char* const files[] = {"gantry",    "arm_with_hand", "balls",      "branches",
                               "followers", "limits",        "two_joints", "odd_names"};
  const int kind = chance.below(10);
  const std::string demo = PROXIMITY_SOURCE_DIR "/config/demo/robot";
  if (kind == 0) return {scene::readFile(demo + ".urdf"), scene::readFile(demo + ".srdf")};
  if (kind < 5) return {someUrdf(chance), ""};
  const std::string file = chance.oneOf(files);
  return {robotText(file + ".urdf"), chance.below(2) == 0 && file == "gantry" ? robotText(file + ".srdf") : ""};
}

using Names = std::pair<std::string, std::string>;

/// The links of the checked pairs.
std::vector<Names> pairsOf(const Robot& robot) {
  std::vector<Names> names;
  for (const int checked : robot.sceneModel().pairs.checked) {
    const scene::LinkPair& pair = robot.sceneModel().pairs.pairs[checked];
    names.emplace_back(robot.robotModel().links[pair.link_a].name, robot.robotModel().links[pair.link_b].name);
  }
  return names;
}

/// Any parameters that change an answer, but pose_latency and what is read from files.
XmlRpc::XmlRpcValue someParameters(Chance& chance, const std::vector<Names>& pairs) {
  XmlRpc::XmlRpcValue values;
  const auto maybe = [&](const char* name, double low, double high) {
    if (chance.below(3) == 0) values[name] = chance.between(low, high);
  };
  maybe("default_padding", 0.0, 0.02);
  maybe("hysteresis", 0.0, 0.05);
  maybe("threshold", 0.0, 1.0);
  if (chance.below(3) == 0) values["rate"] = 1000.0;  // few steps for guaranteed distances
  for (const std::string of : {"", "object_"}) {
    if (chance.below(2) == 0) continue;
    const double stop = chance.between(0.0, 0.1);
    values[of + "stop_distance"] = stop;
    values[of + "warn_distance"] = stop + chance.between(0.0, 0.2);
  }
  if (chance.below(3) == 0) values["mesh_tolerance"] = chance.below(2) == 0 ? 0.005 : 0.02;
  if (chance.below(3) == 0) values["max_reported_pairs"] = 1 + chance.below(20);
  if (chance.below(3) == 0) values["gradients"] = true;
  if (chance.below(3) == 0) values["joint_uncertainty"]["*"] = chance.decades(-3.0, -1.0);
  if (chance.below(4) == 0) values["object_uncertainty"]["*"] = chance.between(0.0, 0.01);
  if (chance.below(3) == 0) {
    const auto& [a, b] = chance.oneOf(pairs);
    values["link_padding"][a] = chance.between(0.0, 0.02);
    const double stop = chance.between(0.0, 0.1);
    for (const char* const name : {"pair_stop_distance", "pair_warn_distance"}) {
      values[name][0]["links"][0] = a;
      values[name][0]["links"][1] = b;
      values[name][0]["distance"] = stop + (name[5] == 'w' ? 0.05 : 0.0);
    }
  }
  return values;
}

/// A robot in motion among objects that come and go, monitored and recorded.
class RandomRecord {
 public:
  RandomRecord(unsigned number, const std::string& folder) : chance_(number) {
    RobotTexts texts;
    Config any;
    any.useMeshCache();
    while (pairs_.empty()) {  // some robots of test/robots have no geometry
      texts = someRobot(chance_);
      pairs_ = pairsOf(Robot(texts.urdf, texts.srdf, any));
    }
    config_ = configFrom(someParameters(chance_, pairs_), "node");
    robot_ = std::make_shared<const Robot>(texts.urdf, texts.srdf, config_);
    settings_ = config_.monitor;
    config_.record_directory = folder;
    config_.record_on = {};
    config_.record_seconds = 3600.0;                             // however slowly the cycles come
    config_.record_memory = chance_.below(4) == 0 ? 0.1 : 20.0;  // the smallest one loses the first cycles
    store_ = std::make_unique<ObjectStore>(robot_, 1, [this](const Robot&, const std::string& frame) {
      if (frame == kCart || frame == kCamera) return frames_[frame];
      return Eigen::Isometry3d(Eigen::Isometry3d::Identity());
    });
    for (const scene::JointRange& range : scene::jointRanges(robot_->robotModel())) ranges_.push_back(range);
    positions_.assign(robot_->robotModel().joints.size(), 0.0);
  }

  /// Returns the name of the record.
  std::string make() {
    Recorder recorder(config_, "/node");
    monitor_.follow(robot_);
    useObjects(recorder);
    for (int i = 0; i < kCycles; ++i) {
      if (chance_.below(12) == 0) changeObjects(recorder);
      if (chance_.below(20) == 0) changeSettings();
      move();
      ++levels[cycle(recorder)];
    }
    recorder.beginSaving();
    recorder.stop();
    const Recorder::Outcome outcome = recorder.outcome();
    EXPECT_EQ(outcome.problem, "");
    return outcome.file;
  }

  std::map<int, int> levels;
  int changes = 0;           ///< of objects
  std::uint64_t coarse = 0;  ///< cycles whose guaranteed distances ended at a limit

 private:
  void move() {
    const bool jumps = chance_.below(10) == 0;
    for (const scene::JointRange& range : ranges_) {
      const double step = (jumps ? 1.0 : 0.02) * std::min(6.0, range.width());
      double& position = positions_[range.joint];
      position = std::clamp(position + chance_.between(-step, step), range.lower, range.upper);
    }
    for (auto& [name, pose] : frames_)
      if (chance_.below(2) == 0) pose = pose * chance_.pose(0.01);
  }

  Clearance::_level_type cycle(Recorder& recorder) {
    PoseSnapshot snapshot;
    snapshot.stamp = ros::Time(stamp_ += chance_.between(0.005, 0.02));
    snapshot.poses = scene::forwardKinematics(robot_->robotModel(), positions_);
    if (chance_.below(15) == 0) {
      snapshot.status = statusOf(QueryStatus::TF_STALE, "joint 'elbow' is 3 s old");
      snapshot.poses.back().reset();
    }
    FrameSnapshot frames;
    for (const std::string& name : monitor_.frames().names) frames.poses.emplace_back(frames_[name]);
    const bool ends = ends_.below(3) == 0;
    monitor_.endTimeAfter(ends ? static_cast<std::int64_t>(ends_.decades(0.0, 5.0)) : kNoEnd);
    const Clearance& clearance = monitor_.cycle(snapshot, {}, settings_, frames);
    coarse += !endIn(clearance.status.message).empty();
    recorder.add(*robot_, snapshot, frames, clearance, settings_);
    return clearance.level;
  }

  void changeSettings() {
    settings_.stop_distance = chance_.between(0.0, 0.1);
    settings_.warn_distance = chance_.between(0.1, 0.3);
    settings_.hysteresis = chance_.between(0.0, 0.05);
    settings_.threshold = chance_.between(0.0, 1.0);
    settings_.max_reported_pairs = 1 + chance_.below(20);
    settings_.gradients = chance_.below(2) == 0;
  }

  /// A ball, box or cylinder, boxes in bulk, or a half-space; standing, held, or on a moving frame.
  ObjectChange someObject(const std::string& id) {
    using shape_msgs::SolidPrimitive;
    ObjectChange result = change(ObjectChange::REPLACE, id);
    const auto size = [&] { return chance_.between(0.02, 0.3); };
    const int kind = chance_.below(5);
    if (kind == 0) result.primitives = {primitive(SolidPrimitive::SPHERE, {size()})};
    if (kind == 1) result.primitives = {primitive(SolidPrimitive::BOX, {size(), size(), size()})};
    if (kind == 2)
      result.primitives = {primitive(SolidPrimitive::CYLINDER, {size(), size()}),
                           primitive(SolidPrimitive::CONE, {size(), size()})};
    if (kind == 2) result.primitive_poses = {somePose(), somePose()};
    const int place = chance_.below(4);
    if (kind == 3) {
      result.boxes.resize(1);
      for (int i = 0; i < 5; ++i) addBox(result.boxes[0]);
    }
    if (kind == 4) {
      result.planes.resize(1);
      result.planes[0].coef = {{0.0, 0.6, 0.8, chance_.between(0.2, 1.0)}};
    }
    result.pose = somePose();
    if (chance_.below(3) == 0) result.padding = chance_.between(0.0, 0.02);
    if (place == 0 && kind != 4) {
      result.link = chance_.oneOf(pairs_).first;
      result.touch_links = {chance_.oneOf(pairs_).first};
    } else if (place == 1) {
      result.frame = result.header.frame_id = chance_.below(2) == 0 ? kCart : kCamera;
    }
    return result;
  }

  void addBox(Boxes& boxes) {
    boxes.centres.push_back(somePose().position);
    geometry_msgs::Vector3 size;
    for (double* const edge : {&size.x, &size.y, &size.z}) *edge = chance_.between(0.02, 0.2);
    boxes.sizes.push_back(size);
  }

  geometry_msgs::Pose somePose() { return toMessage(chance_.pose(0.8)); }

  void changeObjects(Recorder& recorder) {
    const std::string id = "object " + std::to_string(chance_.below(4));
    ObjectChanges message;
    switch (chance_.below(5)) {
      case 0:
        message.changes = {change(ObjectChange::REMOVE, id)};
        break;
      case 1:
        message.changes = {attach(id, chance_.oneOf(pairs_).first)};
        break;
      default:
        message.changes = {someObject(id)};
    }
    if (chance_.below(3) == 0) {
      message.set_rules = true;
      message.rules.resize(1);
      message.rules[0].a = chance_.below(2) == 0 ? "*" : chance_.oneOf(pairs_).first;
      message.rules[0].b = id;
      message.rules[0].allowed = chance_.below(2) == 0;
    }
    try {
      store_->apply(message);
    } catch (const std::invalid_argument&) {  // an object that is not there, or that a link cannot hold
      return;
    }
    ++changes;
    useObjects(recorder);
  }

  void useObjects(Recorder& recorder) {
    recorder.know(store_->current());
    MonitoredObjects objects(*robot_, robot_->objects().get());
    monitor_.use(objects);
  }

  static constexpr std::int64_t kNoEnd = std::numeric_limits<std::int64_t>::max();

  Chance chance_, ends_{5};
  Config config_;
  std::vector<Names> pairs_;
  std::shared_ptr<const Robot> robot_;
  std::unique_ptr<ObjectStore> store_;
  Monitor monitor_;
  MonitorSettings settings_;
  std::vector<scene::JointRange> ranges_;
  std::vector<double> positions_;
  std::map<std::string, Eigen::Isometry3d> frames_{{kCart, Eigen::Isometry3d::Identity()},
                                                   {kCamera, Eigen::Isometry3d::Identity()}};
  double stamp_ = 1000.0;
};

TEST(RandomRecords, AreAnsweredAgainWithTheSameLevelsAndTheSameBytesTwice) {
  ros::Time::init();
  std::map<int, int> levels;
  int changes = 0;
  const std::int64_t records = fromEnvironment("PROXIMITY_RECORDS", kIsSanitized ? 10 : 20);
  std::uint64_t cycles = 0, coarse = 0;
  for (std::int64_t number = 0; number < records; ++number) {
    SCOPED_TRACE("record " + std::to_string(number));
    const scene::TemporaryFiles files;
    RandomRecord record(static_cast<unsigned>(number), files.path(""));
    const std::string file = record.make();
    std::ostringstream first, second;
    const ReplayResult result = replay({file, {}}, first);
    EXPECT_TRUE(result.agrees()) << (result.agrees() ? "" : result.first_differences[0]);
    replay({file, {}}, second);
    EXPECT_EQ(first.str(), second.str());
    EXPECT_LE(result.coarse, record.coarse);  // the first cycles may be lost
    cycles += result.cycles;
    changes += record.changes;
    coarse += result.coarse;
    for (const auto& [level, count] : record.levels) levels[level] += count;
  }
  EXPECT_GT(cycles, static_cast<std::uint64_t>(records * kCycles * 3 / 4));
  EXPECT_GT(changes, records);
  EXPECT_GT(coarse, static_cast<std::uint64_t>(records));
  for (const auto level :
       {Clearance::CLEAR, Clearance::WARN, Clearance::STOP, Clearance::COLLISION, Clearance::INVALID})
    EXPECT_GT(levels[level], records) << level;
}

}  // namespace proximity_server::node::random_records_test
