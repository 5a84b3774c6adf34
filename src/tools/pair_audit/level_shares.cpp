#include "tools/pair_audit/level_shares.h"

#include "proximity_server/scene/answers/deciding_pair.h"
#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/kinematics.h"

#include <cstdio>
#include <random>

namespace proximity_server::tools {
namespace {

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

Eigen::MatrixXd randomStates(const scene::RobotModel& robot, unsigned long seed) {
  const std::vector<scene::JointRange> ranges = scene::jointRanges(robot);
  std::mt19937_64 random(seed);
  Eigen::MatrixXd states(LevelCounts::kStates, robot.joints.size());
  for (Eigen::Index i = 0; i < states.rows() && states.cols() > 0; ++i) {
    const scene::Positions positions = scene::randomPositions(robot, ranges, random);
    states.row(i) = Eigen::Map<const Eigen::RowVectorXd>(positions.data(), states.cols());
  }
  return states;
}

std::vector<scene::ClearanceLevel> levelsIn(const Eigen::MatrixXd& states,
                                            const std::shared_ptr<const scene::SceneModel>& model,
                                            const scene::LevelThresholds& thresholds, const TimeBudget& budget) {
  if (states.cols() == 0) {  // no joints: the only state there is, which SceneBatch does not take
    scene::Scene scene(model);
    scene::State state(model);
    state.set(scene::forwardKinematics(model->robot, scene::Positions()));
    const scene::PairProximity* closest = scene.minimum(state, scene.candidates());
    const auto level = closest
                           ? scene::decidingPair(scene, state, scene.candidates(), *closest, {thresholds}).level.level
                           : scene::ClearanceLevel::Clear;
    return std::vector<scene::ClearanceLevel>(static_cast<std::size_t>(states.rows()), level);
  }
  scene::SceneBatch batch(model);
  std::vector<scene::ClearanceLevel> levels;
  for (const scene::PairProximity& pair : batch.deciding(states, thresholds, budget.deadline)) {
    const bool is_known = pair.result.status != narrowphase::Status::Unknown;  // false: no pair is checked
    levels.push_back(is_known ? scene::levelOf(pair, thresholds).level : scene::ClearanceLevel::Clear);
  }
  budget.require();
  return levels;
}

LevelCounts countLevels(const std::shared_ptr<const scene::SceneModel>& model, const scene::LevelThresholds& thresholds,
                        unsigned long seed, const TimeBudget& budget) {
  LevelCounts counts;
  for (const scene::ClearanceLevel level : levelsIn(randomStates(model->robot, seed), model, thresholds, budget))
    ++counts.states[static_cast<std::size_t>(level)];
  return counts;
}

std::string levelTable(const LevelCounts& before, const LevelCounts& after) {
  return "\nThe level in " + std::to_string(LevelCounts::kStates) +
         " random states:\n              CLEAR       WARN       STOP  COLLISION\n" + rowText("  before", before) +
         rowText("  after ", after);
}

}  // namespace proximity_server::tools
