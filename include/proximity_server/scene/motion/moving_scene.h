#pragma once

#include <chrono>
#include <memory>
#include <vector>

#include "proximity_server/scene/motion/limited_motion.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::scene {

/// A contact distance [m] that one pair has for itself.
struct PairContactDistance {
  ShapeRefPair pair;
  double contact_distance;
};

struct MotionQuestion {
  /// [m] Contact is a signed distance, less the pair's padding, at or below it. Below 0, a first contact of two of which
  /// one has a closed mesh with room inside is left open (IterationLimit, t_free 0) unless it is at the start.
  double contact_distance = 0.0;
  /// Each pair adds its own distance to `contact_distance`; nullptr adds nothing. It has to live until the question is answered.
  const PairDistances* thresholds = nullptr;
  /// Pairs that may come nearer than all others, as those that are nearer at the start and shall be allowed to part. Of two
  /// contact distances of a pair the smaller one counts; with minus infinity the pair is left out. If one of them is below 0
  /// and its pair has a closed mesh with room inside, a first contact is left open from the start on.
  std::vector<PairContactDistance> nearer_pairs{};
  double tolerance = 1e-6;  ///< [m] of that distance, and of the minimum; NaN counts as 0
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
};

/// How the pairs of a question were settled.
struct MotionCounts {
  int pairs = 0;    ///< of links and objects
  int unknown = 0;  ///< of these, pairs without an answer because a pose or all geometry is missing
  int by_one_bound =
      0;  ///< of these, pairs that one bound settled for the whole motion, or bounds of many objects at once
  int intervals = 0;  ///< pairs of volumes, or of a volume and many objects, and intervals of time that were examined
  int queries = 0;    ///< of the narrowphase, at one time
};

/// When a robot comes too close to itself, or to an object, for the first time.
struct RobotContact {
  /// Converged: complete. IterationLimit (the deadline has passed, or the iterations were used up) and Degenerate:
  /// t_free still holds. Unknown: nothing is known of any pair, or of one whose motion overflows.
  narrowphase::Status status = narrowphase::Status::Unknown;
  bool contact = false;
  /// Until this time every pair is proven to be above its contact distance.
  double t_free = 0.0;
  /// See TimeOfContact.
  double t_contact = std::numeric_limits<double>::quiet_NaN();
  /// The pair in contact at t_contact, in the frame of the poses. Degenerate: rounding makes its bounds wider than the tolerance.
  PairProximity pair;
  MotionCounts counts;
};

/// How close a robot comes to itself and to objects.
struct RobotMinimum {
  narrowphase::Status status = narrowphase::Status::Unknown;      ///< as in RobotContact; the bounds always hold
  double lower_bound = -std::numeric_limits<double>::infinity();  ///< [m] of the smallest signed distance of all
  double upper_bound = std::numeric_limits<double>::infinity();   ///< [m] the distance of `pair` at `time`
  double time = std::numeric_limits<double>::quiet_NaN();
  PairProximity pair;  ///< the closest pair, at `time`, in the frame of the poses; Degenerate as in RobotContact
  MotionCounts counts;
};

class MotionSearch;

/// One robot with its objects in motion: the scratch of one caller. Not thread-safe.
///
/// Pairs of volumes (links and objects, then parts of them, then convex pieces) and intervals of time are searched best-first: the
/// earliest for a contact, the closest for the minimum. A pair that one bound settles for the whole motion is never
/// divided, and pieces go to the narrowphase for the intervals that are left. A question allocates memory for the poses
/// and kinematic chains of its motion.
///
/// Objects: an attached object moves with the body of its link, a fixed one stands in the world, a moving one goes with its
///          frame, and both are where RobotMotion::ObjectFrames says. Of many fixed objects, those that are far from a link
///          during the whole motion are skipped by bounds of their hierarchy, and so are the parts of one object; moving and
///          attached objects are examined one by one.
/// Limit:   the smallest distance of a motion on which something is inside a closed mesh, away from its surface, may be less
///          exact than asked: IterationLimit.
/// Failure: every question throws std::invalid_argument for a link, <collision> or object that does not exist, for two
///          objects with half-spaces, and for a motion of another number of bodies or frames.
class MovingScene {
 public:
  /// Throws std::invalid_argument without a model.
  explicit MovingScene(std::shared_ptr<const SceneModel> model);
  ~MovingScene();
  MovingScene(MovingScene&&) noexcept;
  MovingScene& operator=(MovingScene&&) noexcept;

  /// Returns another moving scene of the same model and objects. The two share what never changes.
  MovingScene twin() const;

  const SceneModel& model() const;

  /// Takes the next objects of the robot.
  /// Failure: throws std::invalid_argument for the objects of another model.
  void use(std::shared_ptr<const Objects> objects);

  /// nullptr before the first use().
  const Objects* objects() const;

  RobotContact timeOfContact(const Pairs& pairs, const RobotMotion& motion, const MotionQuestion& question = {});
  RobotMinimum minimum(const Pairs& pairs, const RobotMotion& motion, const MotionQuestion& question = {});

  /// The same for a motion in phases: times are those of the whole motion, and one deadline holds for all phases. The
  /// counts of pairs are the largest, and by_one_bound the smallest, of the phases that were searched; all other counts
  /// are sums.
  RobotContact timeOfContact(const Pairs& pairs, const PhasedMotion& motion, const MotionQuestion& question = {});
  RobotMinimum minimum(const Pairs& pairs, const PhasedMotion& motion, const MotionQuestion& question = {});

 private:
  explicit MovingScene(std::unique_ptr<MotionSearch> search);

  std::unique_ptr<MotionSearch> search_;
};

}  // namespace proximity_server::scene
