#pragma once

#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/query/question.h"
#include "scene/query/same_pair.h"
#include "scene/random_states.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace proximity_server::scene {

inline std::vector<PairProximity> ofState(const StatePairs& all, Eigen::Index state) {
  const auto i = static_cast<std::size_t>(state);
  return {all.pairs.begin() + static_cast<std::ptrdiff_t>(all.begins[i]),
          all.pairs.begin() + static_cast<std::ptrdiff_t>(all.begins[i + 1])};
}

inline testing::AssertionResult areSameLists(const std::vector<PairProximity>& found,
                                             const std::vector<PairProximity>& expected) {
  if (found.size() != expected.size())
    return testing::AssertionFailure() << found.size() << " pairs instead of " << expected.size();
  for (std::size_t i = 0; i < found.size(); ++i)
    if (!areSame(found[i], expected[i]))
      return testing::AssertionFailure() << "pair " << i << ": links " << found[i].asked.a.link() << " and "
                                         << found[i].asked.b.link() << " at " << found[i].result.distance
                                         << " instead of links " << expected[i].asked.a.link() << " and "
                                         << expected[i].asked.b.link() << " at " << expected[i].result.distance;
  return testing::AssertionSuccess();
}

/// By which SceneBatch sorts pairs.
inline double rankOf(const PairProximity& pair) {
  return pair.result.status == narrowphase::Status::Converged ? pair.result.distance : pair.result.lower_bound;
}

inline void sortByRank(std::vector<PairProximity>& pairs) {  // of pairs in their order
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const PairProximity& p, const PairProximity& q) { return rankOf(p) < rankOf(q); });
}

inline std::vector<PairProximity> firstOf(const std::vector<PairProximity>& pairs, std::size_t count) {
  return {pairs.begin(), pairs.begin() + static_cast<std::ptrdiff_t>(std::min(count, pairs.size()))};
}

/// The pair that sets the level.
inline PairProximity decidingOf(const std::vector<PairProximity>& pairs, const LevelThresholds& thresholds) {
  const PairProximity* decides = nullptr;
  std::pair<int, double> worst;
  for (const PairProximity& pair : pairs) {
    const DistanceLevel level =
        levelOf(pair.result.lower_bound, thresholds.stop.of(pair.asked), thresholds.warn.of(pair.asked));
    const std::pair<int, double> place{-static_cast<int>(level.level), rankOf(pair) - level.threshold};
    if (decides && !(place < worst)) continue;
    decides = &pair;
    worst = place;
  }
  return decides ? *decides : PairProximity{};
}

/// Random states, and short edges of small steps between them.
inline Eigen::MatrixXd variousStates(const RobotModel& robot, int count, unsigned seed) {
  Eigen::MatrixXd states = randomStates(robot, count, seed);
  for (Eigen::Index i = 1; i < states.rows(); ++i)
    if (i % 16 >= 8) states.row(i) = states.row(i - 1) + 0.01 * (states.row(i) - states.row(i - 1));
  return states;
}

/// All that a batch answers about states.
struct BatchAnswers {
  BatchAnswers(SceneBatch& batch, const States& states, const LevelThresholds& thresholds)
      : minima(batch.minimum(states)),
        within(batch.minimumWithin(states, 1e-4)),
        deciding(batch.deciding(states, thresholds)),
        closest(batch.closest(states, 3)),
        below(batch.below(states, 0.05)),
        verdicts(batch.anyBelow(states, 0.05)) {}

  std::vector<PairProximity> minima, within, deciding;
  StatePairs closest, below;
  std::vector<StateVerdict> verdicts;
};

/// Expects of the states of `part` what `whole` says of those with the given numbers.
inline void expectSame(const BatchAnswers& part, const BatchAnswers& whole, const std::vector<Eigen::Index>& numbers) {
  ASSERT_EQ(part.minima.size(), numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto number = static_cast<std::size_t>(numbers[i]);
    ASSERT_TRUE(areSameLists({part.minima[i], part.within[i], part.deciding[i]},
                             {whole.minima[number], whole.within[number], whole.deciding[number]}));
    for (const auto lists : {&BatchAnswers::closest, &BatchAnswers::below}) {
      ASSERT_TRUE(areSameLists(ofState(part.*lists, static_cast<Eigen::Index>(i)), ofState(whole.*lists, numbers[i])));
      ASSERT_EQ((part.*lists).unknown[i], (whole.*lists).unknown[number]);
    }
    ASSERT_EQ(part.verdicts[i].kind, whole.verdicts[number].kind);
    ASSERT_EQ(part.verdicts[i].pair, whole.verdicts[number].pair);
  }
}

}  // namespace proximity_server::scene
