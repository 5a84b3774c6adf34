#include "benchmark/sweep_agreement.h"

#include <algorithm>
#include <cmath>

#include "benchmark/agreement.h"

namespace proximity_server::benchmark {
namespace {

struct Differences {
  int compared = 0, differing = 0, overlaps_missed = 0, overlaps_claimed = 0, other_pairs = 0;
  double too_near = 0.0, too_far = 0.0;

  void add(double ours, double other) {
    if (ours <= 0.0 || other <= 0.0) {
      if (ours < -kAgreement && other > kAgreement) ++overlaps_missed;
      if (ours > kAgreement && other <= 0.0) ++overlaps_claimed;
      return;
    }
    ++compared;
    if (std::abs(ours - other) > kAgreement) ++differing;
    too_near = std::max(too_near, ours - other);
    too_far = std::max(too_far, other - ours);
  }
};

nlohmann::json verdictsOf(const std::vector<SweepAnswer>& ours, const std::vector<SweepAnswer>& others,
                          std::size_t states) {
  int missed = 0, claimed = 0, below = 0;
  for (std::size_t i = 0; i < states; ++i) {
    if (ours[i].is_below) ++below;
    if (ours[i].is_below && !others[i].is_below) ++missed;
    if (!ours[i].is_below && others[i].is_below) ++claimed;
  }
  return {{"states", states}, {"below", below}, {"below_missed", missed}, {"below_claimed", claimed}};
}

}  // namespace

nlohmann::json sweepAgreement(SweepQuestion question, const std::vector<SweepAnswer>& ours,
                              const std::vector<SweepAnswer>& others) {
  const std::size_t states = std::min(ours.size(), others.size());
  if (question == SweepQuestion::AnyBelow) return verdictsOf(ours, others, states);
  Differences found;
  for (std::size_t i = 0; i < states; ++i) {
    const std::vector<PairDistance>&our = ours[i].pairs, &other = others[i].pairs;
    if (our.size() != other.size()) ++found.other_pairs;
    for (std::size_t j = 0; j < std::min(our.size(), other.size()); ++j) found.add(our[j].distance, other[j].distance);
  }
  return {{"states", states},
          {"compared", found.compared},
          {"differing", found.differing},
          {"too_near", found.too_near},
          {"too_far", found.too_far},
          {"overlaps_missed", found.overlaps_missed},
          {"overlaps_claimed", found.overlaps_claimed},
          {"other_pairs", found.other_pairs}};
}

}  // namespace proximity_server::benchmark
