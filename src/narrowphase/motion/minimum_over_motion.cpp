#include "narrowphase/motion/moving_pair.h"

#include <algorithm>
#include <array>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;

constexpr int kMaxSamples = 512;

/// Branch and bound over time. The normals at both ends of an interval are two fixed axes; a third axis turns from the
/// first to the second. The third gives the best bound if the normal changes smoothly, the fixed ones if it jumps.
class TimeSubdivision {
 public:
  TimeSubdivision(MovingPair& pair, const MinimumOptions& options) : pair_(pair), options_(options) {
    distance_options_.distance_tolerance = 0.25 * options.tolerance;
  }

  MinimumOverMotion run() {
    const int first = sample(options_.begin);
    const int last = options_.end > options_.begin ? sample(options_.end) : first;
    if (overflows_) return unknown();
    enter(first, last, -std::numeric_limits<double>::infinity());
    while (count_ > 0 && answer_.upper_bound - intervals_.front().lower_bound > options_.tolerance) {
      const Interval worst = intervals_.front();
      const bool is_too_short = !(at(worst.begin).time < worst.middle && worst.middle < at(worst.end).time);
      if (is_too_short) return finished(Status::Degenerate);
      if (answer_.queries >= std::min(options_.max_queries, kMaxSamples)) return finished(Status::IterationLimit);
      pop();
      const int middle = sample(worst.middle);
      if (overflows_) return unknown();
      enter(worst.begin, middle, worst.lower_bound);
      enter(middle, worst.end, worst.lower_bound);
    }
    return finished(Status::Converged);
  }

 private:
  struct Sample {
    double time;
    MovingPair::Poses poses;
    Vector3d normal;
    double lower_bound;  ///< [m] of the distance, proven by the normal
  };
  struct Interval {
    double lower_bound;  ///< [m]
    double middle;       ///< time at which the interval is to be divided
    int begin, end;      ///< samples
    bool operator<(const Interval& other) const { return lower_bound > other.lower_bound; }  // the smallest in front
  };

  const Sample& at(int sample) const { return samples_[sample]; }

  int sample(double time) {
    const MovingPair::Poses poses = pair_.at(time);
    const SignedDistance distance = pair_.distance(poses, distance_options_);
    overflows_ |= distance.status == Status::Unknown;
    samples_[answer_.queries] = {time, poses, distance.normal, distance.lower_bound};
    if (distance.upper_bound < answer_.upper_bound) {
      answer_.upper_bound = distance.upper_bound;
      answer_.time = time;
      answer_.at_minimum = distance;
    }
    return answer_.queries++;
  }

  void enter(int begin, int end, double known_bound) {
    Interval interval = bounded(begin, end);
    interval.lower_bound = std::max(known_bound, interval.lower_bound);  // in this order NaN is ignored
    if (interval.lower_bound > options_.stop_above) {
      settled_ = std::min(settled_, interval.lower_bound);
      return;
    }
    intervals_[count_++] = interval;
    std::push_heap(intervals_.begin(), intervals_.begin() + count_);
  }

  void pop() {
    std::pop_heap(intervals_.begin(), intervals_.begin() + count_);
    --count_;
  }

  Interval bounded(int begin, int end) {
    const Sample &first = at(begin), &last = at(end);
    const double duration = last.time - first.time;
    if (duration == 0.0) return {first.lower_bound, first.time, begin, end};
    const MotionBound motion = pair_.motion(first.time, last.time);
    const AxisBound::End at_first{first.normal, first.lower_bound}, at_last{last.normal, last.lower_bound};
    const AxisBound by_first(at_first, {first.normal, pair_.gapAlong(first.normal, last.poses)}, motion, duration);
    const AxisBound by_last({last.normal, pair_.gapAlong(last.normal, first.poses)}, at_last, motion, duration);
    const AxisBound turning(at_first, at_last, motion, duration);
    double lowest = lowestTime(by_first, by_last), bound = std::max(by_first.at(lowest), by_last.at(lowest));
    if (const double other = turning.lowestTime(); turning.at(other) > bound) {
      lowest = other;
      bound = turning.at(other);
    }
    return {bound, first.time + std::clamp(lowest, duration / 16.0, duration * (15.0 / 16.0)), begin, end};
  }

  /// The time at which the larger of two bounds with the same parabola is smallest: at the lowest point of one bound if
  /// the other is lower there, otherwise where they cross.
  static double lowestTime(const AxisBound& p, const AxisBound& q) {
    const double of_p = p.lowestTime(), of_q = q.lowestTime();
    if (q.at(of_p) <= p.at(of_p)) return of_p;
    if (p.at(of_q) <= q.at(of_q)) return of_q;
    const double at_begin = p.begin() - q.begin(), at_end = p.end() - q.end();
    return p.duration() * std::clamp(at_begin / (at_begin - at_end), 0.0, 1.0);
  }

  MinimumOverMotion unknown() const {
    MinimumOverMotion answer;
    answer.queries = answer_.queries;
    return answer;
  }

  MinimumOverMotion finished(Status status) {
    const double open = count_ > 0 ? intervals_.front().lower_bound : settled_;
    answer_.lower_bound = std::min({open, settled_, answer_.upper_bound});
    answer_.status = answer_.lower_bound > options_.stop_above ? Status::Threshold : status;
    answer_.at_minimum = pair_.inChainsFrame(answer_.at_minimum);
    return answer_;
  }

  MovingPair& pair_;
  const MinimumOptions options_;
  Options distance_options_;
  MinimumOverMotion answer_;
  std::array<Sample, kMaxSamples> samples_;
  std::array<Interval, kMaxSamples> intervals_;  // a heap
  int count_ = 0;
  bool overflows_ = false;                                    ///< a sample is too far for the narrowphase
  double settled_ = std::numeric_limits<double>::infinity();  // [m] smallest bound of the intervals above stop_above
};

}  // namespace

MinimumOverMotion minimumDistance(const Shape& a, const MotionChain& a_motion, const Shape& b,
                                  const MotionChain& b_motion, const MinimumOptions& options) {
  return searched<TimeSubdivision>(a, a_motion, b, b_motion, options);
}

}  // namespace proximity_server::narrowphase
