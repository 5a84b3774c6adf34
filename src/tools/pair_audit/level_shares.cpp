#include "tools/pair_audit/level_shares.h"

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/query/scene.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <random>
#include <tuple>

namespace proximity_server::tools {
namespace {

using Level = scene::ClearanceLevel;

constexpr std::size_t kFirstRandom = 2;  // in levelStates()

std::string rowText(const char* name, const LevelShares& shares) {
  std::string row = name;
  for (const int states : shares.counts()) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "  %9s", shareText(states).c_str());
    row += text.data();
  }
  return row + "\n";
}

}  // namespace

std::vector<scene::Positions> levelStates(const scene::RobotModel& robot, unsigned long seed,
                                          const std::optional<scene::Positions>& rest) {
  const std::vector<scene::JointRange> ranges = scene::jointRanges(robot);
  const scene::Positions zeros(robot.joints.size(), 0.0);
  std::vector<scene::Positions> states{rest.value_or(zeros), zeros};
  for (const scene::JointRange& range : ranges) {
    double &at_rest = states[0][range.joint], &middle = states[1][range.joint];
    middle = range.typeable(0.5 * (range.lower + range.upper));
    if (at_rest == 0.0 && (range.lower > 0.0 || range.upper < 0.0)) at_rest = middle;
  }
  std::mt19937_64 random(seed);
  for (int i = 0; i < LevelShares::kStates; ++i) states.push_back(scene::randomPositions(robot, ranges, random));
  return states;
}

bool PairLevels::isSuspect() const { return at_rest == Level::Collision || 2 * collisions > LevelShares::kStates; }

std::array<int, 4> LevelShares::counts() const {
  std::array<int, 4> counts{};
  for (std::size_t i = kFirstRandom; i < of_states.size(); ++i) ++counts[static_cast<std::size_t>(of_states[i])];
  return counts;
}

std::vector<PairLevels> LevelShares::suspects() const {
  const auto end = std::find_if(of_pairs.begin(), of_pairs.end(), [](const auto& pair) { return !pair.isSuspect(); });
  return {of_pairs.begin(), end};
}

LevelShares levelShares(const std::shared_ptr<const scene::SceneModel>& model, const scene::LevelThresholds& thresholds,
                        const std::vector<scene::Positions>& states) {
  scene::Scene scene(model);
  scene::State state(model);
  scene::Question question;
  question.threshold = thresholds.warn.range(scene::PairKind::OfLinks).largest;
  question.depth = scene::Question::Depth::NotWanted;
  LevelShares shares;
  std::vector<PairLevels> pairs(model->pairs.pairs.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    state.set(scene::forwardKinematics(model->robot, states[i]));
    Level worst = Level::Clear;
    for (const scene::PairProximity& near : scene.below(state, scene.candidates(), question)) {
      const Level level = scene::levelOf(near, thresholds).level;
      worst = std::max(worst, level);
      PairLevels& levels = pairs[model->pairs.find(near.asked.a.link(), near.asked.b.link())];
      levels.pair = near.asked;
      if (i == 0) levels.at_rest = level;
      if (i < kFirstRandom) continue;
      levels.collisions += level == Level::Collision;
      levels.stops += level == Level::Stop;
    }
    shares.of_states.push_back(worst);
  }
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(shares.of_pairs), [](const PairLevels& pair) {
    return pair.collisions > 0 || pair.stops > 0 || pair.at_rest >= Level::Stop;
  });
  const auto rankOf = [](const PairLevels& pair) { return std::tuple(pair.isSuspect(), pair.collisions, pair.stops); };
  std::stable_sort(shares.of_pairs.begin(), shares.of_pairs.end(),
                   [&](const PairLevels& one, const PairLevels& other) { return rankOf(one) > rankOf(other); });
  return shares;
}

std::string levelTable(const LevelShares& before, const LevelShares& after) {
  return "\nThe level in " + std::to_string(LevelShares::kStates) +
         " random states:\n              CLEAR       WARN       STOP  COLLISION\n" + rowText("  before", before) +
         rowText("  after ", after);
}

std::string levelsText(const LevelShares& shares) {
  std::string text;
  for (const Level level : {Level::Clear, Level::Warn, Level::Stop, Level::Collision})
    text += (text.empty() ? "" : ", ") + shareText(shares.counts()[static_cast<std::size_t>(level)]) + " " +
            toString(level);
  return text;
}

std::string shareText(int states) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f %%", 100.0 * states / LevelShares::kStates);
  return text.data();
}

std::string contactText(const PairLevels& pair) {
  const bool at_rest = pair.at_rest == Level::Collision;
  if (at_rest && pair.collisions == 0) return "in contact at rest and in no random state";
  return std::string("in contact ") + (at_rest ? "at rest and " : "") + "in " + shareText(pair.collisions) +
         " of random states";
}

}  // namespace proximity_server::tools
