#pragma once

#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/question.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

namespace proximity_server::scene {

/// The distances of all pairs, each settled by itself, less their own thresholds: every other question has to agree
/// with them within `agreement` [m].
class AllPairs {
 public:
  AllPairs(const std::vector<PairProximity>& all, double agreement, const PairDistances& thresholds = {})
      : all_(all), agreement_(agreement), thresholds_(thresholds) {
    for (const PairProximity& pair : all) sorted_.push_back(excessOf(pair));
    std::sort(sorted_.begin(), sorted_.end());
  }

  double smallest(std::size_t i) const { return sorted_.at(i); }

  double of(const ShapeRefPair& asked) const {
    for (const PairProximity& pair : all_)
      if (pair.asked.a == asked.a && pair.asked.b == asked.b) return excessOf(pair);
    ADD_FAILURE() << "nobody asked for that pair";
    return std::numeric_limits<double>::quiet_NaN();
  }

  std::size_t countBelow(double threshold) const {
    return static_cast<std::size_t>(std::upper_bound(sorted_.begin(), sorted_.end(), threshold) - sorted_.begin());
  }

  /// Expects that so many pairs are below a threshold; those within the agreement of it may be.
  void expectCount(std::size_t count, double threshold) const {
    ASSERT_GE(count, countBelow(threshold - agreement_));
    ASSERT_LE(count, countBelow(threshold + agreement_));
  }

  /// Expects that the i-th of the found is the i-th closest; where two distances agree either pair may be.
  void expectClosest(const std::vector<PairProximity>& found) const {
    for (std::size_t i = 0; i < found.size(); ++i) {
      ASSERT_EQ(found[i].result.status, narrowphase::Status::Converged);
      ASSERT_NEAR(excessOf(found[i]), smallest(i), agreement_);
      ASSERT_NEAR(excessOf(found[i]), of(found[i].asked), agreement_);
      if (i > 0) {
        ASSERT_LE(excessOf(found[i - 1]), excessOf(found[i]));
      }
      for (std::size_t j = 0; j < i; ++j)
        ASSERT_FALSE(found[i].asked.a == found[j].asked.a && found[i].asked.b == found[j].asked.b)
            << "the same pair twice";
    }
  }

 private:
  double excessOf(const PairProximity& pair) const { return pair.result.distance - thresholds_.of(pair.asked); }

  const std::vector<PairProximity>& all_;
  const double agreement_;
  const PairDistances thresholds_;
  std::vector<double> sorted_;
};

}  // namespace proximity_server::scene
