#pragma once

#include "proximity_server/scene/scene_model/scene_model.h"
#include "scene/state/placed_robot.h"

#include <vector>

namespace proximity_server::scene {

/// The bounds of pairs that are proven apart in ranges of their joints (LinkPair::proven), in one set of poses.
///
/// 1. The position of a joint is read from the poses of the two bodies that it connects, when a pair asks for it.
/// 2. If the two do not stand as the kinematics says for this position, within kJointAgreement, nothing is known of all
///    pairs with the joint between them. So poses of tf that differ from the model never use a proof about the model.
/// 3. The bound of a pair holds if the positions of all its joints are in one of its ranges.
class ProvenPairs {
 public:
  explicit ProvenPairs(const SceneModel& model);

  bool empty() const { return pairs_.empty(); }

  /// To be called when the poses change. Before the first call no bound is known.
  void forgetPositions() { ++update_; }

  /// [m] A lower bound of the distance of two links, before the padding of the pair is subtracted; minus infinity if none
  /// above `least` is proven. `robot` has the poses of the last forgetPositions().
  double boundAbove(double least, const PartPair& parts, const PlacedRobot& robot);

 private:
  struct Pair {
    PartPair links;           ///< a < b
    std::vector<int> joints;  ///< those between the two, and their leaders, which come first
    const ProvenRanges* proven;
  };
  struct Reading {
    int body = -1;  ///< that the joint carries
    long update = 0;
    double position = 0.0;  ///< NaN if it is not known
  };

  double positionOf(int joint, const PlacedRobot& robot);
  double read(int joint, const PlacedRobot& robot);

  const RobotModel& model_;
  std::vector<Pair> pairs_;        ///< sorted by links
  std::vector<Reading> readings_;  ///< by joint
  long update_ = 0;
};

}  // namespace proximity_server::scene
