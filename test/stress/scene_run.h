#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "stress/scene_checks.h"

namespace proximity_server::scene {

struct SceneFailure {
  std::int64_t number;  ///< of the cell in its family
  int state;
  std::string sentence;
};

/// What a family's scenes showed.
struct SceneFamilySummary {
  std::string name;
  SceneObservation seen;  ///< the sums
  double seconds = 0.0;   ///< of all together
  std::int64_t failed = 0;
  std::vector<SceneFailure> failures;  ///< the first ones only

  void merge(const SceneFamilySummary& other);
};

struct SceneRun {
  std::int64_t scenes = 100000;  ///< of all families together, rounded up to whole rounds
  unsigned seed = 1;
  std::string family;  ///< one only; empty: all
  unsigned threads = 1;
  int cells_per_oracle = 20;  ///< in one of so many cells the slow oracle is asked too
};

/// A cell is seen in so many states, each of which is a scene.
constexpr int kStatesOfCell = 10;

/// Every cell depends on seed, family and number only, not on the threads. `done` counts the scenes while it runs.
/// Throws std::invalid_argument for an unknown family.
std::vector<SceneFamilySummary> runScenes(const SceneRun& run, std::atomic<std::int64_t>& done);

}  // namespace proximity_server::scene
