#include "proximity_server/scene/query/scene.h"

#include "proximity_server/scene/model/kinematics.h"
#include "scene/query/pair_ranking.h"
#include "scene/scene_model/given_model.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {

Scene::Scene(std::shared_ptr<const SceneModel> model, Skipping skipping)
    : Scene(model, std::make_shared<const Candidates>(given(model).pairs),
            std::make_shared<const Volumes>(given(model).robot), skipping) {}

Scene::Scene(std::shared_ptr<const SceneModel> model, std::shared_ptr<const Candidates> candidates,
             std::shared_ptr<const Volumes> volumes, Skipping skipping)
    : model_(std::move(model)),
      candidates_(std::move(candidates)),
      volumes_(std::move(volumes)),
      skipping_(skipping),
      ranking_(std::make_unique<PairRanking>(*model_, volumes_, skipping_)) {}

Scene Scene::forAnotherThread() const {
  Scene other(model_, candidates_, volumes_, skipping_);
  if (const auto& objects = ranking_->objects()) other.use(objects);
  return other;
}

Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

const Candidates& Scene::candidates() const { return *candidates_; }

void Scene::use(std::shared_ptr<const Objects> objects) {
  if (&objects->model() != model_.get()) throw std::invalid_argument("the objects are those of another model");
  ranking_->use(std::move(objects));
}

const Objects* Scene::objects() const { return ranking_->objects().get(); }

void Scene::update(const BodyPoses& poses) { ranking_->update(poses); }

void Scene::update(const BodyPoses& poses, const FramePoses& frames) { ranking_->update(poses, frames); }

std::optional<Eigen::Isometry3d> Scene::poseOf(int body) const { return ranking_->robot().poseOfBody(body); }

std::optional<Eigen::Isometry3d> Scene::poseOfObject(int number) const {
  return poseOf(static_cast<int>(model_->robot.bodies.size()) + number);
}

const PairCounts& Scene::counts() const { return ranking_->counts(); }

PairProximity Scene::proximity(const ShapeRefPair& pair, const Question& question) {
  return ranking_->one(pair, question);
}

const PairProximity* Scene::minimum(const Pairs& pairs, const Question& question) {
  const auto& found = ranking_->closest(pairs, 1, PairRanking::Goal::Closest, question);
  return found.empty() ? nullptr : &found.front();
}

const std::vector<PairProximity>& Scene::closest(const Pairs& pairs, int k, const Question& question) {
  return ranking_->closest(pairs, static_cast<std::size_t>(std::max(k, 0)), PairRanking::Goal::Closest, question);
}

const std::vector<PairProximity>& Scene::below(const Pairs& pairs, const Question& question) {
  return ranking_->closest(pairs, PairRanking::kAll, PairRanking::Goal::Closest, question);
}

PairsBelow Scene::closestBelow(const Pairs& pairs, int most, const Question& question) {
  const auto wanted = static_cast<std::size_t>(std::max(most, 0));
  const auto& closest = ranking_->closest(pairs, wanted, PairRanking::Goal::ClosestAndCount, question);
  return {closest, ranking_->countBelow()};
}

const PairProximity* Scene::first(const Pairs& pairs, const Question& question) {
  const auto& found = ranking_->closest(pairs, 1, PairRanking::Goal::Any, question);
  return found.empty() ? nullptr : &found.front();
}

const std::vector<PairProximity>& Scene::all(const Pairs& pairs, const Question& question) {
  return ranking_->all(pairs, question);
}

}  // namespace proximity_server::scene
