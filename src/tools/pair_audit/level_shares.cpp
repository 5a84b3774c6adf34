#include "tools/pair_audit/level_shares.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <random>
#include <utility>

#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/model/joint_ranges.h"

namespace proximity_server::tools {
namespace {

using LinkPairs = std::map<std::pair<int, int>, scene::StopAndWarn>;

Eigen::MatrixXd randomStates(const scene::RobotModel& robot, unsigned long seed) {
  const std::vector<scene::JointRange> ranges = scene::jointRanges(robot);
  std::mt19937_64 random(seed);
  Eigen::MatrixXd states(LevelCounts::kStates, robot.joints.size());
  for (Eigen::Index i = 0; i < states.rows(); ++i) {
    const scene::Positions positions = scene::randomPositions(robot, ranges, random);
    states.row(i) = Eigen::Map<const Eigen::RowVectorXd>(positions.data(), states.cols());
  }
  return states;
}

/// 0: CLEAR to 3: COLLISION. As in the node, the lower bound decides.
std::size_t levelAt(double lower_bound, const scene::StopAndWarn& thresholds) {
  if (!(lower_bound > 0.0)) return 3;
  if (!(lower_bound > thresholds.stop)) return 2;
  return lower_bound > thresholds.warn ? 0 : 1;
}

std::string rowText(const char* name, const LevelCounts& counts) {
  std::string row = name;
  for (const int states : counts.states) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "  %7.1f %%", 100.0 * states / LevelCounts::kStates);
    row += text.data();
  }
  return row + "\n";
}

}  // namespace

LevelCounts countLevels(const std::shared_ptr<const scene::SceneModel>& model, const scene::StopAndWarn& usual,
                        const std::vector<scene::AlwaysNear>& own, unsigned long seed) {
  LinkPairs fitting;
  for (const scene::AlwaysNear& each : own) {
    fitting[{each.pair.a.link, each.pair.b.link}] = scene::fittingThresholds(each, usual);
  }
  scene::SceneBatch batch(model);
  const scene::StatePairs& near = batch.below(randomStates(model->robot, seed), usual.warn);
  LevelCounts counts;
  for (std::size_t state = 0; state + 1 < near.begins.size(); ++state) {
    std::size_t level = 0;
    for (std::size_t i = near.begins[state]; i < near.begins[state + 1]; ++i) {
      const scene::PairProximity& pair = near.pairs[i];
      const auto found = fitting.find({pair.asked.a.link, pair.asked.b.link});
      level = std::max(level, levelAt(pair.result.lower_bound, found == fitting.end() ? usual : found->second));
    }
    ++counts.states[level];
  }
  return counts;
}

std::string levelTable(const LevelCounts& before, const LevelCounts& after) {
  return "\nThe level in " + std::to_string(LevelCounts::kStates) +
         " random states:\n              CLEAR       WARN       STOP  COLLISION\n" + rowText("  before", before) +
         rowText("  after ", after);
}

}  // namespace proximity_server::tools
