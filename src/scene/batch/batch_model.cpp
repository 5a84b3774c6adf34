#include "scene/batch/batch_model.h"

#include "proximity_server/scene/model/joint_ranges.h"
#include "scene/lanes/lane_bounds.h"
#include "scene/model/numbers.h"
#include "scene/scene_model/given_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

constexpr int kBlocks = 4;
constexpr double kNear = 0.05;  // [m]

/// States whose positions are multiples of an irrational number, a different one for each joint. They fill the unit
/// cube evenly.
/// Source: Weyl, Ueber die Gleichverteilung von Zahlen mod. Eins, 1916.
Eigen::MatrixXd spreadStates(const RobotModel& robot, int block) {
  const int first = block * LaneBounds::kBlock;
  Eigen::MatrixXd states = Eigen::MatrixXd::Zero(LaneBounds::kBlock, static_cast<Eigen::Index>(robot.joints.size()));
  for (const JointRange& range : jointRanges(robot)) {
    const double multiple = std::sqrt(2.0 + 3.0 * range.joint) + 0.1;
    for (int i = 0; i < LaneBounds::kBlock; ++i) {
      const double place = multiple * (first + i + 1);
      states(i, range.joint) = range.lower + (place - std::floor(place)) * range.width();
    }
  }
  return states;
}

/// The numbers of the candidates. Those come first that are proven nearer than 5 cm most often in a fixed set of
/// states, which are spread evenly over the ranges of the joints.
std::vector<int> pairOrder(const RobotModel& robot, const std::shared_ptr<const LaneModel>& lanes) {
  LaneBounds bounds(lanes);
  const int pairs = static_cast<int>(lanes->pairs.size());
  std::vector<int> near_count(static_cast<std::size_t>(pairs), 0), states;
  for (int block = 0; block < kBlocks; ++block) {
    bounds.place(spreadStates(robot, block));
    for (int pair = 0; pair < pairs; ++pair) {
      states.clear();
      for (int i = 0; i < LaneBounds::kBlock; ++i)
        if (bounds.isPlaced(i)) states.push_back(i);
      const int count = bounds.keepNear(pair, kNear, states.data(), static_cast<int>(states.size()));
      for (const LaneBounds::Side side : bounds.sides(pair, kNear, states.data(), count))
        near_count[pair] += side == LaneBounds::Side::Below ? 1 : 0;
    }
  }
  std::vector<int> order(static_cast<std::size_t>(pairs));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return near_count[a] > near_count[b]; });
  return order;
}

}  // namespace

BatchModel::BatchModel(std::shared_ptr<const SceneModel> scene_model)
    : model(std::move(scene_model)),
      candidates(given(model).pairs),
      volumes(std::make_shared<const Volumes>(model->robot)) {
  const RobotModel& robot = model->robot;
  for (int joint = 0; joint < static_cast<int>(robot.joints.size()); ++joint) leaders.push_back(robot.leaderOf(joint));
  const PairDistances paddings = paddingsOf(model->pairs);
  for (const ShapeRefPair& pair : candidates) add(pair, paddings);
  lanes = std::make_shared<const LaneModel>(*model, *volumes);
  for (const LaneModel::Pair& pair : lanes->pairs)
    if (pair.hasGeometry()) deepest = std::max(deepest, pair.depth);
  order = pairOrder(robot, lanes);
}

BatchModel::BatchModel(const BatchModel& robot, std::shared_ptr<const Objects> of_robot) : BatchModel(robot) {
  if (&of_robot->model() != model.get()) throw std::invalid_argument("the objects are those of another model");
  pairs.resize(candidates.size());
  visits.resize(candidates.size());
  const PairDistances paddings = paddingsOf(model->pairs);
  of_robot->forEachCheckedPair([&](const ShapeRef& a, const ShapeRef& b) {
    add({a, b}, paddings);
    // Only the second part of a pair may have half-spaces.
    PartPair& parts = visits.back();
    const ShapeRef& first = parts.a == volumes->of(a) ? a : b;
    if (first.isObject() && of_robot->placed(first.object())->isUnbounded()) std::swap(parts.a, parts.b);
  });
  objects = std::make_shared<const BatchObjects>(std::move(of_robot), visits, candidates.size(), *volumes, *lanes);
}

void BatchModel::add(const ShapeRefPair& pair, const PairDistances& paddings) {
  const auto [a, b] = std::minmax({volumes->of(pair.a), volumes->of(pair.b)});
  visits.push_back({{a, b}, -kInfinity, static_cast<int>(pairs.size()), paddings.of(pair)});
  pairs.push_back(pair);
}

}  // namespace proximity_server::scene
