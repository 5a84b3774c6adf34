#pragma once

#include "tools/clearance/clearance_question.h"
#include "tools/clearance/state_sweep.h"
#include "tools/states/state_source.h"

#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// The motion from one way point to the next: every joint moves at constant velocity, or along its spline. A continuous
/// joint moves by the difference of its positions, which may be several turns.
struct TrajectorySegment {
  long number = 0;                ///< counted from 0
  double begin = 0.0, end = 1.0;  ///< [s] in the time of the trajectory
  scene::Positions from, to;
  std::shared_ptr<const scene::Objects> objects = nullptr;  ///< during this segment; nullptr: there are none
  std::optional<scene::SplineSegment> spline{};             ///< nullopt: constant velocity, without tracking error

  /// `fraction` is 0 at the begin and 1 at the end. The time is rounded, but never outside of the segment; NaN gives
  /// NaN.
  double timeAt(double fraction) const;
  scene::Positions positionsAt(double fraction) const;
  TrajectorySegment between(double fraction, double end_fraction) const;
};

/// Reads a trajectory segment by segment; each row of the states is a way point. The times come from the column
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

  /// Each segment has a spline, also if it is linear.
  /// Failure: throws std::invalid_argument naming a missing column of velocities or accelerations.
  void interpolate(Interpolation interpolation);

  /// The first segment begins in this state at time 0, as scene::drivenFrom() has it: it leads to the first way point
  /// after time 0.
  void startFrom(const scene::TrajectoryPoint& start) { start_ = start; }

  /// False at the end. Makes the changes that are due at the begin of the segment.
  bool next(TrajectorySegment& segment);

 private:
  bool nextWhole(TrajectorySegment& segment);
  void divide(TrajectorySegment& segment);
  std::optional<scene::TrajectoryPoint> readWayPoint();
  std::optional<scene::TrajectoryPoint> nextWayPoint();
  void beginAtStart();
  void check(const scene::TrajectoryPoint& from, const scene::TrajectoryPoint& to) const;

  StateSource& states_;
  ObjectSchedule* objects_;
  std::optional<Interpolation> interpolation_;   ///< nullopt: segments have no spline
  std::optional<scene::TrajectoryPoint> start_;  ///< nullopt: none, or it was taken
  std::optional<scene::TrajectoryPoint> last_, next_;
  scene::Positions offsets_;               ///< [rad] full turns that the positions of way points get; empty: none
  long way_points_ = 0;                    ///< that were left behind; one less with startFrom()
  std::optional<TrajectorySegment> rest_;  ///< the rest of the segment that was divided
  long count_ = 0;
};

/// Answers the question about every segment, in their order, and writes their rows; they have the same bytes for any
/// number of threads. Returns warnings about splines that leave the limits of a joint, and that break inequalities;
/// "" for none.
/// Failure: throws the error of reading a state, after the rows of all segments before it were written.
std::vector<std::string> answerSegments(const ClearanceQuestion& question, StateSource& states, AnswerOutput& output);

}  // namespace proximity_server::tools
