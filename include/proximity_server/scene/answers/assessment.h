#pragma once

#include "proximity_server/scene/answers/deciding_pair.h"
#include "proximity_server/scene/answers/lookahead.h"
#include "proximity_server/scene/guaranteed/guaranteed_distances.h"
#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/model/joint_inequality.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/state/state.h"

#include <limits>
#include <optional>
#include <vector>

namespace proximity_server::scene {

/// The guaranteed distance, the level and the gradient of a pair.
struct PairFacts {
  /// [m] A lower bound of the signed distance in all states that may be the true one: the bound of the answer if the
  /// state is known exactly. NaN if there is none.
  double guaranteed = std::numeric_limits<double>::quiet_NaN();
  ClearanceLevel level = ClearanceLevel::Clear;  ///< by `guaranteed` and the pair's own thresholds, without hysteresis
  std::vector<double> gradient;                  ///< see gradient(); empty if it is not asked for or not known
};

/// The answer of the scene about a pair, with its facts.
struct AssessedPair : PairFacts {
  PairProximity pair;  ///< Status::Unknown if there is none
};

/// An inequality of the robot that is broken, and by how much its sum is above its bound.
struct BrokenInequality {
  const JointInequality* inequality;
  double excess;
};

/// The thresholds, limits and assumptions of an Assessment. It is about the checked pairs of the robot.
struct AssessmentQuestion {
  const LevelThresholds& thresholds;
  const std::vector<std::optional<double>>& stated;  ///< positions of RobotModel::joints, see excessAt()
  Question question{};                               ///< pairs at or below its threshold are listed
  int most_listed = 1;                               ///< facts are found for this many of the closest
  double hysteresis = 0.0;                           ///< [m] see LevelBefore
  GuaranteedDistances* guaranteed = nullptr;         ///< nullptr: the state is known exactly
  bool is_bounded = true;        ///< false: nothing bounds where the true state is; nothing is guaranteed, and no level
  bool wants_gradients = false;  ///< of all pairs
  Lookahead* lookahead = nullptr;  ///< nullptr: none; it has its own question, about this state
};

/// All that is known about a state of a robot with its objects: numbers and references, no names.
struct Assessment {
  /// The closest pair of a kind, and the level of all pairs of this kind. The next assessment keeps the level within
  /// its hysteresis.
  struct OfKind {
    AssessedPair closest;
    std::optional<ClearanceLevel> level;  ///< nullopt: not known
  };

  PairCounts counts;                   ///< of the search for the closest pair
  int below = 0;                       ///< the number of pairs at or below the threshold
  std::vector<PairProximity> listed;   ///< the closest of them, sorted by distance
  std::vector<PairFacts> of_listed;    ///< of the first of `listed`; further ones keep memory
  AssessedPair minimum;                ///< the closest pair
  OfKind of_links, with_object;        ///< of pairs of two links, and of pairs with an object
  std::optional<DistanceLevel> level;  ///< of all pairs, with the threshold of `deciding`; nullopt: not known
  AssessedPair deciding;  ///< the pair that sets `level`; its gradient is asked for, too, unless the level is Clear
  bool reached = false;   ///< a state that may be the true one is certainly at Warn or Stop
  std::optional<BrokenInequality> broken{};  ///< the one with the largest excess divided by its tolerance
  const ContactAhead* ahead = nullptr;       ///< in AssessmentQuestion::lookahead; nullptr: no lookahead, or no level
};

/// Assesses a state. There is no level if a checked pair is Unknown, see Assessment::counts, if no pair is checked, or
/// if the question is not bounded. With the same `assessment` nothing is allocated after the first few states, unless
/// `most_listed` grows; see Lookahead for its part.
void assess(Scene& scene, const State& state, const AssessmentQuestion& asked, Assessment& assessment);

}  // namespace proximity_server::scene
