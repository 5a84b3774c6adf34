#include "proximity_server/scene/levels/always_near.h"

#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/query/scene.h"
#include "scene/scene_model/given_model.h"
#include "system/number_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <random>
#include <utility>

namespace proximity_server::scene {
namespace {

constexpr double kSure = 0.002;  // [m] a smaller distance of two links of a real robot is not reliable
constexpr double kSame = 5e-5;   // [m] distances that differ by less are written as one

/// The largest number with two digits that is at most a length; 0 for 0.
double roundedDown(double length) {
  if (!(length > 0.0)) return 0.0;
  // Dividing by a power of ten gives the number that the decimals stand for. 0.02 must not become 0.019.
  const double per_metre = std::pow(10.0, 1.0 - std::floor(std::log10(length)));
  return std::floor(length * per_metre * (1.0 + 1e-12)) / per_metre;
}

/// A length in mm with three digits.
std::string millimetres(double length) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g mm", 1e3 * length);
  return text.data();
}

std::vector<AlwaysNear> checkedPairs(const SceneModel& model) {
  std::vector<AlwaysNear> pairs;
  for (const int i : model.pairs.checked) {
    const LinkPair& pair = model.pairs.pairs[i];
    if (&model.robot.robotOf(pair.link_a) != &model.robot.robotOf(pair.link_b)) continue;
    pairs.push_back({{{pair.link_a, 0}, {pair.link_b, 0}}, std::numeric_limits<double>::infinity(), 0.0});
  }
  return pairs;
}

bool hasKnownRanges(const RobotModel& robot, const AlwaysNear& near) {
  const std::vector<int> joints =
      jointsBetween(robot, robot.links[near.pair.a.link()].body, robot.links[near.pair.b.link()].body);
  return std::all_of(joints.begin(), joints.end(), [&](int joint) { return hasKnownRange(robot, joint); });
}

}  // namespace

std::vector<AlwaysNear> findAlwaysNear(const SceneModel& model, double distance, int states) {
  const std::vector<JointRange> ranges = jointRanges(model.robot);
  std::vector<AlwaysNear> near = checkedPairs(model);
  Scene scene(lent(model));
  State current(lent(model));
  Question question;
  question.threshold = distance;
  question.depth = Question::Depth::NotWanted;
  std::mt19937_64 random(1);
  for (int state = 0; state < states && !near.empty(); ++state) {
    current.set(forwardKinematics(model.robot, randomPositions(model.robot, ranges, random)));
    const auto is_far = [&](AlwaysNear& each) {
      const narrowphase::SignedDistance found = scene.proximity(current, each.pair, question).result;
      const double seen = found.lower_bound > 0.0 ? found.distance : 0.0;
      each.smallest = std::min(each.smallest, seen);
      each.largest = std::max(each.largest, seen);
      return found.lower_bound > distance;
    };
    near.erase(std::remove_if(near.begin(), near.end(), is_far), near.end());
  }
  const auto is_useless = [&](const AlwaysNear& each) {
    return !(each.largest > 0.0) || !hasKnownRanges(model.robot, each);
  };
  near.erase(std::remove_if(near.begin(), near.end(), is_useless), near.end());
  return near;
}

StopAndWarn fittingThresholds(const AlwaysNear& pair, const StopAndWarn& usual) {
  const double reference = pair.smallest > kSure ? pair.smallest : std::max(pair.smallest, 0.5 * pair.largest);
  return {roundedDown(std::min(usual.stop, 0.5 * reference)), roundedDown(std::min(usual.warn, 0.75 * reference))};
}

LevelThresholds thresholdsWith(const std::vector<AlwaysNear>& near, const StopAndWarn& usual) {
  LevelThresholds thresholds{{usual.stop, usual.stop}, {usual.warn, usual.warn}};
  for (const AlwaysNear& pair : near) {
    const StopAndWarn fitting = fittingThresholds(pair, usual);
    thresholds.stop.setPair(pair.pair.a.link(), pair.pair.b.link(), fitting.stop);
    thresholds.warn.setPair(pair.pair.a.link(), pair.pair.b.link(), fitting.warn);
  }
  return thresholds;
}

std::string distancesText(const AlwaysNear& pair) {
  if (pair.smallest > 0.0 && pair.largest - pair.smallest < kSame) return "stays at " + millimetres(pair.smallest);
  const std::string smallest = pair.smallest > 0.0 ? millimetres(pair.smallest) : "contact";
  return "stays between " + smallest + " and " + millimetres(pair.largest);
}

std::string thresholdEntry(const RobotModel& robot, const ShapeRefPair& pair, double distance) {
  // The YAML reader of rosparam takes 1e-05 for a text.
  return "{links: [" + yamlName(nameOf(pair.a, robot)) + ", " + yamlName(nameOf(pair.b, robot)) +
         "], distance: " + system::shortestDecimal(distance) + "}";
}

std::string thresholdsYaml(const RobotModel& robot, const std::vector<AlwaysNear>& pairs, const StopAndWarn& usual) {
  std::string text;
  for (const auto& [name, threshold] :
       {std::pair("pair_stop_distance", &StopAndWarn::stop), std::pair("pair_warn_distance", &StopAndWarn::warn)}) {
    text += name + std::string(pairs.empty() ? ": []\n" : ":\n");
    for (const AlwaysNear& pair : pairs) {
      text += "- " + thresholdEntry(robot, pair.pair, fittingThresholds(pair, usual).*threshold) + "  # " +
              distancesText(pair) + "\n";
    }
  }
  return text;
}

std::string adviceText(const RobotModel& robot, const AlwaysNear& pair, const StopAndWarn& usual) {
  const Link &a = robot.links[pair.pair.a.link()], &b = robot.links[pair.pair.b.link()];
  std::vector<std::string> joints;
  for (const int joint : jointsBetween(robot, a.body, b.body)) joints.push_back(robot.joints[joint].name);
  const StopAndWarn fitting = fittingThresholds(pair, usual);
  return a.name + " - " + b.name + " " + distancesText(pair) + " whatever " + listed(joints) +
         (joints.size() == 1 ? " does" : " do") + ": pair_stop_distance: [" +
         thresholdEntry(robot, pair.pair, fitting.stop) + "], pair_warn_distance: [" +
         thresholdEntry(robot, pair.pair, fitting.warn) + "]";
}

}  // namespace proximity_server::scene
