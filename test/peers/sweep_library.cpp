#include "peers/sweep_library.h"

#include <stdexcept>

namespace proximity_server::peers {

using namespace scene;
namespace {

PairDistance pairOf(const PairProximity& pair, const Candidates& candidates) {
  return {numberOf(pair.asked, candidates, nullptr), pair.result.distance};
}

}  // namespace

void SweepBatch::ask(const States& states, SceneQuestion question) {
  verdicts_ = nullptr;
  minima_ = nullptr;
  lists_ = nullptr;
  switch (question) {
    case SceneQuestion::AnyBelow:
      verdicts_ = &batch_.anyBelow(states, kBelow);
      return;
    case SceneQuestion::Minimum:
      minima_ = accuracy_ > 0.0 ? &batch_.minimumWithin(states, accuracy_) : &batch_.minimum(states);
      return;
    case SceneQuestion::Closest:
      lists_ = &batch_.closest(states, kClosest);
      return;
    case SceneQuestion::Below:
      lists_ = &batch_.below(states, kBelow);
      return;
    case SceneQuestion::Contact:
    case SceneQuestion::All:
      throw std::invalid_argument("a batch has neither a first contact nor a list of all pairs");
  }
}

std::vector<SceneAnswer> SweepBatch::answers() const {
  std::vector<SceneAnswer> answers;
  if (verdicts_ != nullptr)
    for (const StateVerdict& verdict : *verdicts_) answers.push_back({verdict.kind == StateVerdict::Kind::Below});
  if (minima_ != nullptr)
    for (const PairProximity& pair : *minima_) answers.push_back({false, {pairOf(pair, batch_.candidates())}});
  if (lists_ != nullptr)
    for (std::size_t i = 0; i + 1 < lists_->begins.size(); ++i) {
      answers.emplace_back();
      for (std::size_t j = lists_->begins[i]; j < lists_->begins[i + 1]; ++j)
        answers.back().pairs.push_back(pairOf(lists_->pairs[j], batch_.candidates()));
    }
  return answers;
}

void SweepStates::ask(const States& states, SceneQuestion question) {
  positions_.resize(states.cols());
  count_ = states.rows();
  if (answers_.size() < static_cast<std::size_t>(count_)) answers_.resize(count_);
  for (Eigen::Index i = 0; i < states.rows(); ++i) {
    for (std::size_t j = 0; j < positions_.size(); ++j) positions_[j] = states(i, static_cast<Eigen::Index>(j));
    SceneAnswer& place = answers_[i];
    place.pairs.clear();
    answer(positions_, question, place);
  }
}

void SweepScene::answer(const std::vector<double>& positions, SceneQuestion question, SceneAnswer& answer) {
  library_->ask(forwardKinematics(model_->robot, positions), question);
  library_->giveAnswer(answer);
}

void SweepSpheres::answer(const std::vector<double>& positions, SceneQuestion question, SceneAnswer& answer) {
  spheres_.place(positions.data(), 1);
  switch (question) {
    case SceneQuestion::AnyBelow:
      answer.is_below = spheres_.anyBelow(kBelow);
      return;
    case SceneQuestion::Minimum:
      answer.pairs.push_back(spheres_.minimum());
      return;
    case SceneQuestion::Closest:
      answer.pairs = spheres_.closest(kClosest);
      return;
    case SceneQuestion::Below:
      answer.pairs = spheres_.below(kBelow);
      return;
    case SceneQuestion::Contact:
    case SceneQuestion::All:
      throw std::invalid_argument("spheres have neither a first contact nor a list of all pairs");
  }
}

}  // namespace proximity_server::peers
