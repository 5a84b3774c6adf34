#pragma once

#include "peers/scene_library.h"
#include "proximity_server/scene/model/kinematics.h"

#include <nlohmann/json.hpp>

#include <vector>

namespace proximity_server::benchmark {

using namespace scene;
using namespace peers;

constexpr double kAgreement = 1e-6;  ///< [m] two answers that are as near are the same

/// How far the answers of another library lie from ours, and which of the two is right where they differ.
///
/// Only distances are compared: a pair counts where both say that it is apart. The first pairs that differ are put to
/// the oracle of the tests, which shares nothing with either.
class Agreement {
 public:
  Agreement(const SceneModel& model, SceneQuestion question) : model_(model), question_(question) {}

  /// Two answers to the question in one state.
  void compare(const BodyPoses& poses, const std::vector<PairDistance>& ours, const std::vector<PairDistance>& others);

  /// compared: pairs; max_error, p99_error: of the differences [m]; differing: above 1e-6 m; judged: of those by the
  /// oracle, with ours_right and other_right; overlaps_missed: ours overlaps, the other does not; overlaps_claimed: the
  /// other way round; unanswered: pairs without an answer of the other.
  nlohmann::json summary() const;

 private:
  void compareMinimum(const BodyPoses& poses, const PairDistance& ours, const PairDistance& other);
  void compareDistances(const BodyPoses& poses, const std::vector<int>& pairs, double ours, double other);
  void judge(const BodyPoses& poses, const std::vector<int>& pairs, double ours, double other);

  const SceneModel& model_;
  SceneQuestion question_;
  std::vector<double> differences_;
  int differing_ = 0, judged_ = 0, ours_right_ = 0, other_right_ = 0;
  int overlaps_missed_ = 0, overlaps_claimed_ = 0, unanswered_ = 0;
};

/// How far the answers of another library about a sweep lie from ours, state by state; ours are proven.
///
/// states: that were compared. For AnyBelow: below_missed counts the states in which ours is below and the other is
/// not, below_claimed the other way round. For the others, over pairs by rank that both say are apart: compared;
/// differing: by more than 1e-6 m; too_near and too_far: the largest errors [m] in either direction; and
/// overlaps_missed and overlaps_claimed. For Below also other_pairs: states with another number of pairs.
nlohmann::json sweepAgreement(SceneQuestion question, const std::vector<SceneAnswer>& ours,
                              const std::vector<SceneAnswer>& others);

}  // namespace proximity_server::benchmark
