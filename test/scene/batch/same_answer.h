#pragma once

#include "allocations.h"
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

/// Asks all questions twice, the second time with the states in reverse order, and expects that then nothing is
/// allocated.
inline void expectNoAllocationTheSecondTime(SceneBatch& batch, const Eigen::MatrixXd& states,
                                            const LevelThresholds& thresholds) {
  const auto askAll = [&](const Eigen::MatrixXd& asked) {
    batch.minimum(asked);
    batch.minimumWithin(asked, 1e-4);
    batch.deciding(asked, thresholds);
    batch.closest(asked, 3);
    batch.below(asked, 0.05);
    batch.anyBelow(asked, 0.05);
  };
  const Eigen::MatrixXd reversed = states.colwise().reverse();
  askAll(states);
  const long before = allocations();
  askAll(reversed);
  EXPECT_EQ(allocations(), before);
}

}  // namespace proximity_server::scene
