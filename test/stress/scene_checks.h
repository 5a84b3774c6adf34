#pragma once

#include "proximity_server/scene/motion/motion_search.h"
#include "stress/campaign.h"
#include "stress/scene_cells.h"

#include <optional>
#include <string>

namespace proximity_server::scene {

/// The result of the states of one cell.
struct SceneObservation {
  stress::Tally& tally;
  std::optional<std::string> failure{};  ///< a promise that was not kept
};

/// Asks two scenes all questions, in any order, in so many states of a cell: one scene that has seen all states before,
/// and at times one that has not; and about a motion from some of the states. Each answer is held against the signed
/// distances of all pairs of convex parts, see StateTruth; in one of part.per_reference cells those of the nearest
/// parts also against rational numbers or branch and bound.
///
/// Counts: scenes; their checked pairs, and of these the unknown ones, which have no pose; questions, and the sums of
///         their PairCounts, of which counted is the total; answers: pairs in the answers; minima: nearest pairs that
///         a scene has found, and of these overlaps and those with_object; with_oracle: nearest pairs of convex parts
///         that the slow oracle has seen; others: distances that FCL, or Bullet where its two ways agree, was asked
///         for, and of these others_off: farther than 1e-4 from ours, so that the slow oracle decides; motions, and of
///         these contacts and motions_open, whose answer did not converge.
void observeScenes(const stress::Part& part, int states, stress::Tally& tally);

/// Asks for the smallest distance and the first contact of a random motion of a cell, with any contact distances, and
/// holds both against the signed distances of all pairs of convex parts at some times. Leaves the cell where it was.
void observeMotion(SceneCell& cell, MotionSearch& scene, SceneObservation& seen);

}  // namespace proximity_server::scene
