#include "proximity_server/scene/moving_scene.h"

#include <utility>

#include "motion_search.h"

namespace proximity_server {

MovingScene::MovingScene(std::shared_ptr<const SceneModel> model)
    : search_(std::make_unique<MotionSearch>(model, std::make_shared<const Volumes>(model->robot))) {}
MovingScene::MovingScene(std::unique_ptr<MotionSearch> search) : search_(std::move(search)) {}
MovingScene::~MovingScene() = default;
MovingScene::MovingScene(MovingScene&&) noexcept = default;
MovingScene& MovingScene::operator=(MovingScene&&) noexcept = default;

MovingScene MovingScene::twin() const {
  return MovingScene(std::make_unique<MotionSearch>(search_->model(), search_->volumes()));
}

const SceneModel& MovingScene::model() const { return *search_->model(); }

RobotContact MovingScene::timeOfContact(const std::vector<SubjectPair>& pairs, const RobotMotion& motion,
                                        const MotionQuestion& question) {
  return search_->firstContact(pairs, motion, question);
}

RobotMinimum MovingScene::minimum(const std::vector<SubjectPair>& pairs, const RobotMotion& motion,
                                  const MotionQuestion& question) {
  return search_->minimum(pairs, motion, question);
}

}  // namespace proximity_server
