#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/query/question.h"
#include "tools/command_line/joint_states.h"

namespace proximity_server::tools {

/// Which pairs of a state are written.
struct PairSelection {
  enum class Kind : unsigned char { All, Minimum, Below, Closest };
  Kind kind = Kind::Minimum;
  double threshold = std::numeric_limits<double>::infinity();  ///< [m] of Below
  int count = 1;                                               ///< of Closest
};

/// Reads "all", "minimum", "below:0.05" or "k:5". Throws std::invalid_argument naming the text.
PairSelection readPairSelection(const std::string& text);

/// The candidates of the filter, or every pair of links with geometry that is not one body.
std::vector<scene::ShapeRefPair> filteredPairs(const scene::SceneModel& model);
std::vector<scene::ShapeRefPair> unfilteredPairs(const scene::SceneModel& model);

/// What is asked about, for states and trajectories alike.
struct ClearanceQuestion {
  std::shared_ptr<const scene::SceneModel> model;
  std::vector<scene::ShapeRefPair> pairs;
  int threads = 1;
};

/// Whether StateClearance::smallest is found also where the selection may not list it.
enum class Smallest : unsigned char { IfListed, Always };

struct StateQuestion {
  PairSelection selection;
  scene::Skipping skipping = scene::Skipping::On;
  Smallest smallest = Smallest::IfListed;
};

/// The smallest signed distance of a state.
struct SmallestDistance {
  scene::PairProximity pair;                                      ///< the closest; no links where nothing is known
  double lower_bound = -std::numeric_limits<double>::infinity();  ///< [m] of all pairs of which something is known
  int unknown_pairs = 0;                                          ///< of which nothing is, as a pose is not finite
};

/// What was found in one state.
struct StateClearance {
  long state;  ///< counted from 0
  std::vector<scene::PairProximity> pairs;
  SmallestDistance smallest;
  scene::Positions positions;
};

/// Answers the question for every state, in their order, and hands each answer to `take` in the calling thread. The
/// answers are the same, bit by bit, for any number of threads.
/// Failure: what reading threw, after the answers to all states before it were taken.
void answerStates(const ClearanceQuestion& question, const StateQuestion& state_question, JointStates& states,
                  const std::function<void(const StateClearance&)>& take);

}  // namespace proximity_server::tools
