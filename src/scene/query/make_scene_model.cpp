#include "proximity_server/scene/query/make_scene_model.h"

#include <algorithm>

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/query/scene.h"
#include "scene/filter/link_table.h"

namespace proximity_server::scene {
namespace {

constexpr int kStates = 300;  // of each joint, from one end of its range to the other

/// The checked pairs that one joint moves against each other. Neighbours among them are checked because somebody asked.
std::vector<ShapeRefPair> pairsOfOneJoint(const SceneModel& model, const std::vector<JointRange>& ranges) {
  std::vector<ShapeRefPair> pairs;
  for (const int i : model.pairs.checked) {
    const LinkPair& pair = model.pairs.pairs[i];
    const auto way = model.robot.connection(pair.link_a, pair.link_b);
    if (!way || way->movable_joints != 1) continue;
    if (rangesBetween(model.robot, ranges, pair.link_a, pair.link_b).empty()) continue;  // floating or planar
    pairs.push_back({{pair.link_a, 0}, {pair.link_b, 0}});
  }
  return pairs;
}

/// All joints at the same fraction, from 0 to 1, of their ranges.
Positions positionsAt(double fraction, const std::vector<JointRange>& ranges, const RobotModel& robot) {
  Positions positions(robot.joints.size(), 0.0);
  for (const JointRange& range : ranges) positions[range.joint] = range.lower + fraction * range.width();
  return positions;
}

/// Those of them that are proven to be apart in none of kStates states.
std::vector<ShapeRefPair> alwaysInContact(const SceneModel& model) {
  const std::vector<JointRange> ranges = jointRanges(model.robot);
  std::vector<ShapeRefPair> pairs = pairsOfOneJoint(model, ranges);
  if (pairs.empty()) return pairs;
  Scene scene(std::shared_ptr<const SceneModel>(std::shared_ptr<void>(), &model));  // lent: the scene ends first
  Question question;
  question.threshold = 0.0;
  question.depth = Question::Depth::NotWanted;
  for (int state = 0; state < kStates && !pairs.empty(); ++state) {
    scene.update(forwardKinematics(model.robot, positionsAt(state / (kStates - 1.0), ranges, model.robot)));
    const auto is_apart = [&](const ShapeRefPair& pair) {
      return scene.proximity(pair, question).result.lower_bound > 0.0;
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
    names.push_back(LinkTable(model.robot).names({pair.a.link, pair.b.link}));
  }
  addPairsWarning("Checked, but in contact in each of " + std::to_string(kStates) +
                      " states of the joint between them, which is nearly always an overlap of the model itself; to "
                      "disable one: disable_collisions in the SRDF, or exclude_pairs",
                  names, model.pairs);
  return model;
}

}  // namespace proximity_server::scene
