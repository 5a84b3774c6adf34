#pragma once

#include "proximity_server/scene/motion/joint_spline.h"
#include "proximity_server/scene/motion/motion_question.h"
#include "proximity_server/scene/motion/moving_scene.h"
#include "proximity_server/scene/motion/robot_motion.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/pairs.h"

#include <functional>
#include <memory>
#include <vector>

namespace proximity_server::scene {

class MotionSearch;

/// A question about a segment of a spline, or about the tube around it.
struct SplineQuestion {
  MotionQuestion motion;
  /// Per joint [rad] or [m]: how far the robot may be off the spline at any time; mimic joints follow. Empty: nowhere.
  std::vector<double> tracking_error{};
  /// The frames of the objects, see RobotMotion::ObjectFrames. Each frame must rest relative to its parent.
  RobotMotion::ObjectFrames frames{};
  /// The poses of all bodies at the given positions; empty: forwardKinematics(). A joint whose position changes along
  /// the segment must move as there, by the difference of its positions; all others may stand anywhere.
  std::function<BodyPoses(const Positions&)> poses{};
};

/// The smallest distance along a segment. Without a tube the bounds are those of RobotMinimum. With one the lower bound
/// is the guaranteed distance: no state of the tube is nearer. The upper bound is the distance of a state of the tube.
/// Converged: the guaranteed distance is within the tolerance of what the bounds of the tube allow at one time.
struct SplineMinimum : RobotMinimum {
  Positions state;  ///< that of `pair`: on the spline at `time`, or in the tube around it; empty: none
};

/// The first contact along a segment. `t_free` is proven for the spline, or for all states of the tube.
///
/// Converged without contact: there is none. With contact: `state` at `t_contact` is in contact; of a tube, that may be
/// later than `t_free`, when the spline itself touches. Degenerate without contact: from `t_free` on the tube may touch,
/// and no state of it is known that does; `pair` is the pair that may.
struct SplineContact : RobotTimeOfContact {
  Positions state;  ///< at contact; empty: none
};

/// One robot with its objects on the way along a spline, and the working memory of one caller. Not thread-safe.
///
/// 1. A part of a segment is a straight motion of the joints, and a deviation of each joint from it, see
///    SplineSegment::chord(). The tracking error of a tube is a deviation as well.
/// 2. The deviations change the distance of a pair by at most the sum of their effects: a bound of its own for each
///    pair, as the joints that lie between its shapes and their radii are its own. The straight motion is
///    searched as by MovingScene, for distances that are smaller by this bound.
/// 3. Minimum: the part with the smallest lower bound is halved until it is within the tolerance of the smallest
///    distance at a state of the spline. Contact: a part that is not proven to be free becomes shorter, and begins where
///    the proof ended, until its begin is in contact. No sample decides anything.
/// 4. With a tube, the state that is nearest by its bound is taken, and from there the corner of the tube to which each
///    joint by itself leads nearer.
///
/// Failure: each question throws std::invalid_argument for a wrong number of tracking errors, one that is negative or not
///          finite, and frames that move; otherwise as MovingScene.
class SplineScene {
 public:
  /// Throws std::invalid_argument without a model.
  explicit SplineScene(const std::shared_ptr<const SceneModel>& model);
  /// With the model and the objects of a state. The two share all data that never change.
  explicit SplineScene(const State& state);
  ~SplineScene();
  SplineScene(SplineScene&&) noexcept;
  SplineScene& operator=(SplineScene&&) noexcept;

  /// Returns another one of the same model and objects. The two share all data that never change.
  SplineScene forAnotherThread() const;

  const SceneModel& model() const;

  /// Takes the next objects of the robot.
  /// Failure: throws std::invalid_argument for the objects of another model.
  void use(std::shared_ptr<const Objects> objects);

  /// Never nullptr.
  const Objects* objects() const;

  SplineMinimum minimum(const Pairs& pairs, const SplineSegment& segment, const SplineQuestion& question = {});
  SplineContact timeOfContact(const Pairs& pairs, const SplineSegment& segment, const SplineQuestion& question = {});

 private:
  std::unique_ptr<MotionSearch> search_;
};

}  // namespace proximity_server::scene
