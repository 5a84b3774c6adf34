#pragma once

#include <memory>

#include "proximity_server/scene/motion/limited_motion.h"
#include "proximity_server/scene/motion/motion_question.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::scene {

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
