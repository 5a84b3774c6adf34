#include "scene/batch/batch_model.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "proximity_server/scene/query/pair_distances.h"
#include "scene/batch/pair_order.h"
#include "scene/filter/given_model.h"

namespace proximity_server::scene {

BatchModel::BatchModel(std::shared_ptr<const SceneModel> scene_model)
    : model(std::move(scene_model)),
      candidates(given(model).pairs),
      volumes(std::make_shared<const Volumes>(model->robot)) {
  const RobotModel& robot = model->robot;
  for (int joint = 0; joint < static_cast<int>(robot.joints.size()); ++joint) leaders.push_back(robot.leaderOf(joint));
  const PairDistances paddings = paddingsOf(model->pairs);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const ShapeRefPair& pair = candidates[i];
    const auto [a, b] = std::minmax({volumes->of(pair.a), volumes->of(pair.b)});
    visits.push_back({-std::numeric_limits<double>::infinity(), static_cast<int>(i), a, b, paddings.of(pair)});
  }
  lanes = std::make_shared<const LaneModel>(*model);
  order = pairOrder(robot, lanes);
}

}  // namespace proximity_server::scene
