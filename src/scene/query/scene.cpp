#include "proximity_server/scene/query/scene.h"

#include "scene/query/pair_ranking.h"
#include "scene/scene_model/given_model.h"

#include <algorithm>
#include <utility>

namespace proximity_server::scene {

Scene::Scene(std::shared_ptr<const SceneModel> model, Skipping skipping)
    : Scene(model, std::make_shared<const Candidates>(given(model).pairs), skipping) {}

Scene::Scene(std::shared_ptr<const SceneModel> model, std::shared_ptr<const Candidates> candidates, Skipping skipping)
    : model_(std::move(model)),
      candidates_(std::move(candidates)),
      skipping_(skipping),
      ranking_(std::make_unique<PairRanking>(*model_, skipping_)) {}

Scene Scene::forAnotherThread() const { return {model_, candidates_, skipping_}; }

Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

const Candidates& Scene::candidates() const { return *candidates_; }

const PairCounts& Scene::counts() const { return ranking_->counts(); }

PairProximity Scene::proximity(const State& state, const ShapeRefPair& pair, const Question& question) {
  return ranking_->one(state, pair, question);
}

const PairProximity* Scene::minimum(const State& state, const Pairs& pairs, const Question& question) {
  const auto& found = ranking_->closest(state, pairs, 1, PairRanking::Goal::Closest, question);
  return found.empty() ? nullptr : &found.front();
}

const std::vector<PairProximity>& Scene::closest(const State& state, const Pairs& pairs, int k,
                                                 const Question& question) {
  return ranking_->closest(state, pairs, static_cast<std::size_t>(std::max(k, 0)), PairRanking::Goal::Closest,
                           question);
}

const std::vector<PairProximity>& Scene::below(const State& state, const Pairs& pairs, const Question& question) {
  return ranking_->closest(state, pairs, PairRanking::kAll, PairRanking::Goal::Closest, question);
}

PairsBelow Scene::closestBelow(const State& state, const Pairs& pairs, int most, const Question& question) {
  const auto wanted = static_cast<std::size_t>(std::max(most, 0));
  const auto& closest = ranking_->closest(state, pairs, wanted, PairRanking::Goal::ClosestAndCount, question);
  return {closest, ranking_->countBelow()};
}

const PairProximity* Scene::first(const State& state, const Pairs& pairs, const Question& question) {
  const auto& found = ranking_->closest(state, pairs, 1, PairRanking::Goal::Any, question);
  return found.empty() ? nullptr : &found.front();
}

const std::vector<PairProximity>& Scene::all(const State& state, const Pairs& pairs, const Question& question) {
  return ranking_->all(state, pairs, question);
}

}  // namespace proximity_server::scene
