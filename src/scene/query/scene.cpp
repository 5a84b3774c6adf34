#include "proximity_server/scene/query/scene.h"

#include <algorithm>
#include <utility>

#include "proximity_server/scene/model/kinematics.h"
#include "scene/query/pair_search.h"

namespace proximity_server::scene {

Scene::Scene(std::shared_ptr<const SceneModel> model, Skipping skipping)
    : Scene(model, std::make_shared<const Volumes>(model->robot), skipping) {}

Scene::Scene(std::shared_ptr<const SceneModel> model, std::shared_ptr<const Volumes> volumes, Skipping skipping)
    : model_(std::move(model)),
      volumes_(std::move(volumes)),
      skipping_(skipping),
      search_(std::make_unique<PairSearch>(*model_, volumes_, skipping_)) {}

Scene Scene::twin() const { return Scene(model_, volumes_, skipping_); }

Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

const std::vector<ShapeRefPair>& Scene::candidates() const { return search_->candidates(); }

void Scene::update(const BodyPoses& poses) { search_->update(poses); }

const PairCounts& Scene::counts() const { return search_->counts(); }

PairProximity Scene::proximity(const ShapeRefPair& pair, const Question& question) {
  return search_->one(pair, question);
}

const PairProximity* Scene::minimum(const std::vector<ShapeRefPair>& pairs, const Question& question) {
  const auto& found = search_->closest(pairs, 1, PairSearch::Goal::Nearest, question);
  return found.empty() ? nullptr : &found.front();
}

const std::vector<PairProximity>& Scene::closest(const std::vector<ShapeRefPair>& pairs, int k,
                                                 const Question& question) {
  return search_->closest(pairs, static_cast<std::size_t>(std::max(k, 0)), PairSearch::Goal::Nearest, question);
}

const std::vector<PairProximity>& Scene::below(const std::vector<ShapeRefPair>& pairs, const Question& question) {
  return search_->closest(pairs, pairs.size(), PairSearch::Goal::Nearest, question);
}

PairsBelow Scene::closestBelow(const std::vector<ShapeRefPair>& pairs, int most, const Question& question) {
  const auto wanted = static_cast<std::size_t>(std::max(most, 0));
  const auto& closest = search_->closest(pairs, wanted, PairSearch::Goal::NearestOfAll, question);
  return {closest, search_->countBelow()};
}

const PairProximity* Scene::first(const std::vector<ShapeRefPair>& pairs, const Question& question) {
  const auto& found = search_->closest(pairs, 1, PairSearch::Goal::Any, question);
  return found.empty() ? nullptr : &found.front();
}

const std::vector<PairProximity>& Scene::all(const std::vector<ShapeRefPair>& pairs, const Question& question) {
  return search_->all(pairs, question);
}

}  // namespace proximity_server::scene
