#include "peers/sweep_library.h"

#include <algorithm>

#include "proximity_server/scene/model/kinematics.h"

namespace proximity_server::peers {

using namespace scene;
namespace {

PairDistance pairOf(const PairProximity& pair, const Candidates& candidates) {
  return {numberOf(pair.asked, candidates, nullptr), pair.result.distance};
}

}  // namespace

void SweepBatch::ask(const States& states, SweepQuestion question) {
  verdicts_ = nullptr;
  minima_ = nullptr;
  lists_ = nullptr;
  switch (question) {
    case SweepQuestion::AnyBelow:
      verdicts_ = &batch_.anyBelow(states, kBelow);
      return;
    case SweepQuestion::Minimum:
      minima_ = &batch_.minimum(states);
      return;
    case SweepQuestion::Closest:
      lists_ = &batch_.closest(states, kClosest);
      return;
    case SweepQuestion::Below:
      lists_ = &batch_.below(states, kBelow);
  }
}

std::vector<SweepAnswer> SweepBatch::answers() const {
  std::vector<SweepAnswer> answers;
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

void SweepStates::ask(const States& states, SweepQuestion question) {
  positions_.resize(static_cast<std::size_t>(states.cols()));
  count_ = states.rows();
  if (answers_.size() < static_cast<std::size_t>(count_)) answers_.resize(static_cast<std::size_t>(count_));
  for (Eigen::Index i = 0; i < states.rows(); ++i) {
    for (std::size_t j = 0; j < positions_.size(); ++j) positions_[j] = states(i, static_cast<Eigen::Index>(j));
    SweepAnswer& place = answers_[static_cast<std::size_t>(i)];
    place.pairs.clear();
    answer(positions_, question, place);
  }
}

void SweepScene::answer(const std::vector<double>& positions, SweepQuestion question, SweepAnswer& answer) {
  const Candidates& candidates = scene_.candidates();
  scene_.update(forwardKinematics(scene_.model().robot, positions));
  switch (question) {
    case SweepQuestion::AnyBelow:
      answer.is_below = scene_.first(candidates, within(kBelow)) != nullptr;
      return;
    case SweepQuestion::Minimum:
      if (const PairProximity* pair = scene_.minimum(candidates)) answer.pairs.push_back(pairOf(*pair, candidates));
      return;
    case SweepQuestion::Closest:
      for (const PairProximity& pair : scene_.closest(candidates, kClosest))
        answer.pairs.push_back(pairOf(pair, candidates));
      return;
    case SweepQuestion::Below:
      for (const PairProximity& pair : scene_.below(candidates, within(kBelow)))
        answer.pairs.push_back(pairOf(pair, candidates));
  }
}

void SweepFcl::answer(const std::vector<double>& positions, SweepQuestion question, SweepAnswer& answer) {
  const BodyPoses poses = forwardKinematics(model_->robot, positions);
  switch (question) {
    case SweepQuestion::AnyBelow:
      answer.is_below = fcl_.anyBelow(poses, kBelow);
      return;
    case SweepQuestion::Closest:
      answer.pairs = fcl_.closestPairs(poses, kClosest);
      return;
    case SweepQuestion::Minimum:
    case SweepQuestion::Below:
      fcl_.ask(poses, question == SweepQuestion::Minimum ? SceneQuestion::Minimum : SceneQuestion::Below);
      answer.pairs = fcl_.answer();
      std::sort(answer.pairs.begin(), answer.pairs.end(),
                [](const PairDistance& a, const PairDistance& b) { return a.distance < b.distance; });
  }
}

void SweepSpheres::answer(const std::vector<double>& positions, SweepQuestion question, SweepAnswer& answer) {
  spheres_.place(positions.data(), 1);
  switch (question) {
    case SweepQuestion::AnyBelow:
      answer.is_below = spheres_.anyBelow(kBelow);
      return;
    case SweepQuestion::Minimum:
      answer.pairs.push_back(spheres_.minimum());
      return;
    case SweepQuestion::Closest:
      answer.pairs = spheres_.closest(kClosest);
      return;
    case SweepQuestion::Below:
      answer.pairs = spheres_.below(kBelow);
  }
}

}  // namespace proximity_server::peers
