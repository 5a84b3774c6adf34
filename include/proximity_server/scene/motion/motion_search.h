#pragma once

#include "proximity_server/scene/motion/limited_motion.h"
#include "proximity_server/scene/motion/motion.h"
#include "proximity_server/scene/motion/motion_question.h"
#include "proximity_server/scene/query/pairs.h"
#include "proximity_server/scene/state/state.h"

#include <memory>

namespace proximity_server::scene {

/// Joins the answers of successive pieces. `before` found no contact. Pairs that it left open stay open.
RobotTimeOfContact followedBy(const RobotTimeOfContact& before, RobotTimeOfContact next);

/// Finds the first contact of a robot with its objects during a motion, and the smallest distance; with the working
/// memory of one caller. Not thread-safe.
///
/// 1. Straight pieces: pairs of volumes (links and objects, then parts of them, then convex pieces) and intervals of
///    time are searched best-first: the earliest for a contact, the closest for the minimum. A pair that one bound
///    settles for the whole motion is never divided. The narrowphase computes the pieces in the intervals that bounds do
///    not settle.
/// 2. A part of a piece along a spline is a straight motion of the joints, and a deviation of each joint from it, see
///    SplineSegment::chord(). The tracking error of a tube is a deviation as well. The deviations change the distance of
///    a pair by at most the sum of their effects: a bound of its own for each pair, as the joints that lie between its
///    shapes and their radii are its own. The straight motion is searched for distances that are smaller by this bound.
/// 3. Minimum along a spline: the part with the smallest lower bound is halved until it is within the tolerance of the
///    smallest distance at a state of the spline. Contact: a part that is not proven to be free becomes shorter, and
///    begins where the proof ended, until its begin is in contact. No sample decides anything.
/// 4. With a tube, the state that is nearest by its bound is taken, and from there the corner of the tube to which each
///    joint by itself leads nearer.
/// 5. Pieces are searched in their order, for a contact until one is found, or until one along a spline is not decided.
///    One deadline holds for all. The counts of pairs are the largest of the searched pieces, and by_one_bound is the
///    smallest; all other counts are sums.
///
/// Objects: an attached object moves with the body of its link; a fixed object stands in the world; a moving object
///          moves with its frame. The world and the frames are where RobotMotion::ObjectFrames says. Fixed objects that
///          are far from a link during a whole piece are skipped by bounds of their hierarchy, and so are the parts of
///          one object. Moving and attached objects are examined one by one.
/// Limit:   if a shape is inside a closed mesh during a motion, away from the surface of the mesh, the smallest
///          distance may be less exact than asked for: IterationLimit.
/// Failure: every question throws std::invalid_argument for a link, <collision> or object that does not exist, for two
///          objects with half-spaces, for a motion with a different number of bodies or frames, for a wrong number of
///          tracking errors, one that is negative or not finite, and, along a spline, for frames that move in their
///          parents.
class MotionSearch {
 public:
  /// Throws std::invalid_argument without a model.
  explicit MotionSearch(const std::shared_ptr<const SceneModel>& model);

  /// With the model and the objects of a state. The two share all data that never change.
  explicit MotionSearch(const State& state);
  ~MotionSearch();
  MotionSearch(MotionSearch&&) noexcept;
  MotionSearch& operator=(MotionSearch&&) noexcept;

  /// Returns another one of the same model and objects. The two share all data that never change.
  MotionSearch forAnotherThread() const;

  const SceneModel& model() const;

  /// Takes the next objects of the robot.
  /// Failure: throws std::invalid_argument for the objects of another model.
  void use(std::shared_ptr<const Objects> objects);

  /// Never nullptr.
  const Objects* objects() const;

  RobotTimeOfContact timeOfContact(const Pairs& pairs, const Motion& motion, const MotionQuestion& question = {});
  RobotMinimum minimum(const Pairs& pairs, const Motion& motion, const MotionQuestion& question = {});

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
};

}  // namespace proximity_server::scene
