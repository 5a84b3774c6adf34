#pragma once

#include "proximity_server/scene/model/states.h"
#include "tools/clearance/clearance_question.h"

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace proximity_server::tools {

/// States that lie side by side.
struct StateBlock {
  std::uint64_t first = 0;  ///< the number of the first
  int size = 0;
  Eigen::MatrixXd positions;                                   ///< a row for each state
  std::vector<std::shared_ptr<const scene::Objects>> objects;  ///< in each state; empty: there are none
  std::vector<double> times;                                   ///< [s] of each state; NaN if it has none

  scene::Positions positionsOf(int i) const;
  std::shared_ptr<const scene::Objects> objectsOf(int i) const { return objects.empty() ? nullptr : objects[i]; }
};

/// The closest pair of a state.
struct ClosestPair {
  /// Without links if no pair has an answer. Its lower bound holds for all pairs that have one, with an uncertainty in
  /// all states that it allows.
  scene::PairProximity pair;
  int unknown_pairs = 0;  ///< pairs without an answer, as a pose is not finite
};

/// The pairs that are listed of a state.
struct StateAnswer {
  const scene::PairProximity* begin;
  const scene::PairProximity* end;
  int unknown = 0;                       ///< pairs without an answer
  const double* guaranteed = nullptr;    ///< [m] of each pair, if there is an uncertainty
  const ClosestPair* closest = nullptr;  ///< nullptr: it is not asked for
};

/// Answers a question about the states of a block. Not thread-safe; each thread has one of its own.
class StateAnswers {
 public:
  virtual ~StateAnswers() = default;
  StateAnswers(const StateAnswers&) = delete;
  StateAnswers& operator=(const StateAnswers&) = delete;

  /// Calls `take` with the place in the block and the answer of each state, in their order. The data that the answer
  /// points to are valid during the call.
  using Take = std::function<void(int, const StateAnswer&)>;
  virtual void answer(const StateBlock& block, const Take& take) = 0;

 protected:
  StateAnswers() = default;
};

/// Whether StateAnswer::closest is wanted.
enum class WantsClosest : unsigned char { No, Yes };

/// Whether SceneBatch answers the question: then the answer about a state depends on it alone, and on the objects that are
/// there. All pairs, those that the filter leaves out, an uncertainty and a question without skipping are answered by
/// Scene, each state with warm starts of the states of its block before it.
bool isForBatch(const ClearanceQuestion& question);

/// The answers for each of the threads of the question, which must outlive them.
std::vector<std::unique_ptr<StateAnswers>> answersOfThreads(const ClearanceQuestion& question, WantsClosest wants);

}  // namespace proximity_server::tools
