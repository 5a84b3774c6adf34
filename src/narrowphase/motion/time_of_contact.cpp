#include "narrowphase/motion/moving_pair.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;

/// Advances to the time of contact, in steps that are proven to be free of contact.
class Advancement {
 public:
  Advancement(MovingPair& pair, const ContactOptions& options)
      : pair_(pair), options_(options), duration_(options.end - options.begin) {
    distance_options_.distance_tolerance = 0.25 * options.tolerance;
  }

  TimeOfContact run() {
    TimeOfContact answer;
    for (double time = options_.begin;;) {
      const SignedDistance distance = pair_.distance(pair_.at(time), distance_options_);
      ++answer.queries;
      answer.t_free = time;
      if (distance.status == Status::Unknown) return answer;
      if (distance.upper_bound <= options_.contact_distance + options_.tolerance) return inContact(answer, distance);
      if (!(distance.lower_bound > level())) return undecided(answer, Status::Degenerate);
      const bool is_over = answer.queries >= options_.max_queries || (options_.is_over && options_.is_over());
      if (is_over) return undecided(answer, Status::IterationLimit);

      const double next = advance(time, distance);
      if (next == options_.end) return decided(answer);
      if (!(next > time)) return undecided(answer, Status::Degenerate);
      time = next;
    }
  }

 private:
  /// [m] Gap at which a step ends. It is above the contact distance, so that the time before it is proven to be free.
  double level() const { return options_.contact_distance + 0.25 * options_.tolerance; }

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

  /// The latest time up to which the normal of the distance proves that there is no contact.
  ///
  /// The longer the trial step, the lower the bound between its ends. The next trial therefore ends where the chord of
  /// the last one met the level.
  double advance(double time, const SignedDistance& distance) {
    constexpr int kMaxTrials = 3;
    const Rates rates = ratesSince(time, distance);
    firstTrial(time, distance.lower_bound - options_.contact_distance, rates.approach);
    double free = 0.0;
    for (int trial = 0; trial < kMaxTrials; ++trial) {
      const double end = std::min(options_.end, time + duration_);
      const AxisBound bound = bestBound(distance, distance.normal + (end - time) * rates.turning, time, end);
      free = std::max(free, bound.firstTimeAt(level()));
      if (!(free < bound.duration())) return end;
      const double chord = bound.duration() * (bound.begin() - level()) / (bound.begin() - bound.end());
      if (!(chord < 0.9 * bound.duration()) || free > 0.9 * chord) break;
      duration_ = chord;
    }
    return time + free;
  }

  /// Rates of change since the last step, per unit of time; zero in the first step.
  struct Rates {
    Vector3d turning = Vector3d::Zero();  ///< of the normal
    double approach = 0.0;                ///< [m] by which the distance decreases
  };
  Rates ratesSince(double time, const SignedDistance& distance) {
    Rates rates;
    if (time > last_time_) {
      rates.turning = (distance.normal - last_.normal) / (time - last_time_);
      rates.approach = (last_.lower_bound - distance.lower_bound) / (time - last_time_);
    }
    last_time_ = time;
    last_ = distance;
    return rates;
  }

  /// Sets the duration of the first trial: during it the parabola of the acceleration takes half of the gap, and if the
  /// shapes approach as before, it ends a little after contact. A longer step would lower the bound between its ends.
  void firstTrial(double time, double gap, double approach) {
    constexpr double kBeyondContact = 1.25, kMaxGrowth = 16.0;
    double window = std::min(options_.end - time, kMaxGrowth * duration_);
    if (approach > 0.0) window = std::min(window, kBeyondContact * gap / approach);
    motion_ = pair_.motion(time, time + window);
    duration_ = std::min(window, 2.0 * std::sqrt(gap / motion_.acceleration));  // infinite without acceleration
    if (duration_ < 0.5 * window) motion_ = pair_.motion(time, time + duration_);
  }

  /// The better of two bounds: along the normal of the distance, and along an axis that turns from it to `turned`.
  AxisBound bestBound(const SignedDistance& distance, const Vector3d& turned, double begin, double end) {
    const MovingPair::Poses poses = pair_.at(end);
    const auto boundTo = [&](const Vector3d& normal) {
      const double gap = pair_.gapAlong(normal, poses);
      return AxisBound({distance.normal, distance.lower_bound}, {normal, gap}, motion_, end - begin);
    };
    const AxisBound standing = boundTo(distance.normal);
    constexpr double kSmallestNorm = 0.5;  // a shorter vector comes from a jump of the normal, not from a turn
    if (turned == distance.normal || !(turned.norm() > kSmallestNorm)) return standing;
    const AxisBound turning = boundTo(turned.normalized());
    return turning.firstTimeAt(level()) > standing.firstTimeAt(level()) ? turning : standing;
  }

  MovingPair& pair_;
  const ContactOptions options_;
  Options distance_options_;
  MotionBound motion_;  ///< during the trial step
  double duration_;     ///< of the trial step
  double last_time_ = std::numeric_limits<double>::infinity();
  SignedDistance last_;  ///< at that time
};

}  // namespace

TimeOfContact timeOfContact(const Shape& a, const MotionChain& a_motion, const Shape& b, const MotionChain& b_motion,
                            const ContactOptions& options) {
  return searched<Advancement>(a, a_motion, b, b_motion, options);
}

}  // namespace proximity_server::narrowphase
