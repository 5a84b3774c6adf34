#pragma once

#include "proximity_server/scene/motion/limited_motion.h"
#include "proximity_server/scene/motion/motion_question.h"
#include "proximity_server/scene/query/scene.h"

#include <memory>

namespace proximity_server::scene {

class MotionSearch;

/// One robot with its objects in motion, and the working memory of one caller. Not thread-safe.
///
/// Pairs of volumes (links and objects, then parts of them, then convex pieces) and intervals of time are searched
/// best-first: the earliest for a contact, the closest for the minimum. A pair that one bound settles for the whole
/// motion is never divided. The narrowphase computes the pieces in the intervals that bounds do not settle. A question
/// allocates memory for the poses and kinematic chains of its motion.
///
/// Objects: an attached object moves with the body of its link; a fixed object stands in the world; a moving object
///          moves with its frame. The world and the frames are where RobotMotion::ObjectFrames says. Fixed objects that
///          are far from a link during the whole motion are skipped by bounds of their hierarchy, and so are the parts
///          of one object. Moving and attached objects are examined one by one.
/// Limit:   if a shape is inside a closed mesh during a motion, away from the surface of the mesh, the smallest
///          distance may be less exact than asked for: IterationLimit.
/// Failure: every question throws std::invalid_argument for a link, <collision> or object that does not exist, for two
///          objects with half-spaces, and for a motion with a different number of bodies or frames.
class MovingScene {
 public:
  /// Throws std::invalid_argument without a model.
  explicit MovingScene(const std::shared_ptr<const SceneModel>& model);

  /// With the model and the objects of a state. The two share all data that never change.
  explicit MovingScene(const State& state);
  ~MovingScene();
  MovingScene(MovingScene&&) noexcept;
  MovingScene& operator=(MovingScene&&) noexcept;

  /// Returns another moving scene of the same model and objects. The two share all data that never change.
  MovingScene forAnotherThread() const;

  const SceneModel& model() const;

  /// Takes the next objects of the robot.
  /// Failure: throws std::invalid_argument for the objects of another model.
  void use(std::shared_ptr<const Objects> objects);

  /// Never nullptr.
  const Objects* objects() const;

  RobotTimeOfContact timeOfContact(const Pairs& pairs, const RobotMotion& motion, const MotionQuestion& question = {});
  RobotMinimum minimum(const Pairs& pairs, const RobotMotion& motion, const MotionQuestion& question = {});

  /// Answer the same questions for a motion in phases. Times are those of the whole motion, and one deadline holds for
  /// all phases. The counts of pairs are the largest of the phases that were searched, and by_one_bound is the
  /// smallest; all other counts are sums.
  RobotTimeOfContact timeOfContact(const Pairs& pairs, const PhasedMotion& motion, const MotionQuestion& question = {});
  RobotMinimum minimum(const Pairs& pairs, const PhasedMotion& motion, const MotionQuestion& question = {});

 private:
  std::unique_ptr<MotionSearch> search_;
};

}  // namespace proximity_server::scene
