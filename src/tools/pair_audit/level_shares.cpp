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

/// As in the node, the lower bound of the distance decides.
Level levelAt(double lower_bound, const scene::StopAndWarn& thresholds) {
  if (!(lower_bound > 0.0)) return Level::Collision;
  if (!(lower_bound > thresholds.stop)) return Level::Stop;
  return lower_bound > thresholds.warn ? Level::Clear : Level::Warn;
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

const char* toString(Level level) {
  switch (level) {
    case Level::Clear:
      return "CLEAR";
    case Level::Warn:
      return "WARN";
    case Level::Stop:
      return "STOP";
    case Level::Collision:
      return "COLLISION";
  }
  return "unknown";
}

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

std::vector<Level> levelsIn(const Eigen::MatrixXd& states, const std::shared_ptr<const scene::SceneModel>& model,
                            const PairLevels& thresholds) {
  std::map<std::pair<int, int>, scene::StopAndWarn> own;
  for (const scene::AlwaysNear& each : thresholds.own) {
    own[{each.pair.a.link, each.pair.b.link}] = scene::fittingThresholds(each, thresholds.usual);
  }
  scene::SceneBatch batch(model);
  const scene::StatePairs& near = batch.below(states, thresholds.usual.warn);
  std::vector<Level> levels(static_cast<std::size_t>(states.rows()), Level::Clear);
  for (std::size_t state = 0; state < levels.size(); ++state) {
    for (std::size_t i = near.begins[state]; i < near.begins[state + 1]; ++i) {
      const scene::PairProximity& pair = near.pairs[i];
      const auto found = own.find({pair.asked.a.link, pair.asked.b.link});
      levels[state] = std::max(levels[state],
                               levelAt(pair.result.lower_bound, found == own.end() ? thresholds.usual : found->second));
    }
  }
  return levels;
}

LevelCounts countLevels(const std::shared_ptr<const scene::SceneModel>& model, const PairLevels& thresholds,
                        unsigned long seed) {
  LevelCounts counts;
  for (const Level level : levelsIn(randomStates(model->robot, seed), model, thresholds)) {
    ++counts.states[static_cast<std::size_t>(level)];
  }
  return counts;
}

std::string levelTable(const LevelCounts& before, const LevelCounts& after) {
  return "\nThe level in " + std::to_string(LevelCounts::kStates) +
         " random states:\n              CLEAR       WARN       STOP  COLLISION\n" + rowText("  before", before) +
         rowText("  after ", after);
}

}  // namespace proximity_server::tools
