#pragma once

#include "proximity_server/scene/proof/joint_box.h"
#include "tools/pair_audit/pair_study.h"
#include "tools/pair_audit/range_search.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// Limits of the joints within which pairs of links are proven apart.
struct SafeLimits {
  struct Uncovered {
    scene::ShapeRefPair pair;
    std::string reason;
  };
  scene::JointBox limits;                    ///< the limits of the URDF, as far as they are known
  std::optional<scene::JointBox> box;        ///< nullopt: none was proven
  std::vector<scene::ShapeRefPair> covered;  ///< proven apart in the box
  std::vector<Uncovered> uncovered;          ///< the box says nothing about them
};

/// Finds limits, tightened as little as the search finds, within which the robot does not collide with itself, nor comes
/// within a distance of itself; neighbours, which are near by design, are just not in contact. The study must have measured distances up to this one.
///
/// 1. Pairs are covered that are checked, and, whatever the SRDF says of them, neighbours and pairs that the study has
///    proven. Pairs that are always within the distance or whose limits are not known are not.
/// 2. Neighbours move by one joint. If they may collide, it gets the interval about the state in which they were seen
///    farthest apart. If less than kLeastShare of it is left, they are not covered.
/// 3. A pair that is apart in a range of one joint (provenRanges()) with at least 30 % of its width gets this range.
/// 4. Random states within these limits are sorted by their smallest distance. About the best few, a box grows with the
///    widths of the limits until a pair is not proven apart any more; then each end by itself. The largest box is taken.
/// 5. The box is proven as a whole, for all covered pairs. Nothing else is returned.
///
/// Error:   the box is proven; a larger one may exist.
/// Failure: throws as TimeBudget::require().
SafeLimits safeLimits(const std::shared_ptr<const scene::SceneModel>& model, const PairStudy& study,
                      const RangeOptions& options);

/// The limits beside the limits of the URDF, for people.
std::string safeLimitsText(const scene::RobotModel& robot, const SafeLimits& safe);

/// The limits as YAML that jointBoxFrom() takes, as `prove --box` does. Throws std::invalid_argument if there is no box.
std::string safeLimitsYaml(const scene::RobotModel& robot, const SafeLimits& safe);

}  // namespace proximity_server::tools
