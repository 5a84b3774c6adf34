#pragma once

#include "tools/clearance/clearance_question.h"
#include "tools/clearance/state_sweep.h"
#include "tools/states/state_source.h"

#include <optional>

namespace proximity_server::tools {

/// Reads a trajectory segment by segment; each row of the states is a way point. The times are those of the column
/// "time"; without that column, way point n is at n seconds.
///
/// Failure: throws std::invalid_argument naming the source (and line) for less than two way points, for a time that is
///          not later than the one before, and for a difference that is not finite; otherwise as StateSource.
class TrajectorySegments {
 public:
  /// With objects, a segment is divided where they change in between, so that each has the same objects from its begin
  /// to its end. Both must outlive this.
  explicit TrajectorySegments(StateSource& states, ObjectSchedule* objects = nullptr)
      : states_(states), objects_(objects) {}

  /// False at the end. Makes the changes that are due at the begin of the segment.
  bool next(TrajectorySegment& segment);

 private:
  struct WayPoint {
    double time;
    scene::Positions positions;
  };
  bool nextWhole(TrajectorySegment& segment);
  void divide(TrajectorySegment& segment);
  std::optional<WayPoint> readWayPoint();
  void check(const WayPoint& from, const WayPoint& to) const;

  StateSource& states_;
  ObjectSchedule* objects_;
  std::optional<WayPoint> last_;
  long way_points_ = 0;                    ///< that were left behind
  std::optional<TrajectorySegment> rest_;  ///< the rest of the segment that was divided
  long count_ = 0;
};

/// Answers the question about every segment, in their order, and writes their rows; they have the same bytes for any
/// number of threads.
/// Failure: throws the error of reading a state, after the rows of all segments before it were written.
void answerSegments(const ClearanceQuestion& question, StateSource& states, AnswerOutput& output);

}  // namespace proximity_server::tools
