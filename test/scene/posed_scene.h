#pragma once

#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/state/state.h"

#include <memory>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// A Scene with the State that it is asked about, for tests of one state after the other.
struct PosedScene {
  explicit PosedScene(const std::shared_ptr<const SceneModel>& model, Skipping skipping = Skipping::On)
      : state(model), scene(model, skipping) {}
  PosedScene forAnotherThread() const { return {state.forAnotherThread(), scene.forAnotherThread()}; }

  void use(std::shared_ptr<const Objects> objects) { state.set(std::move(objects)); }
  void use(std::shared_ptr<const Objects> objects, ObjectCarriers carriers) {
    state.set(std::move(objects), std::move(carriers));
  }
  void update(const BodyPoses& poses) { state.set(poses); }
  void update(const BodyPoses& poses, const FramePoses& frames) { state.set(poses, frames); }

  const SceneModel& model() const { return scene.model(); }
  const Objects* objects() const { return state.objects().get(); }
  const Candidates& candidates() const { return scene.candidates(); }
  const PairCounts& counts() const { return scene.counts(); }

  PairProximity proximity(const ShapeRefPair& pair, const Question& question = {}) {
    return scene.proximity(state, pair, question);
  }
  const PairProximity* minimum(const Pairs& pairs, const Question& question = {}) {
    return scene.minimum(state, pairs, question);
  }
  const std::vector<PairProximity>& closest(const Pairs& pairs, int k, const Question& question = {}) {
    return scene.closest(state, pairs, k, question);
  }
  const std::vector<PairProximity>& below(const Pairs& pairs, const Question& question) {
    return scene.below(state, pairs, question);
  }
  PairsBelow closestBelow(const Pairs& pairs, int most, const Question& question) {
    return scene.closestBelow(state, pairs, most, question);
  }
  const PairProximity* first(const Pairs& pairs, const Question& question) {
    return scene.first(state, pairs, question);
  }
  const std::vector<PairProximity>& all(const Pairs& pairs, const Question& question = {}) {
    return scene.all(state, pairs, question);
  }

  State state;
  Scene scene;

 private:
  PosedScene(State own_state, Scene own_scene) : state(std::move(own_state)), scene(std::move(own_scene)) {}
};

}  // namespace proximity_server::scene
