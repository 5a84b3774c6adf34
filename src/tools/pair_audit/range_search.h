#pragma once

#include "proximity_server/scene/proof/joint_box.h"
#include "tools/pair_audit/pair_study.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// A pair of links, and the ranges of one joint in which it is proven apart, whatever the other joints do within limits.
struct PairRanges {
  scene::ShapeRefPair pair;
  double distance;                      ///< [m] a lower bound of the distance in all the ranges
  std::vector<scene::JointBox> ranges;  ///< without an interval: all states
};

/// For searches of ranges in which pairs are proven apart.
struct RangeOptions {
  double distance = 0.0;   ///< [m] how far apart the pairs are in their ranges
  long most_boxes = 2000;  ///< of each proof
  unsigned long seed = 1;  ///< of random states
  TimeBudget budget;
  int threads = 1;
  std::function<void(double done)> progress;  ///< from 0 to 1, in the thread of the caller

  /// About one pair, in one thread.
  scene::ProofQuestion question() const {
    scene::ProofQuestion question;
    question.contact_distance = distance + kContactDistance;  // a bound must exceed a threshold
    question.most_boxes = most_boxes;
    question.deadline = budget.deadline;
    return question;
  }
};

/// Finds ranges of one joint in which a pair is proven apart, whatever the other joints do within their limits.
///
/// 1. If that is proven within all limits, it is the only range.
/// 2. Otherwise a range of each joint is searched from its lower limit, from its upper one, and from its position in the
///    state in which the study saw the pair farthest apart. Its ends move outwards as long as the proof succeeds.
/// 3. Ranges of one joint that overlap become one. Those of less than kLeastShare of a joint's limits are left out.
///
/// `limits` has an interval for each joint between the two.
/// Failure: throws as TimeBudget::require().
PairRanges provenRanges(const std::shared_ptr<const scene::SceneModel>& model, const PairEvidence& evidence,
                        const scene::JointBox& limits, const RangeOptions& options);

/// provenRanges() of the checked pairs that have any, within the limits of the URDF. Pairs with a joint whose limits are
/// not known are left out. The result is the same for any number of threads.
std::vector<PairRanges> provenRanges(const std::shared_ptr<const scene::SceneModel>& model, const PairStudy& study,
                                     const RangeOptions& options);

constexpr double kLeastShare = 0.05;

/// The ranges of each pair, for people.
std::string rangesText(const scene::RobotModel& robot, const std::vector<PairRanges>& pairs);

}  // namespace proximity_server::tools
