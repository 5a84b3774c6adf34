#pragma once

#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/pairs.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "scene/batch/batch_objects.h"
#include "scene/lanes/lane_model.h"
#include "scene/state/visit_queue.h"
#include "scene/state/volumes.h"

#include <memory>
#include <vector>

namespace proximity_server::scene {

/// The constant data that all states and all batches made by SceneBatch::forAnotherThread() share.
struct BatchModel {
  explicit BatchModel(std::shared_ptr<const SceneModel> scene_model);

  /// The model of `robot` with other objects. Failure: throws as SceneBatch::use() does.
  BatchModel(const BatchModel& robot, std::shared_ptr<const Objects> objects);

  std::shared_ptr<const SceneModel> model;
  Candidates candidates;
  std::shared_ptr<const Volumes> volumes;
  std::vector<Joint::Mimic> leaders;  ///< for each joint, see RobotModel::leaderOf()

  /// The candidate pairs, then the pairs with objects.
  std::vector<ShapeRefPair> pairs;

  /// These pairs by the numbers of their parts, as PairMeasurement::visitOf() finds them, with minus infinity as bound.
  std::vector<Visit> visits;

  std::shared_ptr<const BatchObjects> objects;  ///< nullptr without objects

  std::shared_ptr<const LaneModel> lanes;
  double deepest = 0.0;    ///< [m] no pair of links overlaps by more
  std::vector<int> order;  ///< the numbers of the candidates; those that are near most often come first

 private:
  void add(const ShapeRefPair& pair, const PairDistances& paddings);
};

}  // namespace proximity_server::scene
