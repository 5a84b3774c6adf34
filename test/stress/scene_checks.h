#pragma once

#include <optional>
#include <string>

#include "stress/scene_cells.h"

namespace proximity_server::scene {

/// What the states of one cell showed.
struct SceneObservation {
  int scenes = 0;
  std::int64_t pairs = 0;  ///< checked ones of all states
  std::int64_t questions = 0;
  std::int64_t answers = 0;      ///< pairs in the answers
  std::int64_t minima = 0;       ///< nearest pairs of a state, as one scene or both have found them
  std::int64_t overlaps = 0;     ///< of these, overlaps
  std::int64_t with_object = 0;  ///< of these, pairs with an object
  std::int64_t unknown = 0;      ///< pairs without a pose
  std::int64_t skipped = 0;      ///< pairs of minimum() that were not computed
  std::int64_t with_oracle = 0;  ///< nearest pairs of convex parts that the slow oracle has seen
  std::int64_t others = 0;       ///< distances that FCL, or Bullet where its two ways agree, was asked for
  std::int64_t others_off = 0;   ///< of these farther than 1e-4 from ours; then the slow oracle decides
  std::int64_t motions = 0;
  std::int64_t contacts = 0;           ///< of these, such with a contact
  std::int64_t motions_open = 0;       ///< and such with an answer that did not converge
  std::optional<std::string> failure;  ///< a promise that was not kept
  int failed_state = -1;
};

/// Asks two scenes all questions, in any order, in every state of a cell: one that has seen all states before, and at
/// times one that has not; and about a motion from some of the states. Each answer is held against the signed distances of all
/// pairs of convex parts, see StateTruth. `with_oracle`: the nearest parts also by rational numbers or branch and bound.
SceneObservation observeScenes(std::size_t family, unsigned seed, std::int64_t number, int states, bool with_oracle);

}  // namespace proximity_server::scene
