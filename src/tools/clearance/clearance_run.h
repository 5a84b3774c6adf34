#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/query/pairs.h"
#include "proximity_server/scene/query/question.h"
#include "tools/clearance/object_schedule.h"
#include "tools/states/state_source.h"
#include "tools/sweep/state_range.h"

namespace proximity_server::tools {

/// Whether a list has a pair there: the answer about a state without one names none.
inline bool isNamed(const scene::ShapeRefPair& pair) { return pair.a != scene::ShapeRef(); }

/// The pairs of a state that are written.
struct PairSelection {
  enum class Kind : unsigned char { All, Minimum, Below, Closest, Any };
  Kind kind = Kind::Minimum;
  double threshold = std::numeric_limits<double>::infinity();  ///< [m] for Below and Any
  int count = 1;                                               ///< for Closest
};

/// Reads "all", "minimum", "below:0.05", "any:0.05" or "k:5". Throws std::invalid_argument naming the text.
PairSelection readPairSelection(const std::string& text);

/// The text that is read as the selection, one for each.
std::string textOf(const PairSelection& selection);

/// The candidates of the filter; and all pairs of links that have geometry and do not belong to one body.
std::vector<scene::ShapeRefPair> filteredPairs(const scene::SceneModel& model);
std::vector<scene::ShapeRefPair> unfilteredPairs(const scene::SceneModel& model);

/// Whether neighbours and disabled pairs are left out.
enum class PairFilter : unsigned char { On, Off };

/// The part of the question that states and trajectories share.
struct ClearanceQuestion {
  std::shared_ptr<const scene::SceneModel> model;
  PairFilter filter = PairFilter::On;
  std::vector<scene::ShapeRefPair> pairs;   ///< of links, as the filter says
  std::shared_ptr<ObjectSchedule> objects;  ///< nullptr: there are none
  std::optional<scene::Candidates>
      candidates;  ///< of the filter, if there are objects; nullopt: all pairs that have geometry
  int threads = 1;
  std::optional<scene::LevelThresholds> thresholds;  ///< nullopt: there are no levels. Not for trajectories
};

/// Whether the closest pair of a state is among the selected ones. With thresholds the minimum is the pair that sets the level.
bool listsSmallest(const PairSelection& selection, const ClearanceQuestion& question);

/// The pairs of a question, those with objects too.
class AskedPairs {
 public:
  /// The question must outlive this.
  explicit AskedPairs(const ClearanceQuestion& question) : question_(question) {}

  /// Takes the next objects.
  void use(const scene::Objects& objects);

  scene::Pairs get() const {
    if (question_.candidates) return *question_.candidates;
    return question_.objects ? with_objects_ : question_.pairs;
  }

 private:
  const ClearanceQuestion& question_;
  std::vector<scene::ShapeRefPair> with_objects_;  ///< without filter
};

/// Whether StateClearance::smallest is also computed if the selection may not list that pair.
enum class Smallest : unsigned char { IfListed, Always };

struct StateQuestion {
  PairSelection selection;
  scene::Skipping skipping = scene::Skipping::On;
  Smallest smallest = Smallest::IfListed;
};

/// The smallest signed distance of a state.
struct SmallestDistance {
  scene::PairProximity pair;                                      ///< without links if no pair has an answer
  double lower_bound = -std::numeric_limits<double>::infinity();  ///< [m] of all pairs that have an answer
  int unknown_pairs = 0;                                          ///< pairs without one, as a pose is not finite
};

/// The answer about one state.
struct StateClearance {
  long state = 0;  ///< counted from 0
  /// The selected ones; of Any one that is below, if there is one. Where unknown pairs leave open which ones are selected (all but All
  /// and Any), one pair without links: the state has no answer.
  std::vector<scene::PairProximity> pairs;
  SmallestDistance smallest;
  scene::Positions positions;
  std::shared_ptr<const scene::Objects> objects = nullptr;  ///< in this state; nullptr: there are none
};

/// The smallest distance, from an answer that lists the smallest and all that is closer.
SmallestDistance smallestOf(const std::vector<scene::PairProximity>& pairs, int unknown_pairs);

/// Answers the question about the states of a range, in their order, and passes each answer to `handle` in the calling
/// thread. `states` must not have been read from. An end of kToTheEnd is that of the states.
///
/// Each state is answered with warm starts of up to kBlockSize - 1 states before it, in blocks of all states: so the
/// answers have the same bits for any number of threads, and for any range.
/// Failure: throws the error of reading a state, after the answers about all states before it were handled; and
///          std::invalid_argument if the range has an end that the states do not reach.
void answerStates(const ClearanceQuestion& question, const StateQuestion& state_question, StateSource& states,
                  const StateRange& range, const std::function<void(const StateClearance&)>& handle);

/// Throws std::invalid_argument that the source ends before the range does.
[[noreturn]] void refuseEnd(const StateSource& states, std::uint64_t count, const StateRange& range);

}  // namespace proximity_server::tools
