#pragma once

#include <functional>
#include <optional>

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/motion/moving_scene.h"
#include "tools/clearance/clearance_run.h"
#include "tools/command_line/joint_states.h"

namespace proximity_server::tools {

/// From one way point to the next: every joint at constant velocity, a continuous one by the difference of its
/// positions, which may be several turns.
struct TrajectorySegment {
  long number = 0;                ///< counted from 0
  double begin = 0.0, end = 1.0;  ///< [s] on the trajectory's clock
  scene::Positions from, to;

  /// `fraction` goes from 0 at the begin to 1 at the end. The time is rounded, but never outside of the segment; NaN
  /// gives NaN.
  double timeAt(double fraction) const;
  scene::Positions positionsAt(double fraction) const;
};

/// Reads the way points of a trajectory, two by two: each row of the states is one. The times are those of the column
/// "time"; without it, way point n is at n seconds.
///
/// Failure: throws std::invalid_argument naming the source (and line) for less than two way points, for a time that is
///          not later than the one before, and for a difference that is no finite number; otherwise as JointStates.
class TrajectorySegments {
 public:
  /// The states must outlive this.
  explicit TrajectorySegments(JointStates& states) : states_(states) {}

  /// False at the end.
  bool next(TrajectorySegment& segment);

 private:
  struct WayPoint {
    double time;
    scene::Positions positions;
  };
  std::optional<WayPoint> readWayPoint();
  void check(const WayPoint& from, const WayPoint& to) const;

  JointStates& states_;
  std::optional<WayPoint> last_;
  long segments_ = 0;
};

/// What was found in one segment; times are fractions of it.
struct SegmentClearance {
  TrajectorySegment segment;
  scene::RobotMinimum minimum;
  scene::RobotContact contact;
};

/// Answers the question for every segment, in their order, and hands each answer to `take` in the calling thread. The
/// answers are the same, bit by bit, for any number of threads.
/// Failure: what reading threw, after the answers to all segments before it were taken.
void answerSegments(const ClearanceQuestion& question, const scene::MotionQuestion& motion_question,
                    JointStates& states, const std::function<void(const SegmentClearance&)>& take);

}  // namespace proximity_server::tools
