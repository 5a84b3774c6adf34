#pragma once

#include <vector>

#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/query/scene.h"
#include "python/pair_numbers.h"

namespace proximity_server::python {

/// The questions of a SceneBatch among objects, which it does not know: asked of a Scene, one state after the other.
///
/// The scene begins without memory, and starts warm from state to state: an answer depends, within the tolerance, on the states before
/// it. A state of which a pair has no pose is Unknown.
class ObjectStates {
 public:
  /// `fresh` has the objects, and no poses. The numbers must outlive this.
  ObjectStates(const scene::Scene& fresh, const PairNumbers& numbers) : scene_(fresh.twin()), numbers_(numbers) {}

  const std::vector<scene::PairProximity>& minimum(const scene::States& states);
  const std::vector<scene::PairProximity>& deciding(const scene::States& states,
                                                    const scene::LevelThresholds& thresholds);
  const scene::StatePairs& closest(const scene::States& states, int k);
  const scene::StatePairs& below(const scene::States& states, double distance);
  /// StateVerdict::pair is one of the numbers.
  const std::vector<scene::StateVerdict>& anyBelow(const scene::States& states, double distance);

 private:
  bool place(const scene::States& states, Eigen::Index state);
  bool isComplete() const { return scene_.counts().unknown == 0; }
  template <typename Ask>
  const std::vector<scene::PairProximity>& oneOfEach(const scene::States& states, const Ask& ask);
  template <typename Ask>
  const scene::StatePairs& listed(const scene::States& states, const Ask& ask);

  scene::Scene scene_;
  const PairNumbers& numbers_;
  std::vector<double> positions_;
  std::vector<scene::PairProximity> ones_;
  scene::StatePairs lists_;
  std::vector<scene::StateVerdict> verdicts_;
};

}  // namespace proximity_server::python
