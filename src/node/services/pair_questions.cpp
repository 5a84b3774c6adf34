#include "node/services/pair_questions.h"

#include "node/answers/conversions.h"
#include "node/answers/statuses.h"
#include "node/services/requests.h"
#include "proximity_server/scene/answers/pair_selection.h"
#include "proximity_server/scene/derivative/derivatives.h"
#include "system/durations.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <vector>

namespace proximity_server::node {
namespace {

/// Returns the pairs that the mode asks for, of `checked` pairs.
scene::PairSelection selectionOf(const QueryPairsRequest& request, std::size_t checked) {
  using Kind = scene::PairSelection::Kind;
  switch (request.mode) {
    case QueryPairsRequest::MINIMUM:
      return {Kind::Minimum};
    case QueryPairsRequest::FIRST:
      return {Kind::Any};
    case QueryPairsRequest::K_CLOSEST:
      return {Kind::Closest, static_cast<int>(maxReturned(request, checked))};
    case QueryPairsRequest::PER_PAIR:
      return {Kind::All};
    case QueryPairsRequest::BELOW_THRESHOLD:
      return {Kind::Below};
    default:
      refuse("mode " + std::to_string(request.mode) + " does not exist");
  }
}

bool isCloser(const Proximity& a, const Proximity& b) {
  if (a.state == Proximity::UNKNOWN || b.state == Proximity::UNKNOWN) return b.state == Proximity::UNKNOWN;
  return a.lower_bound < b.lower_bound;
}

}  // namespace

double thresholdOrNone(double threshold) {
  return finite(threshold, "threshold") > 0.0 ? threshold : std::numeric_limits<double>::infinity();
}

scene::Question questionOf(const Robot& robot) {
  scene::Question question;
  question.tolerance = robot.config().tolerance;
  question.deadline = system::deadlineIn(robot.config().max_request_time);
  return question;
}

scene::Question questionOf(const Robot& robot, const QueryPairsRequest& request) {
  scene::Question question = questionOf(robot);
  const bool is_literal =
      request.mode == QueryPairsRequest::FIRST || request.mode == QueryPairsRequest::BELOW_THRESHOLD;
  question.threshold = is_literal ? finite(request.threshold, "threshold") : thresholdOrNone(request.threshold);
  if (request.skip_penetration) question.depth = scene::Question::Depth::NotWanted;
  return question;
}

scene::Uncertainty uncertaintyOf(const Robot& robot, const std::string& text) try {
  return text.empty() ? robot.uncertainty() : scene::uncertaintyFrom(text, "uncertainty", robot.robotModel());
} catch (const std::invalid_argument& error) {
  refuse(error.what());
}

scene::GuaranteedDistances* guaranteedWithin(const scene::Uncertainty& uncertainty, PosedScenes& scenes,
                                             const scene::Question& question) {
  if (uncertainty.isZero()) return nullptr;
  scene::GuaranteeLimits limits;
  limits.deadline = question.deadline;
  scenes.guaranteed().assume(uncertainty);
  scenes.guaranteed().limit(limits);
  return &scenes.guaranteed();
}

QueryStatus statusOf(const Robot& robot, const scene::GuaranteedDistances& guaranteed) {
  if (guaranteed.end() == scene::GuaranteeEnd::None) return {};
  return statusOf(QueryStatus::OVER_BUDGET, "the time was over: guaranteed distances are coarse, max_request_time is " +
                                                system::secondsText(robot.config().max_request_time));
}

StateProximity askPairs(const Robot& robot, PosedScenes& scenes, const FoundPoses& found, const RequestedPairs& pairs,
                        const QueryPairsRequest& request, const scene::Question& question,
                        scene::GuaranteedDistances* guaranteed) {
  StateProximity answer;
  answer.minimum = unknownProximity();
  const scene::State& state = scenes.state;
  const std::vector<scene::PairProximity> answers =
      selectPairs(scenes.scene, state, pairs.asked(), selectionOf(request, pairs.size()), question);
  assignCounts(answer, scenes.scene.counts());

  answer.pairs.reserve(answers.size());
  for (const scene::PairProximity& pair : answers) {
    Proximity& message = answer.pairs.emplace_back();
    assign(message, {state.robot(), state.objects().get()}, found.poses, pair, question);
    if (request.want_gradient) scene::gradient(state, pair, message.gradient);
    if (guaranteed) message.guaranteed = guaranteed->of(state, pair);
    if (pair.result.status != narrowphase::Status::Unknown)
      answer.status.code = std::min(answer.status.code, statusCode(pair.result));
  }
  if (guaranteed && answer.status.code == QueryStatus::OK) answer.status = statusOf(robot, *guaranteed);
  const bool decided = request.mode == QueryPairsRequest::FIRST && !answers.empty();
  if (answer.pairs_unknown > 0 && !decided) {
    const bool posed = found.status.code == QueryStatus::OK;
    answer.status = posed ? incompleteness(robot, scenes.scene.counts(), question) : found.status;
    return answer;
  }
  const auto closest = std::min_element(answer.pairs.begin(), answer.pairs.end(), isCloser);
  if (closest != answer.pairs.end()) answer.minimum = *closest;
  return answer;
}

}  // namespace proximity_server::node
