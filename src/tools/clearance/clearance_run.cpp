#include "tools/clearance/clearance_run.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/query/scene.h"
#include "tools/command_line/answers_in_blocks.h"

namespace proximity_server::tools {
namespace {

constexpr std::size_t kBlockSize = 256;  // states: so many that the cold start is a small part of the work

struct NumberedState {
  long number = 0;
  scene::Positions positions;
  std::shared_ptr<const scene::Objects> objects;
};

std::vector<scene::PairProximity> answerState(const scene::Pairs& pairs, const PairSelection& selection,
                                              scene::Scene& scene) {
  scene::Question near_only;
  switch (selection.kind) {
    case PairSelection::Kind::All:
      return scene.all(pairs);
    case PairSelection::Kind::Closest:
      return scene.closest(pairs, selection.count);
    case PairSelection::Kind::Below:
      near_only.threshold = selection.threshold;
      return scene.below(pairs, near_only);
    case PairSelection::Kind::Minimum:
      break;
  }
  const scene::PairProximity* minimum = scene.minimum(pairs);
  return minimum ? std::vector<scene::PairProximity>{*minimum} : std::vector<scene::PairProximity>{};
}

/// [m] The value by which Scene sorts its answers.
double placeOf(const narrowphase::SignedDistance& result) {
  return result.status == narrowphase::Status::Converged ? result.distance : result.lower_bound;
}

/// The smallest distance, from an answer that lists the smallest. A pair that is not listed is not closer in the order
/// of Scene, but its lower bound may be below that of the smallest by the tolerance.
SmallestDistance smallestOf(const std::vector<scene::PairProximity>& pairs, const scene::Scene& scene) {
  SmallestDistance smallest;
  smallest.unknown_pairs = scene.counts().unknown;
  double place = std::numeric_limits<double>::infinity();
  for (const scene::PairProximity& pair : pairs) {
    if (pair.result.status == narrowphase::Status::Unknown || !(placeOf(pair.result) < place)) continue;
    place = placeOf(pair.result);
    smallest.pair = pair;
    smallest.lower_bound = std::min(pair.result.lower_bound, place - scene::Question{}.tolerance);
  }
  return smallest;
}

/// Gives the scene the poses of a state, and its objects if they are others than those of before.
void placeIn(const NumberedState& state, AskedPairs& pairs, scene::Scene& scene) {
  const scene::BodyPoses poses = scene::forwardKinematics(scene.model().robot, state.positions);
  if (!state.objects) return scene.update(poses);
  if (scene.objects() != state.objects.get()) {
    scene.use(state.objects);
    pairs.use(*state.objects);
  }
  scene.update(poses, framePoses(*state.objects, poses));
}

StateClearance answerNumberedState(const NumberedState& state, const scene::Pairs& pairs, const StateQuestion& question,
                                   scene::Scene& scene) {
  StateClearance answer{
      state.number, answerState(pairs, question.selection, scene), {}, state.positions, state.objects};
  const bool is_listed = question.selection.kind != PairSelection::Kind::Below;
  if (is_listed) {
    answer.smallest = smallestOf(answer.pairs, scene);
  } else if (question.smallest == Smallest::Always) {
    answer.smallest = smallestOf(answerState(pairs, {}, scene), scene);
  }
  return answer;
}

std::vector<scene::ShapeRefPair> pairsWhere(const scene::SceneModel& model,
                                            const std::function<bool(scene::PairReason)>& isWanted) {
  std::vector<scene::ShapeRefPair> pairs;
  for (const scene::LinkPair& pair : model.pairs.pairs) {
    if (isWanted(pair.reason)) pairs.push_back({{pair.link_a, 0}, {pair.link_b, 0}});
  }
  return pairs;
}

bool isWanted(scene::PairReason reason) {
  return reason != scene::PairReason::SameBody && reason != scene::PairReason::NoGeometry &&
         reason != scene::PairReason::BothHalfSpaces;
}

/// All pairs with an object that have geometry and are not one body.
void addUnfilteredPairs(const scene::Objects& objects, std::vector<scene::ShapeRefPair>& pairs) {
  const int links = static_cast<int>(objects.model().robot.links.size());
  for (const int object : objects.numbers()) {
    const scene::ShapeRef ref = scene::ShapeRef::ofObject(object);
    for (int link = 0; link < links; ++link)
      if (isWanted(objects.linkReason(link, object))) pairs.push_back({{link, 0}, ref});
    for (const int other : objects.numbers())
      if (other > object && isWanted(objects.objectReason(object, other)))
        pairs.push_back({ref, scene::ShapeRef::ofObject(other)});
  }
}

/// The number after the prefix. Throws std::invalid_argument if there is no number, or other text after it.
template <typename Number>
Number numberAfter(const std::string& prefix, const std::string& text) {
  Number value{};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + prefix.size(), end, value);
  if (error != std::errc() || stop != end) throw std::invalid_argument(text + ": no number behind " + prefix);
  return value;
}

}  // namespace

PairSelection readPairSelection(const std::string& text) {
  PairSelection selection;
  if (text == "all") {
    selection.kind = PairSelection::Kind::All;
  } else if (text.compare(0, 6, "below:") == 0) {
    selection.kind = PairSelection::Kind::Below;
    selection.threshold = numberAfter<double>("below:", text);
    if (std::isnan(selection.threshold)) throw std::invalid_argument(text + ": not a number");
  } else if (text.compare(0, 2, "k:") == 0) {
    selection.kind = PairSelection::Kind::Closest;
    selection.count = numberAfter<int>("k:", text);
    if (selection.count < 1) throw std::invalid_argument(text + ": at least one pair");
  } else if (text != "minimum") {
    throw std::invalid_argument(text + ": none of all, minimum, below:METRES, k:COUNT");
  }
  return selection;
}

std::vector<scene::ShapeRefPair> filteredPairs(const scene::SceneModel& model) {
  return pairsWhere(model, [](scene::PairReason reason) { return reason == scene::PairReason::Checked; });
}

std::vector<scene::ShapeRefPair> unfilteredPairs(const scene::SceneModel& model) {
  return pairsWhere(model, [](scene::PairReason reason) { return reason != scene::PairReason::SameBody; });
}

void AskedPairs::use(const scene::Objects& objects) {
  if (question_.candidates) return;
  with_objects_ = question_.pairs;
  addUnfilteredPairs(objects, with_objects_);
}

void answerStates(const ClearanceQuestion& question, const StateQuestion& state_question, JointStates& states,
                  const std::function<void(const StateClearance&)>& handle) {
  const scene::Scene fresh(question.model, state_question.skipping);
  long count = 0;
  const auto next = [&](NumberedState& state) {
    if (!states.next(state.positions)) return false;
    state.number = count++;
    if (!question.objects) return true;
    question.objects->advance(state.number, states.time(), state.positions);
    state.objects = question.objects->now();
    return true;
  };
  const auto answerBlock = [&](const std::vector<NumberedState>& block) {
    scene::Scene scene = fresh.twin();
    AskedPairs pairs(question);
    std::vector<StateClearance> answers;
    for (const NumberedState& state : block) {
      placeIn(state, pairs, scene);
      answers.push_back(answerNumberedState(state, pairs.get(), state_question, scene));
    }
    return answers;
  };
  answerInBlocks<NumberedState, StateClearance>({kBlockSize, next, answerBlock, handle}, question.threads);
}

}  // namespace proximity_server::tools
