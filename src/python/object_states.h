#pragma once

#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/query/scene.h"
#include "python/pair_numbers.h"

#include <vector>

namespace proximity_server::python {

/// Answers the questions of a SceneBatch for a robot with objects, which a SceneBatch does not have. A Scene answers
/// them, one state after the other.
///
/// The scene begins without memory, but remembers its answers about earlier states. So an answer depends on the states
/// before it, within the tolerance. A state in which a pair has no pose is Unknown.
class ObjectStates {
 public:
  /// `fresh` must have the objects, and no poses. The numbers must outlive this object.
  ObjectStates(const scene::Scene& fresh, const PairNumbers& numbers)
      : scene_(fresh.forAnotherThread()), numbers_(numbers) {}

  const std::vector<scene::PairProximity>& minimum(const scene::States& states);
  /// The exact answer, which is within any accuracy [m].
  const std::vector<scene::PairProximity>& minimumWithin(const scene::States& states, double /*accuracy*/) {
    return minimum(states);
  }
  const std::vector<scene::PairProximity>& deciding(const scene::States& states,
                                                    const scene::LevelThresholds& thresholds);
  const scene::StatePairs& closest(const scene::States& states, int k);
  const scene::StatePairs& below(const scene::States& states, double distance);
  /// In the result, StateVerdict::pair is one of the numbers.
  const std::vector<scene::StateVerdict>& anyBelow(const scene::States& states, double distance);

 private:
  bool setState(const scene::States& states, Eigen::Index state);
  bool isComplete() const { return scene_.counts().unknown == 0; }
  template <typename Ask>
  const std::vector<scene::PairProximity>& answerEach(const scene::States& states, const Ask& ask);
  template <typename Ask>
  const scene::StatePairs& listEach(const scene::States& states, const Ask& ask);

  scene::Scene scene_;
  const PairNumbers& numbers_;
  std::vector<double> positions_;
  std::vector<scene::PairProximity> answers_;
  scene::StatePairs lists_;
  std::vector<scene::StateVerdict> verdicts_;
};

}  // namespace proximity_server::python
