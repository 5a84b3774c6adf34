#pragma once

#include "proximity_server/scene/proof/joint_box.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/scene_model/shape_ref.h"

#include <string>
#include <vector>

// Files with ranges of joint positions in which pairs are proven apart, though they may collide elsewhere.

namespace proximity_server::scene {

/// A pair of links that is proven apart in some ranges of its joints.
struct ConditionalPair {
  ShapeRefPair pair;
  double distance;  ///< [m] above 0: a lower bound of the distance, without padding of the pair, in all the ranges
  std::vector<JointBox> ranges;  ///< a joint that is not in a range has all positions within its limits
};

/// The pairs as YAML, with a hash of the robot:
///
///   model: 3f0c5ad1e9b2c476
///   pairs:
///   - links: [upper_arm, hand]
///     distance: 0.05
///     ranges:
///     - {elbow: [-1.2, 2]}
std::string conditionalPairsYaml(const RobotModel& robot, const std::vector<ConditionalPair>& pairs);

/// Adds the pairs of such a file to the model: a scene then skips a pair as long as its joints are in one of its ranges
/// and the bound is enough for the question. Answers do not change by that. A proof is used only for poses that agree
/// with the kinematics, see kJointAgreement, and `distance` becomes a little less for that.
///
/// Failure: throws std::invalid_argument with `source`, the line and the field: no YAML of this form, another hash, a
///          link, joint or pair that does not exist, a pair that appears twice, a distance that is not above 0, an
///          interval as jointBoxFrom() refuses it, a joint between the two without known limits or with several degrees
///          of freedom.
void addConditionalPairs(const std::string& yaml, const std::string& source, SceneModel& model);

/// Adds the pairs of a file. Failure: also if it cannot be read.
void readConditionalPairs(const std::string& path, SceneModel& model);

}  // namespace proximity_server::scene
