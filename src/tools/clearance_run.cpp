#include "clearance_run.h"

#include <charconv>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <utility>

#include "answers_in_order.h"

namespace proximity_server {
namespace {

constexpr std::size_t kBlockSize = 256;  // states: a cold start is then a small part of the work

using Positions = std::vector<double>;
struct Block {
  long first_state = 0;
  std::vector<Positions> states;
};
using BlockAnswer = std::vector<StateClearance>;

std::vector<PairProximity> answerState(const ClearanceQuestion& question, Scene& scene) {
  Question near_only;
  switch (question.selection.kind) {
    case PairSelection::Kind::All:
      return scene.all(question.pairs);
    case PairSelection::Kind::Closest:
      return scene.closest(question.pairs, question.selection.count);
    case PairSelection::Kind::Below:
      near_only.threshold = question.selection.threshold;
      return scene.below(question.pairs, near_only);
    case PairSelection::Kind::Minimum:
      break;
  }
  const PairProximity* minimum = scene.minimum(question.pairs);
  return minimum ? std::vector<PairProximity>{*minimum} : std::vector<PairProximity>{};
}

BlockAnswer answerBlock(const ClearanceQuestion& question, const Block& block, Scene scene) {
  BlockAnswer answer;
  for (const Positions& positions : block.states) {
    scene.update(forwardKinematics(question.model->robot, positions));
    answer.push_back({block.first_state + static_cast<long>(answer.size()), answerState(question, scene)});
  }
  return answer;
}

/// Reads blocks; an error of reading ends the states, and is kept for later.
class BlockReader {
 public:
  explicit BlockReader(JointStates& states) : states_(states) {}

  Block next() {
    Block block;
    block.first_state = state_;
    try {
      for (Positions positions; block.states.size() < kBlockSize && !error_ && states_.next(positions);) {
        block.states.push_back(positions);
      }
    } catch (const std::invalid_argument&) {
      error_ = std::current_exception();
    }
    state_ += static_cast<long>(block.states.size());
    return block;
  }

  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  JointStates& states_;
  long state_ = 0;
  std::exception_ptr error_;
};

std::vector<SubjectPair> pairsWhere(const SceneModel& model, const std::function<bool(PairReason)>& isWanted) {
  std::vector<SubjectPair> pairs;
  for (const LinkPair& pair : model.pairs.pairs) {
    if (isWanted(pair.reason)) pairs.push_back({{pair.link_a, 0}, {pair.link_b, 0}});
  }
  return pairs;
}

/// The number behind the colon. Throws std::invalid_argument where there is none, or something behind it.
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

std::vector<SubjectPair> filteredPairs(const SceneModel& model) {
  return pairsWhere(model, [](PairReason reason) { return reason == PairReason::Checked; });
}

std::vector<SubjectPair> unfilteredPairs(const SceneModel& model) {
  return pairsWhere(model, [](PairReason reason) { return reason != PairReason::SameBody; });
}

void answerStates(const ClearanceQuestion& question, JointStates& states,
                  const std::function<void(const StateClearance&)>& take) {
  // Each block starts with a scene that remembers nothing, so that the answers are the same for any number of threads.
  const Scene fresh(question.model, question.skipping);
  BlockReader reader(states);
  AnswersInOrder<BlockAnswer> answers(question.threads, [&](const BlockAnswer& answer) {
    for (const StateClearance& state : answer) take(state);
  });
  for (Block block = reader.next(); !block.states.empty(); block = reader.next()) {
    answers.start([&question, &fresh, work = std::move(block)] { return answerBlock(question, work, fresh.twin()); });
  }
  answers.finish();
  reader.rethrow();
}

}  // namespace proximity_server
