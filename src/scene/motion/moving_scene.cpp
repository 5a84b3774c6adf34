#include "proximity_server/scene/motion/moving_scene.h"

#include "scene/motion/motion_search.h"
#include "scene/scene_model/given_model.h"

#include <algorithm>
#include <utility>

namespace proximity_server::scene {
namespace {

using Phase = PhasedMotion::Phase;

MotionCounts together(const MotionCounts& p, const MotionCounts& q) {
  MotionCounts counts;
  counts.pairs = std::max(p.pairs, q.pairs);
  counts.unknown = std::max(p.unknown, q.unknown);
  counts.by_one_bound = std::min(p.by_one_bound, q.by_one_bound);
  counts.intervals = p.intervals + q.intervals;
  counts.queries = p.queries + q.queries;
  return counts;
}

RobotTimeOfContact onWhole(const Phase& phase, RobotTimeOfContact found) {
  found.t_free = phase.onWhole(found.t_free);
  if (found.contact) found.t_contact = phase.onWhole(found.t_contact);
  return found;
}

/// Joins the answers of successive phases. `before` found no contact. What it left open stays open.
RobotTimeOfContact followedBy(const RobotTimeOfContact& before, RobotTimeOfContact next) {
  next.counts = together(before.counts, next.counts);
  if (before.status == narrowphase::Status::Converged) return next;
  next.t_free = before.t_free;
  next.status = lessComplete(before.status, next.status);
  return next;
}

RobotMinimum onWhole(const Phase& phase, RobotMinimum found) {
  if (found.time >= 0.0) found.time = phase.onWhole(found.time);
  return found;
}

RobotMinimum followedBy(const RobotMinimum& before, const RobotMinimum& next) {
  RobotMinimum closer = next.upper_bound < before.upper_bound ? next : before;
  closer.lower_bound = std::min(before.lower_bound, next.lower_bound);
  closer.status = lessComplete(before.status, next.status);
  closer.counts = together(before.counts, next.counts);
  return closer;
}

}  // namespace

MovingScene::MovingScene(const std::shared_ptr<const SceneModel>& model)
    : search_(std::make_unique<MotionSearch>(State(model))) {}
MovingScene::MovingScene(const State& state) : search_(std::make_unique<MotionSearch>(state.forAnotherThread())) {}
MovingScene::~MovingScene() = default;
MovingScene::MovingScene(MovingScene&&) noexcept = default;
MovingScene& MovingScene::operator=(MovingScene&&) noexcept = default;

MovingScene MovingScene::forAnotherThread() const { return MovingScene(search_->state()); }

const SceneModel& MovingScene::model() const { return search_->state().model(); }

void MovingScene::use(std::shared_ptr<const Objects> objects) { search_->use(std::move(objects)); }

const Objects* MovingScene::objects() const { return search_->objects().get(); }

RobotTimeOfContact MovingScene::timeOfContact(const Pairs& pairs, const RobotMotion& motion,
                                              const MotionQuestion& question) {
  return search_->timeOfContact(pairs, motion, question);
}

RobotMinimum MovingScene::minimum(const Pairs& pairs, const RobotMotion& motion, const MotionQuestion& question) {
  return search_->minimum(pairs, motion, question);
}

RobotTimeOfContact MovingScene::timeOfContact(const Pairs& pairs, const PhasedMotion& motion,
                                              const MotionQuestion& question) {
  const std::vector<Phase>& phases = motion.phases();
  RobotTimeOfContact answer = onWhole(phases.front(), timeOfContact(pairs, phases.front().motion, question));
  for (std::size_t i = 1; i < phases.size() && !answer.contact; ++i) {
    answer = followedBy(answer, onWhole(phases[i], timeOfContact(pairs, phases[i].motion, question)));
  }
  return answer;
}

RobotMinimum MovingScene::minimum(const Pairs& pairs, const PhasedMotion& motion, const MotionQuestion& question) {
  const std::vector<Phase>& phases = motion.phases();
  RobotMinimum answer = onWhole(phases.front(), minimum(pairs, phases.front().motion, question));
  for (std::size_t i = 1; i < phases.size(); ++i) {
    answer = followedBy(answer, onWhole(phases[i], minimum(pairs, phases[i].motion, question)));
  }
  return answer;
}

}  // namespace proximity_server::scene
