#include "tools/clearance/clearance_run.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "proximity_server/scene/query/scene.h"
#include "system/pipeline.h"
#include "tools/command_line/csv.h"

namespace proximity_server::tools {
namespace {

constexpr std::size_t kBlockSize = 256;  // states: so many that the cold start is a small part of the work

struct NumberedState {
  long number = 0;
  scene::Positions positions;
  std::shared_ptr<const scene::Objects> objects;
};

std::vector<scene::PairProximity> listOf(const scene::PairProximity* pair) {
  return pair ? std::vector<scene::PairProximity>{*pair} : std::vector<scene::PairProximity>{};
}

/// The pair that sets the level, or without thresholds the closest one.
std::vector<scene::PairProximity> answerMinimum(const scene::Pairs& pairs, const scene::LevelThresholds* thresholds,
                                                scene::Scene& scene) {
  std::vector<scene::PairProximity> closest = listOf(scene.minimum(pairs));
  if (!thresholds || closest.empty()) return closest;
  return {decidingPair(scene, pairs, closest.front(), *thresholds).pair};
}

std::vector<scene::PairProximity> answerState(const scene::Pairs& pairs, const PairSelection& selection,
                                              const scene::LevelThresholds* thresholds, scene::Scene& scene) {
  scene::Question near_only;
  switch (selection.kind) {
    case PairSelection::Kind::All:
      return scene.all(pairs);
    case PairSelection::Kind::Closest:
      return scene.closest(pairs, selection.count);
    case PairSelection::Kind::Below:
      near_only.threshold = selection.threshold;
      return scene.below(pairs, near_only);
    case PairSelection::Kind::Any:
      near_only.threshold = selection.threshold;
      return listOf(scene.first(pairs, near_only));
    case PairSelection::Kind::Minimum:
      break;
  }
  return answerMinimum(pairs, thresholds, scene);
}

/// [m] The value by which Scene sorts its answers.
double placeOf(const narrowphase::SignedDistance& result) {
  return result.status == narrowphase::Status::Converged ? result.distance : result.lower_bound;
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

/// Whether unknown pairs leave open what is to be listed.
bool isList(const PairSelection& selection) {
  return selection.kind != PairSelection::Kind::All && selection.kind != PairSelection::Kind::Any;
}

StateClearance answerNumberedState(const NumberedState& state, const scene::Pairs& pairs, const ClearanceQuestion& all,
                                   const StateQuestion& question, scene::Scene& scene) {
  const scene::LevelThresholds* const thresholds = all.thresholds ? &*all.thresholds : nullptr;
  StateClearance answer{
      state.number, answerState(pairs, question.selection, thresholds, scene), {}, state.positions, state.objects};
  const int unknown_pairs = scene.counts().unknown;
  answer.smallest.unknown_pairs = unknown_pairs;
  if (listsSmallest(question.selection, all)) {
    answer.smallest = smallestOf(answer.pairs, unknown_pairs);
  } else if (question.smallest == Smallest::Always) {
    const std::vector<scene::PairProximity> minimum = answerMinimum(pairs, nullptr, scene);
    answer.smallest = smallestOf(minimum, scene.counts().unknown);
  }
  if (unknown_pairs > 0 && isList(question.selection)) answer.pairs = {scene::PairProximity{}};
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
      if (isWanted(objects.reason(link, ref))) pairs.push_back({link, ref});
    for (const int other : objects.numbers())
      if (const auto second = scene::ShapeRef::ofObject(other); other > object && isWanted(objects.reason(ref, second)))
        pairs.push_back({ref, second});
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

double thresholdAfter(const std::string& prefix, const std::string& text) {
  const auto threshold = numberAfter<double>(prefix, text);
  if (std::isnan(threshold)) throw std::invalid_argument(text + ": not a number");
  return threshold;
}

}  // namespace

// A pair that is not listed is not closer in the order of Scene, but its lower bound may be below that of the smallest by
// the tolerance.
SmallestDistance smallestOf(const std::vector<scene::PairProximity>& pairs, int unknown_pairs) {
  SmallestDistance smallest;
  smallest.unknown_pairs = unknown_pairs;
  double place = std::numeric_limits<double>::infinity();
  for (const scene::PairProximity& pair : pairs) {
    if (pair.result.status == narrowphase::Status::Unknown || !(placeOf(pair.result) < place)) continue;
    place = placeOf(pair.result);
    smallest.pair = pair;
    smallest.lower_bound = std::min(pair.result.lower_bound, place - scene::Question{}.tolerance);
  }
  return smallest;
}

bool listsSmallest(const PairSelection& selection, const ClearanceQuestion& question) {
  return selection.kind == PairSelection::Kind::All || selection.kind == PairSelection::Kind::Closest ||
         (selection.kind == PairSelection::Kind::Minimum && !question.thresholds);
}

PairSelection readPairSelection(const std::string& text) {
  PairSelection selection;
  if (text == "all") {
    selection.kind = PairSelection::Kind::All;
  } else if (text.compare(0, 6, "below:") == 0) {
    selection.kind = PairSelection::Kind::Below;
    selection.threshold = thresholdAfter("below:", text);
  } else if (text.compare(0, 4, "any:") == 0) {
    selection.kind = PairSelection::Kind::Any;
    selection.threshold = thresholdAfter("any:", text);
  } else if (text.compare(0, 2, "k:") == 0) {
    selection.kind = PairSelection::Kind::Closest;
    selection.count = numberAfter<int>("k:", text);
    if (selection.count < 1) throw std::invalid_argument(text + ": at least one pair");
  } else if (text != "minimum") {
    throw std::invalid_argument(text + ": none of all, minimum, below:METRES, any:METRES, k:COUNT");
  }
  return selection;
}

std::string textOf(const PairSelection& selection) {
  switch (selection.kind) {
    case PairSelection::Kind::All:
      return "all";
    case PairSelection::Kind::Below:
      return "below:" + numberText(selection.threshold);
    case PairSelection::Kind::Any:
      return "any:" + numberText(selection.threshold);
    case PairSelection::Kind::Closest:
      return "k:" + std::to_string(selection.count);
    case PairSelection::Kind::Minimum:
      break;
  }
  return "minimum";
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

void answerStates(const ClearanceQuestion& question, const StateQuestion& state_question, StateSource& states,
                  const StateRange& range, const std::function<void(const StateClearance&)>& handle) {
  const scene::Scene fresh(question.model, state_question.skipping);
  const std::uint64_t begin_of_block = range.begin / kBlockSize * kBlockSize;
  std::uint64_t count = question.objects ? 0 : begin_of_block;  // objects change on the way there
  if (count > 0) states.skipTo(count);
  const auto read = [&](NumberedState& state) {
    if (count == range.end) return false;
    if (!states.next(state.positions)) {
      if (range.end != kToTheEnd) refuseEnd(states, count, range);
      return false;
    }
    state.number = static_cast<long>(count++);
    if (!question.objects) return true;
    question.objects->advance(state.number, states.time(), state.positions);
    state.objects = question.objects->now();
    return true;
  };
  const auto next = [&](NumberedState& state) {
    while (count < begin_of_block)
      if (!read(state)) return false;
    return read(state);
  };
  const auto answerBlock = [&](const std::vector<NumberedState>& block) {
    scene::Scene scene = fresh.twin();
    AskedPairs pairs(question);
    std::vector<StateClearance> answers;
    for (const NumberedState& state : block) {
      placeIn(state, pairs, scene);
      answers.push_back(answerNumberedState(state, pairs.get(), question, state_question, scene));
    }
    return answers;
  };
  const auto handleInRange = [&](const StateClearance& answer) {
    if (static_cast<std::uint64_t>(answer.state) >= range.begin) handle(answer);
  };
  system::answerInBlocks<NumberedState, StateClearance>({kBlockSize, next, answerBlock, handleInRange},
                                                        question.threads);
}

void refuseEnd(const StateSource& states, std::uint64_t count, const StateRange& range) {
  throw std::invalid_argument(states.source() + ": ends after " + std::to_string(count) + " states, before those of " +
                              textOf(range));
}

}  // namespace proximity_server::tools
