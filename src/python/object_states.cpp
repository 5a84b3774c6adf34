#include "python/object_states.h"

#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/frames_on_links.h"

#include <cmath>
#include <stdexcept>

namespace proximity_server::python {

using scene::PairProximity;

namespace {

scene::Question questionOf(double distance) {
  if (std::isnan(distance)) throw std::invalid_argument("the distance is not a number");
  scene::Question question;
  question.threshold = distance;
  return question;
}

}  // namespace

/// Moves the scene to a state. Returns false if a position of the state is not finite.
bool ObjectStates::setState(const scene::States& states, Eigen::Index state) {
  if (!states.row(state).allFinite()) return false;
  positions_.resize(states.cols());
  for (Eigen::Index j = 0; j < states.cols(); ++j) positions_[j] = states(state, j);
  const scene::BodyPoses poses = scene::forwardKinematics(scene_.model().robot, positions_);
  scene_.update(poses, scene::framePoses(*scene_.objects(), poses));
  return true;
}

/// Returns the pair that `ask` returns in each state. `ask` returns nullptr if there is no pair.
template <typename Ask>
const std::vector<PairProximity>& ObjectStates::answerEach(const scene::States& states, const Ask& ask) {
  answers_.assign(static_cast<std::size_t>(states.rows()), {});
  for (Eigen::Index state = 0; state < states.rows(); ++state) {
    if (!setState(states, state)) continue;
    const PairProximity* const pair = ask();
    if (pair && isComplete()) answers_[state] = *pair;
  }
  return answers_;
}

/// Returns the list of pairs that `ask` returns in each state.
template <typename Ask>
const scene::StatePairs& ObjectStates::listEach(const scene::States& states, const Ask& ask) {
  lists_.pairs.clear();
  lists_.begins.assign(1, 0);
  lists_.unknown.clear();
  for (Eigen::Index state = 0; state < states.rows(); ++state) {
    bool is_known = setState(states, state);
    if (is_known) {
      const std::vector<PairProximity>& found = ask();
      is_known = isComplete();
      if (is_known) lists_.pairs.insert(lists_.pairs.end(), found.begin(), found.end());
    }
    lists_.unknown.push_back(is_known ? 0 : 1);
    lists_.begins.push_back(lists_.pairs.size());
  }
  return lists_;
}

const std::vector<PairProximity>& ObjectStates::minimum(const scene::States& states) {
  return answerEach(states, [&] { return scene_.minimum(scene_.candidates()); });
}

const std::vector<PairProximity>& ObjectStates::deciding(const scene::States& states,
                                                         const scene::LevelThresholds& thresholds) {
  PairProximity decided;
  return answerEach(states, [&]() -> const PairProximity* {
    const PairProximity* const closest = scene_.minimum(scene_.candidates());
    if (!closest || !isComplete()) return closest;
    decided = scene::decidingPair(scene_, scene_.candidates(), PairProximity(*closest), thresholds).pair;
    return &decided;
  });
}

const scene::StatePairs& ObjectStates::closest(const scene::States& states, int k) {
  return listEach(
      states, [&]() -> const auto& { return scene_.closest(scene_.candidates(), k); });
}

const scene::StatePairs& ObjectStates::below(const scene::States& states, double distance) {
  const scene::Question question = questionOf(distance);
  return listEach(
      states, [&]() -> const auto& { return scene_.below(scene_.candidates(), question); });
}

const std::vector<scene::StateVerdict>& ObjectStates::anyBelow(const scene::States& states, double distance) {
  using Kind = scene::StateVerdict::Kind;
  scene::Question question = questionOf(distance);
  question.depth = scene::Question::Depth::NotWanted;
  verdicts_.assign(static_cast<std::size_t>(states.rows()), {});
  for (Eigen::Index state = 0; state < states.rows(); ++state) {
    if (!setState(states, state)) continue;
    const PairProximity* const first = scene_.first(scene_.candidates(), question);
    if (!isComplete()) continue;
    verdicts_[state] =
        first ? scene::StateVerdict{Kind::Below, numbers_.of(first->asked)} : scene::StateVerdict{Kind::Above, -1};
  }
  return verdicts_;
}

}  // namespace proximity_server::python
