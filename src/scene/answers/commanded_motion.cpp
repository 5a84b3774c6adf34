#include "proximity_server/scene/answers/commanded_motion.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace proximity_server::scene {
namespace {

/// The segment of a time, and this time on the segment: before 0 or after 1 if it belongs to none.
std::pair<const SplineSegment*, double> placeOf(const JointSplines& splines, double time) {
  const auto is_later = [](double t, const SplineSegment& segment) { return t < segment.begin(); };
  const auto next = std::upper_bound(splines.segments.begin() + 1, splines.segments.end(), time, is_later);
  const SplineSegment& segment = *std::prev(next);
  return {&segment, segment.placeAt(time)};
}

}  // namespace

TrajectoryPoint JointSplines::stateAt(double time) const {
  const auto [segment, place] = placeOf(*this, time);
  TrajectoryPoint state = segment->stateAt(std::clamp(place, 0.0, 1.0));
  state.time = time;
  if (place >= 0.0 && place <= 1.0) return state;
  std::fill(state.velocities.begin(), state.velocities.end(), 0.0);
  std::fill(state.accelerations.begin(), state.accelerations.end(), 0.0);
  return state;
}

double JointSplines::positionAt(int joint, double time) const {
  const auto [segment, place] = placeOf(*this, time);
  return segment->positionAt(joint, std::clamp(place, 0.0, 1.0));
}

void JointSplines::copyTo(SplineSegment& segment, int joint, double from, double to) const {
  const SplineSegment& source = *placeOf(*this, 0.5 * (from + to)).first;
  segment.copy(joint, source, std::clamp(source.placeAt(from), 0.0, 1.0), std::clamp(source.placeAt(to), 0.0, 1.0));
}

double JointSplines::largestSpeed(int joint, double from, double to) const {
  double largest = 0.0;
  auto segment = std::partition_point(segments.begin(), segments.end(),
                                      [&](const SplineSegment& before) { return before.end() < from; });
  for (; segment != segments.end() && segment->begin() <= to; ++segment)
    largest = std::max(largest, segment->largestSpeed(joint));
  return largest;
}

}  // namespace proximity_server::scene
