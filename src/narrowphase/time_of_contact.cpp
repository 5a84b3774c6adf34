#include <algorithm>
#include <cmath>

#include "moving_pair.h"

namespace proximity_server {
namespace {

using Eigen::Vector3d;

/// The way to the first contact, in steps that pass none.
class Advancement {
 public:
  Advancement(MovingPair& pair, const ContactOptions& options) : pair_(pair), options_(options) {
    distance_options_.distance_tolerance = 0.25 * options.tolerance;
  }

  TimeOfContact run() {
    TimeOfContact answer;
    double time = options_.begin;
    MovingPair::Poses poses = pair_.at(time);
    for (;;) {
      const SignedDistance distance = pair_.distance(poses, distance_options_);
      ++answer.queries;
      answer.t_free = time;
      if (distance.status == Status::Unknown) return answer;
      if (distance.upper_bound <= options_.clearance + options_.tolerance) return inContact(answer, distance);
      if (!(distance.lower_bound > level())) return undecided(answer, Status::Degenerate);
      if (time == options_.end) return decided(answer);
      if (answer.queries == options_.max_queries) return undecided(answer, Status::IterationLimit);

      const double next = advance(time, distance);
      if (next == options_.end) return decided(answer);
      if (!(next > time)) return undecided(answer, Status::Degenerate);
      time = next;
      poses = pair_.at(time);
    }
  }

 private:
  /// [m] a gap at which a step may end: above the clearance, so that it proves what is behind it.
  double level() const { return options_.clearance + 0.25 * options_.tolerance; }

  TimeOfContact inContact(TimeOfContact answer, const SignedDistance& distance) const {
    answer.status = Status::Converged;
    answer.contact = true;
    answer.t_contact = answer.t_free;
    answer.at_contact = pair_.inChainsFrame(distance);
    return answer;
  }

  TimeOfContact decided(TimeOfContact answer) const {
    answer.status = Status::Converged;
    answer.t_free = options_.end;
    return answer;
  }

  static TimeOfContact undecided(TimeOfContact answer, Status status) {
    answer.status = status;
    return answer;
  }

  /// The latest time that the normal of the distance at `time` proves to be free.
  ///
  /// The longer the step that is tried, the lower the bound lies in between; so it is tried again with a step that ends
  /// where the chord of the last one met the level.
  double advance(double time, const SignedDistance& distance) {
    constexpr int kMostTrials = 3;
    double proven = 0.0, duration = firstTrial(time, distance.lower_bound - options_.clearance);
    for (int trial = 0; trial < kMostTrials; ++trial) {
      const bool is_last = time + duration >= options_.end;
      const double end = is_last ? options_.end : time + duration;
      const AxisBound bound{distance.lower_bound, pair_.gapAlong(distance.normal, pair_.at(end)), acceleration_,
                            end - time};
      const double free = bound.firstTimeAt(level());
      proven = std::max(proven, free);
      if (!(free < bound.duration)) return end;
      const double chord = bound.duration * (bound.begin - level()) / (bound.begin - bound.end);
      if (!(chord < 0.9 * bound.duration) || proven > 0.9 * chord) break;
      duration = chord;
    }
    return time + proven;
  }

  /// A step over which the parabola takes half of the gap away.
  double firstTrial(double time, double gap) {
    const double rest = options_.end - time;
    double duration = std::min(rest, last_trial_);
    acceleration_ = pair_.acceleration(time, time + duration);
    duration = std::min(rest, acceleration_ > 0.0 ? 2.0 * std::sqrt(gap / acceleration_) : rest);
    acceleration_ = pair_.acceleration(time, time + duration);
    last_trial_ = 2.0 * duration;
    return duration;
  }

  MovingPair& pair_;
  const ContactOptions options_;
  Options distance_options_;
  double acceleration_ = 0.0;
  double last_trial_ = std::numeric_limits<double>::infinity();
};

}  // namespace

TimeOfContact timeOfContact(const Shape& a, const MotionChain& a_motion, const Shape& b, const MotionChain& b_motion,
                            const ContactOptions& options) {
  MovingPair pair(a, a_motion, b, b_motion);
  return pair.isFinite() ? Advancement(pair, options).run() : TimeOfContact();
}

}  // namespace proximity_server
