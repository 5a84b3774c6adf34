#include "proximity_server/scene/levels/make_scene_model.h"

#include "proximity_server/scene/filter/srdf_reason.h"
#include "proximity_server/scene/levels/always_near.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/query/scene.h"
#include "scene/filter/link_table.h"
#include "scene/model/numbers.h"
#include "scene/scene_model/given_model.h"

#include <algorithm>
#include <cstdio>
#include <random>

namespace proximity_server::scene {
namespace {

constexpr int kStates = 300;  // the number of states of each joint, from one end of its range to the other

/// The checked pairs with one joint between them. Neighbours among them are checked because a user asked for it.
std::vector<ShapeRefPair> pairsOfOneJoint(const SceneModel& model, const std::vector<JointRange>& ranges) {
  std::vector<ShapeRefPair> pairs;
  for (const int i : model.pairs.checked) {
    const LinkPair& pair = model.pairs.pairs[i];
    const auto path = model.robot.connection(pair.link_a, pair.link_b);
    if (!path || path->movable_joints != 1) continue;
    if (rangesBetween(model.robot, ranges, pair.link_a, pair.link_b).empty()) continue;  // floating or planar
    pairs.push_back({{pair.link_a, 0}, {pair.link_b, 0}});
  }
  return pairs;
}

/// The positions in which all joints are at the same fraction, from 0 to 1, of their ranges.
Positions positionsAt(double fraction, const std::vector<JointRange>& ranges, const RobotModel& robot) {
  Positions positions(robot.joints.size(), 0.0);
  for (const JointRange& range : ranges) positions[range.joint] = range.lower + fraction * range.width();
  return positions;
}

/// The pairs of one joint that are not proven to be apart in any of kStates states.
std::vector<ShapeRefPair> alwaysInContact(const SceneModel& model) {
  const std::vector<JointRange> ranges = jointRanges(model.robot);
  std::vector<ShapeRefPair> pairs = pairsOfOneJoint(model, ranges);
  if (pairs.empty()) return pairs;
  Scene scene(lent(model));
  State current(lent(model));
  Question question;
  question.threshold = 0.0;
  question.depth = Question::Depth::NotWanted;
  for (int state = 0; state < kStates && !pairs.empty(); ++state) {
    current.set(forwardKinematics(model.robot, positionsAt(state / (kStates - 1.0), ranges, model.robot)));
    const auto is_apart = [&](const ShapeRefPair& pair) {
      return scene.proximity(current, pair, question).result.lower_bound > 0.0;
    };
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(), is_apart), pairs.end());
  }
  return pairs;
}

}  // namespace

SceneModel makeSceneModel(RobotModel robot, const std::string& srdf_xml, const PairFilterOptions& options) {
  return makeSceneModel(std::move(robot), std::vector<std::string>{srdf_xml}, options);
}

SceneModel makeSceneModel(RobotModel robot, const std::vector<std::string>& srdf_xmls,
                          const PairFilterOptions& options) {
  PairTable table = filterPairs(robot, srdf_xmls, options);
  SceneModel model{std::move(robot), std::move(table)};
  std::vector<std::string> names;
  for (const ShapeRefPair& pair : alwaysInContact(model)) {
    names.push_back(LinkTable(model.robot).names({pair.a.link(), pair.b.link()}));
  }
  addPairsWarning("Checked, but in contact in each of " + std::to_string(kStates) +
                      " states of the joint between them, which is nearly always an overlap of the model itself; to "
                      "disable one: disable_collisions in the SRDF, or exclude_pairs",
                  names, model.pairs);
  return model;
}

std::vector<DisabledPair> disabledPairsBelow(const SceneModel& model, const PairDistances& stop) {
  struct Seen {
    int index;
    ShapeRefPair pair;
    double smallest = kInfinity, largest = -kInfinity;
  };
  std::vector<Seen> seen;
  for (std::size_t i = 0; i < model.pairs.pairs.size(); ++i) {
    const LinkPair& pair = model.pairs.pairs[i];
    if (pair.reason == PairReason::SrdfDisabled && !isDecision(pair.detail) &&
        !model.robot.areNeighbours(pair.link_a, pair.link_b))
      seen.push_back({static_cast<int>(i), {{pair.link_a}, {pair.link_b}}});
  }
  if (seen.empty()) return {};
  Scene scene(lent(model));
  State current(lent(model));
  Question question;
  question.threshold = 0.0;
  question.thresholds = &stop;
  question.depth = Question::Depth::NotWanted;
  const std::vector<JointRange> ranges = jointRanges(model.robot);
  std::mt19937_64 random(1);
  constexpr int kMostStates = 1000, kMostDistances = 1'000'000;
  const int states = std::clamp(kMostDistances / static_cast<int>(seen.size()), 50, kMostStates);
  for (int state = 0; state < states; ++state) {
    current.set(forwardKinematics(model.robot, randomPositions(model.robot, ranges, random)));
    for (Seen& one : seen) {
      if (one.smallest == 0.0 && one.largest > 0.0) continue;  // more states give no more information
      const double distance = std::max(0.0, scene.proximity(current, one.pair, question).result.lower_bound);
      one.smallest = std::min(one.smallest, distance);
      one.largest = std::max(one.largest, distance);
    }
  }
  std::vector<DisabledPair> near;
  for (const Seen& one : seen)
    if (one.largest > 0.0 && one.smallest <= stop.of(one.pair)) near.push_back({one.index, one.smallest});
  return near;
}

void warnOfNearPairs(SceneModel& model, const LevelThresholds& thresholds) {
  const double largest = thresholds.stop.range(PairKind::OfLinks).largest;
  for (const AlwaysNear& near : findAlwaysNear(model, largest)) {
    if (near.largest > thresholds.stop.of(near.pair)) continue;
    model.pairs.warnings.push_back("Always at STOP: " +
                                   adviceText(model.robot, near, {thresholds.stop.links, thresholds.warn.links}));
  }
  std::vector<std::string> names;
  for (const DisabledPair& disabled : disabledPairsBelow(model, thresholds.stop)) {
    const LinkPair& pair = model.pairs.pairs[disabled.pair];
    char distance[32];
    std::snprintf(distance, sizeof distance, " (%.1f mm)", 1e3 * disabled.smallest);
    names.push_back(LinkTable(model.robot).names({pair.link_a, pair.link_b}) +
                    (disabled.smallest > 0.0 ? distance : " (contact)"));
  }
  addPairsWarning(
      "Not checked, as the SRDF disables them, although they come within their stop distance in random states; to "
      "check one, take out its disable_collisions, and give it a pair_stop_distance if it is near by design; to leave "
      "it so, say why in its entry: reason=\"User: ...\"",
      names, model.pairs);
}

}  // namespace proximity_server::scene
