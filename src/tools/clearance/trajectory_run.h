#pragma once

#include <functional>
#include <optional>

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/motion/moving_scene.h"
#include "tools/clearance/clearance_run.h"
#include "tools/states/state_source.h"

namespace proximity_server::tools {

/// The motion from one way point to the next: every joint moves at constant velocity. A continuous joint moves by the
/// difference of its positions, which may be several turns.
struct TrajectorySegment {
  long number = 0;                ///< counted from 0
  double begin = 0.0, end = 1.0;  ///< [s] in the time of the trajectory
  scene::Positions from, to;

  /// `fraction` is 0 at the begin and 1 at the end. The time is rounded, but never outside of the segment; NaN gives
  /// NaN.
  double timeAt(double fraction) const;
  scene::Positions positionsAt(double fraction) const;
};

/// Reads a trajectory segment by segment; each row of the states is a way point. The times are those of the column
/// "time"; without that column, way point n is at n seconds.
///
/// Failure: throws std::invalid_argument naming the source (and line) for less than two way points, for a time that is
///          not later than the one before, and for a difference that is not finite; otherwise as StateSource.
class TrajectorySegments {
 public:
  /// The states must outlive this.
  explicit TrajectorySegments(StateSource& states) : states_(states) {}

  /// False at the end.
  bool next(TrajectorySegment& segment);

 private:
  struct WayPoint {
    double time;
    scene::Positions positions;
  };
  std::optional<WayPoint> readWayPoint();
  void check(const WayPoint& from, const WayPoint& to) const;

  StateSource& states_;
  std::optional<WayPoint> last_;
  long segments_ = 0;
};

/// Divides the segments where objects change in between, so that each has the same objects from its begin to its end.
class SegmentsWithObjects {
 public:
  /// Both must outlive this.
  SegmentsWithObjects(TrajectorySegments& segments, ObjectSchedule& objects) : segments_(segments), objects_(objects) {}

  /// As TrajectorySegments::next(), numbered anew; makes the changes that are due at the begin of the segment.
  bool next(TrajectorySegment& segment);

 private:
  TrajectorySegments& segments_;
  ObjectSchedule& objects_;
  std::optional<TrajectorySegment> rest_;  ///< of the segment that was divided
  long count_ = 0, way_point_ = 0;
};

/// The answer about one segment; its times are fractions of the segment.
struct SegmentClearance {
  TrajectorySegment segment;
  scene::RobotMinimum minimum;
  scene::RobotContact contact;
  std::shared_ptr<const scene::Objects> objects = nullptr;  ///< during this segment; nullptr: there are none
};

/// Answers the question about every segment, in their order, and passes each answer to `handle` in the calling thread.
/// The answers have the same bits for any number of threads.
/// Failure: throws the error of reading a state, after the answers about all segments before it were handled.
void answerSegments(const ClearanceQuestion& question, const scene::MotionQuestion& motion_question,
                    StateSource& states, const std::function<void(const SegmentClearance&)>& handle);

}  // namespace proximity_server::tools
