#pragma once

#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/proof/joint_box.h"
#include "proximity_server/scene/query/deadline.h"
#include "proximity_server/scene/scene_model/shape_ref.h"

#include <functional>
#include <limits>
#include <memory>
#include <vector>

namespace proximity_server::scene {

enum class ProofOutcome : unsigned char {
  Proven,    ///< the two are farther apart than the contact distance in all states of the box
  Refuted,   ///< a state of the box is known in which they are not
  Undecided  ///< neither was found before the budget was spent
};
const char* toString(ProofOutcome outcome);

/// [m] Two shapes usually count as in contact up to this distance: faces that are flush in the URDF are apart or overlap
/// by the rounding of its numbers (single precision in most meshes), which says nothing about the robot.
inline constexpr double kContactDistance = 1e-6;

/// The answer about one pair and a box of joint positions.
struct PairProof {
  ShapeRefPair pair;
  JointBox box;  ///< the joints that move the two relative to each other, without mimic joints
  ProofOutcome outcome = ProofOutcome::Undecided;
  /// [m] A lower bound of the signed distance in all states of the box, whatever the outcome is.
  double lower_bound = -std::numeric_limits<double>::infinity();
  /// The state of the box, one position for each of RobotModel::joints, in which the narrowphase found the smallest
  /// upper bound of the distance [m]. If the pair is refuted, that is at most the contact distance. An overlap may be
  /// deeper, unless shares were asked for.
  Positions closest;
  double closest_upper_bound = std::numeric_limits<double>::infinity();
  /// Shares of the volume of the box of the joints between the two: not decided; proven in contact everywhere, which is
  /// looked for only if shares are asked for.
  double undecided = 1.0, in_contact = 0.0;
  JointBox worst;  ///< of the undecided boxes the one with the smallest lower bound; empty if there is none
  long boxes = 0;  ///< that were examined
};

/// The question about each pair, and the budget of its search.
struct ProofQuestion {
  /// [m] At least 0. A pair is in contact up to this signed distance; paddings of pairs are subtracted before.
  double contact_distance = 0.0;
  long most_boxes = 10000;  ///< of each pair; the result does not depend on time and threads unless the deadline comes
  Deadline deadline{};
  /// In [0, 1): a bound is improved, within the budget, until it has come this share of the way from the contact
  /// distance to the smallest distance that was found.
  double tightness = 0.0;
  /// With Shares a pair is divided further after a state in contact was found, the largest boxes first.
  enum class Goal : unsigned char { Decision, Shares };
  Goal goal = Goal::Decision;
  std::shared_ptr<const Objects> objects;  ///< nullptr: none. Their frames are links of the robot, see LinkFrames
  int threads = 1;
  /// Called with the share of the volume of all pairs that is settled, from 0 to 1, in one thread at a time.
  std::function<void(double)> progress;
};

}  // namespace proximity_server::scene
