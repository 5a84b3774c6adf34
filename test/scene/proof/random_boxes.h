#pragma once

#include "chance.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "proximity_server/scene/proof/joint_box.h"
#include "scene/posed_scene.h"

#include <algorithm>
#include <vector>

namespace proximity_server::scene {

/// [m] The upper bound of the distance of a pair in a state.
inline double distanceIn(PosedScene& scene, const Positions& positions, const ShapeRefPair& pair) {
  const BodyPoses poses = forwardKinematics(scene.model().robot, positions);
  if (scene.objects())
    setPoses(scene.state, poses);
  else
    scene.update(poses);
  return scene.proximity(pair).result.upper_bound;
}

inline std::vector<ShapeRefPair> checkedPairs(const SceneModel& model, const Objects* objects) {
  std::vector<ShapeRefPair> pairs = Candidates(model.pairs).list();
  if (objects) objects->forEachCheckedPair([&](const ShapeRef& a, const ShapeRef& b) { pairs.push_back({a, b}); });
  return pairs;
}

/// Random intervals within the limits.
inline JointBox someBox(const RobotModel& robot, Chance& chance) {
  JointBox box = jointRanges(robot);
  for (JointRange& interval : box) {
    const double size = chance.decades(-1.5, 0.8), centre = chance.between(-2.5, 2.5);
    const bool slides = robot.joints[interval.joint].type == Joint::Type::Prismatic;
    const double half = (slides ? 0.1 : 0.5) * size, middle = (slides ? 0.2 : 1.0) * centre;
    interval.lower = chance.below(8) == 0 ? middle : middle - half;
    interval.upper = interval.lower == middle ? middle : middle + half;
  }
  return box;
}

/// A state of a box; half of them are corners in most joints.
inline Positions someStateIn(const RobotModel& robot, const JointBox& box, Chance& chance) {
  const bool is_corner = chance.below(2) == 0;
  Positions positions(robot.joints.size(), 0.0);
  for (const JointRange& interval : box) {
    const int kind = is_corner ? chance.below(5) : 4;
    positions[interval.joint] = kind == 4  ? chance.between(interval.lower, interval.upper)
                                : kind < 2 ? interval.lower
                                           : interval.upper;
    positions[interval.joint] = std::min(positions[interval.joint], interval.upper);
  }
  return positions;
}

inline bool hasOnePositionEach(const RobotModel& robot, const ShapeRefPair& pair) {
  for (const int joint : jointsBetween(robot, robot.links[pair.a.link()].body, robot.links[pair.b.link()].body))
    if (!hasOnePosition(robot.joints[joint]) || !hasOnePosition(robot.joints[robot.leaderOf(joint).joint]))
      return false;
  return true;
}

inline std::vector<ShapeRefPair> provablePairs(const SceneModel& model) {
  std::vector<ShapeRefPair> pairs;
  for (const ShapeRefPair& pair : checkedPairs(model, nullptr))
    if (hasOnePositionEach(model.robot, pair)) pairs.push_back(pair);
  return pairs;
}

}  // namespace proximity_server::scene
