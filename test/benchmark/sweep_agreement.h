#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "peers/sweep_library.h"

namespace proximity_server::benchmark {

using namespace peers;

/// How far the answers of another library lie from ours, state by state; ours are proven.
///
/// states: that were compared. Of AnyBelow: below_missed counts the states in which ours is below and the other is not,
/// below_claimed the other way round. Of the others, for pairs by rank that both say are apart: compared; differing: by more
/// than 1e-6 m; too_near and too_far: the largest errors [m] in either direction; and overlaps_missed and overlaps_claimed.
/// Of Below also other_pairs: states with another number of pairs.
nlohmann::json sweepAgreement(SweepQuestion question, const std::vector<SweepAnswer>& ours,
                              const std::vector<SweepAnswer>& others);

}  // namespace proximity_server::benchmark
