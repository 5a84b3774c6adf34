#include "stress/motion_checks.h"

#include "narrowphase/certificate.h"
#include "oracle/shape_pairs.h"
#include "stress/campaign.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using testing::AssertionFailure;
using testing::AssertionResult;
using testing::AssertionSuccess;

/// The signed distance at a time.
struct Sample {
  double time;
  DistanceBounds distance;

  bool operator<(const Sample& other) const { return time < other.time; }
};

struct Answers {
  const char* name;
  StressMotion motion;
  TimeOfContact contact;
  MinimumOverMotion minimum;
};

MinimumOptions minimumOptions(const ContactOptions& options) {
  MinimumOptions result;
  result.tolerance = options.tolerance;
  result.begin = options.begin;
  result.end = options.end;
  result.max_queries = std::min(result.max_queries, options.max_queries);
  return result;
}

Answers answered(const char* name, const StressMotion& m) {
  return {name, m, timeOfContact(m.a, m.a_motion, m.b, m.b_motion, m.options),
          minimumDistance(m.a, m.a_motion, m.b, m.b_motion, minimumOptions(m.options))};
}

StressMotion swapped(const StressMotion& m) { return {m.b, m.b_motion, m.a, m.a_motion, m.options, m.suspects}; }

/// Moves all into another frame, which stands still.
StressMotion seenFromElsewhere(StressMotion m) {
  Chance chance(static_cast<unsigned>(m.a_motion.size() + 7 * m.b_motion.size()));
  const ScrewMotion frame{randomPose(chance, 1.0), Vector3d::Zero(), Vector3d::Zero()};
  m.a_motion.insert(m.a_motion.begin(), frame);
  m.b_motion.insert(m.b_motion.begin(), frame);
  return m;
}

// The search.

constexpr double kRough = 1e-6, kExact = 1e-13;  // [m] tolerances

class Search {
 public:
  explicit Search(const StressMotion& motion)
      : pair_(motion.pair()), options_(motion.options), speed_(pair_.speedLimit()) {
    constexpr int kSpread = 48;
    for (int i = 0; i <= kSpread; ++i) look(options_.begin + (options_.end - options_.begin) * i / kSpread, kRough);
    for (const double time : motion.suspects) look(time, kExact);
  }

  void look(double time, double tolerance) {
    if (!(options_.begin <= time && time <= options_.end)) return;
    samples_.push_back({time, fastDistanceAt(pair_, time, tolerance)});
  }

  /// Looks at the times that the answers name, and just before t_free.
  void lookAround(const Answers& answers) {
    look(answers.contact.t_contact, kExact);
    look(answers.contact.t_free, kExact);
    look(answers.minimum.time, kExact);
    for (double before = 1e-12; before < 1.0; before *= 30.0) look(answers.contact.t_free - before, kRough);
  }

  /// Looks for local minima between two samples where the distance may be below `level`; the lowest ones first.
  void lookBetween(double level) {
    constexpr std::size_t kMaxMinima = 5;
    std::sort(samples_.begin(), samples_.end());
    std::vector<std::size_t> low;
    for (std::size_t i = 0; i < samples_.size(); ++i)
      if (isLocalMinimum(i) && mayBeBelow(i, level)) low.push_back(i);
    const auto lower = [&](std::size_t i, std::size_t j) { return high(i) < high(j); };
    std::sort(low.begin(), low.end(), lower);
    std::vector<TimeInterval> intervals;
    for (std::size_t n = 0; n < std::min(low.size(), kMaxMinima); ++n) intervals.push_back(around(low[n]));
    for (const TimeInterval& interval : intervals) look(localMinimum(interval), kExact);
  }

  /// Looks at the first time at which the samples show a distance below the contact distance.
  void lookAtEntry() {
    std::sort(samples_.begin(), samples_.end());
    const auto inside = [&](const Sample& sample) { return sample.distance.high < options_.contact_distance; };
    const auto first = std::find_if(samples_.begin(), samples_.end(), inside);
    if (first == samples_.begin() || first == samples_.end()) return;
    double before = (first - 1)->time, after = first->time;
    for (int i = 0; i < 45; ++i) {
      const double middle = 0.5 * (before + after);
      (fastDistanceAt(pair_, middle, kExact).high < options_.contact_distance ? after : before) = middle;
    }
    look(after, kExact);
  }

  const std::vector<Sample>& samples() const { return samples_; }

 private:
  long double high(std::size_t i) const { return samples_[i].distance.high; }

  TimeInterval around(std::size_t i) const {
    return {samples_[i == 0 ? 0 : i - 1].time, samples_[std::min(i + 1, samples_.size() - 1)].time};
  }

  bool isLocalMinimum(std::size_t i) const {
    return (i == 0 || high(i) <= high(i - 1)) && (i + 1 == samples_.size() || high(i) <= high(i + 1));
  }

  bool mayBeBelow(std::size_t i, double level) const {
    const TimeInterval interval = around(i);
    return samples_[i].distance.low - speed_ * (interval.end - interval.begin) < level;
  }

  double localMinimum(const TimeInterval& interval) const {
    const DistanceOverTime distance{[&](long double time) { return fastDistanceAt(pair_, time, kExact); }, speed_};
    return static_cast<double>(timeOfLocalMinimum(distance, interval, 40));
  }

  MovingPair pair_;
  ContactOptions options_;
  long double speed_;
  std::vector<Sample> samples_;
};

// The checks.

AssertionResult fail(const char* what, long double excess, double time) {
  std::ostringstream out;
  out.precision(17);
  out << what << " by " << static_cast<double>(excess) << " m at " << time;
  return AssertionFailure() << out.str();
}

AssertionResult timesAreInOrder(const TimeOfContact& contact, const ContactOptions& options) {
  if (contact.status == Status::Unknown) return AssertionFailure() << "the contact is Unknown";
  if (!(options.begin <= contact.t_free && contact.t_free <= options.end))
    return AssertionFailure() << "t_free is outside of the motion: " << contact.t_free;
  if (contact.queries > options.max_queries) return AssertionFailure() << contact.queries << " queries";
  if (!contact.contact) {
    if (!std::isnan(contact.t_contact)) return AssertionFailure() << "no contact, but t_contact";
    if (contact.status == Status::Converged && contact.t_free != options.end)
      return AssertionFailure() << "no contact, but free only until " << contact.t_free;
    return AssertionSuccess();
  }
  if (!(contact.t_free <= contact.t_contact && contact.t_contact <= options.end))
    return AssertionFailure() << "t_contact is not in between";
  return AssertionSuccess();
}

/// The proof at one time: the normal is one of the frame of the chains, and the points lie on the shapes.
AssertionResult carriesItsProofAt(const StressMotion& m, double time, const SignedDistance& result, double rounding) {
  const LongPose frame_T_a = exactPoseAt(m.a_motion, time), frame_T_b = exactPoseAt(m.b_motion, time);
  const Isometry3d a_T_b = m.pair().relativePose(time).rounded();
  const Vector3l normal = frame_T_a.rotation.transpose() * result.normal.cast<long double>();
  const long double short_of = result.lower_bound - ShapePair{m.a, m.b, a_T_b}.gapAlong(normal.normalized());
  if (!(short_of <= rounding)) return fail("the normal does not prove the lower bound, short", short_of, time);
  if (!result.has_points) return AssertionSuccess();
  // Coordinates far from the origin of the chains are rounded by themselves.
  rounding += 8.0 * std::numeric_limits<double>::epsilon() * result.point_a.norm();
  const double off = (result.point_a + result.distance * result.normal - result.point_b).norm();
  if (!(off <= rounding)) return fail("point_b is not point_a + distance * normal, off", off, time);
  const Vector3d in_a = (frame_T_a.inverse() * Vector3l(result.point_a.cast<long double>())).cast<double>();
  const Vector3d in_b = (frame_T_b.inverse() * Vector3l(result.point_b.cast<long double>())).cast<double>();
  const long double allowed = rounding + (result.upper_bound - result.lower_bound);
  for (const auto& [shape, point] : {std::make_pair(&m.a, in_a), std::make_pair(&m.b, in_b)})
    if (outsideByAtMost(*shape, point) > allowed && outsideBy(*shape, point) > allowed)
      return fail("a point is not on its shape, off", outsideBy(*shape, point), time);
  return AssertionSuccess();
}

AssertionResult enclosedBy(const SignedDistance& result, const Sample& sample) {
  const auto& [time, distance] = sample;
  if (!(result.lower_bound - distance.high <= 0))
    return fail("the lower bound is above the distance", result.lower_bound - distance.high, time);
  if (!(distance.low - result.upper_bound <= 0))
    return fail("the upper bound is below the distance", distance.low - result.upper_bound, time);
  return AssertionSuccess();
}

// The bounds of an answer and of a sample are proven, rounding included. So these checks have no tolerance.

AssertionResult keepsPromise(const TimeOfContact& contact, const ContactOptions& options, const Sample& sample) {
  const long double inside = options.contact_distance - sample.distance.high;
  if (sample.time < contact.t_free && inside > 0)
    return fail(contact.contact ? "t_free is late: contact" : "contact was missed,", inside, sample.time);
  const long double outside = sample.distance.low - (options.contact_distance + options.tolerance);
  if (contact.contact && sample.time == contact.t_contact && outside > 0)
    return fail("there is no contact at t_contact, apart", outside, sample.time);
  return AssertionSuccess();
}

AssertionResult keepsPromise(const MinimumOverMotion& minimum, const Sample& sample) {
  const long double below = minimum.lower_bound - sample.distance.high;
  if (below > 0) return fail("the distance is below the minimum", below, sample.time);
  const long double above = sample.distance.low - minimum.upper_bound;
  if (sample.time == minimum.time && above > 0)
    return fail("the minimum is not reached at its time, off", above, sample.time);
  return AssertionSuccess();
}

AssertionResult boundsAreInOrder(const MinimumOverMotion& minimum, const MinimumOptions& options) {
  if (minimum.status == Status::Unknown) return AssertionFailure() << "the minimum is Unknown";
  if (!(minimum.lower_bound <= minimum.upper_bound))
    return AssertionFailure() << "the minimum's bounds are not in order";
  if (!(options.begin <= minimum.time && minimum.time <= options.end))
    return AssertionFailure() << "the minimum is outside of the motion: " << minimum.time;
  constexpr int kBothEnds = 2;
  if (minimum.queries > std::max(options.max_queries, kBothEnds))
    return AssertionFailure() << minimum.queries << " queries";
  const double gap = minimum.upper_bound - minimum.lower_bound;
  if (minimum.status == Status::Converged && !(gap <= options.tolerance))
    return AssertionFailure() << "the minimum converged, but its bounds are " << gap << " m apart";
  return AssertionSuccess();
}

AssertionResult keepAllPromises(const Answers& answers, const std::vector<Sample>& samples) {
  const StressMotion& m = answers.motion;
  const double rounding = m.pair().rounding();
  AssertionResult check = timesAreInOrder(answers.contact, m.options);
  if (check) check = boundsAreInOrder(answers.minimum, minimumOptions(m.options));
  for (const Sample& sample : samples) {
    if (check) check = keepsPromise(answers.contact, m.options, sample);
    if (check) check = keepsPromise(answers.minimum, sample);
    if (check && answers.contact.contact && sample.time == answers.contact.t_contact)
      check = enclosedBy(answers.contact.at_contact, sample);
    if (check && sample.time == answers.minimum.time) check = enclosedBy(answers.minimum.at_minimum, sample);
  }
  if (check && answers.contact.contact)
    check = carriesItsProofAt(m, answers.contact.t_contact, answers.contact.at_contact, rounding);
  if (check) check = carriesItsProofAt(m, answers.minimum.time, answers.minimum.at_minimum, rounding);
  return check;
}

/// The answers with the time that they took.
Answers timed(const StressMotion& m, MotionObservation& seen) {
  const stress::Stopwatch first;
  seen.contact = timeOfContact(m.a, m.a_motion, m.b, m.b_motion, m.options);
  seen.contact_microseconds = 1e6 * first.seconds();
  const stress::Stopwatch second;
  seen.minimum = minimumDistance(m.a, m.a_motion, m.b, m.b_motion, minimumOptions(m.options));
  seen.minimum_microseconds = 1e6 * second.seconds();
  return {"", m, seen.contact, seen.minimum};
}

/// The first promise that any of the answers breaks.
std::optional<std::string> brokenPromise(const std::vector<Answers>& all, Search& search) {
  const ContactOptions& options = all.front().motion.options;
  for (const Answers& answers : all) search.lookAround(answers);
  search.lookBetween(std::max(options.contact_distance, all.front().minimum.upper_bound));
  search.lookAtEntry();
  for (const Answers& answers : all)
    if (const AssertionResult check = keepAllPromises(answers, search.samples()); !check)
      return std::string(answers.name) + check.message();
  return std::nullopt;
}

MotionObservation observed(const StressMotion& motion, Search& search) {
  MotionObservation seen;
  const std::vector<Answers> all = {timed(motion, seen), answered("swapped: ", swapped(motion)),
                                    answered("from elsewhere: ", seenFromElsewhere(motion))};
  seen.failure = brokenPromise(all, search);
  for (const Sample& sample : search.samples())
    if (seen.contact.contact && sample.time == seen.contact.t_free)
      seen.gap = static_cast<double>(sample.distance.low) - motion.options.contact_distance;
  return seen;
}

}  // namespace

std::optional<std::string> brokenPromise(const StressMotion& motion, const TimeOfContact& contact,
                                         const MinimumOverMotion& minimum) {
  Search search(motion);
  return brokenPromise({{"", motion, contact, minimum}}, search);
}

MotionObservation observeMotion(const StressMotion& motion) {
  Search search(motion);
  return observed(motion, search);
}

MotionObservation observeMotionWithOracle(const StressMotion& motion) {
  Search search(motion);
  const MovingPair pair = motion.pair();
  const ContactOptions& options = motion.options;
  const DistanceOverTime distance{[&](long double time) { return fastDistanceAt(pair, time, kRough); },
                                  pair.speedLimit()};
  const FirstContact first =
      firstContact(distance, options.contact_distance, {options.begin, options.end}, 1e-9L, 20000);
  if (first.contact_by) search.look(static_cast<double>(*first.contact_by), kExact);
  MotionObservation seen = observed(motion, search);
  std::vector<Sample> exact;
  for (const double time : {seen.contact.t_contact, seen.contact.t_free, seen.minimum.time})
    if (!std::isnan(time)) exact.push_back({time, exactDistanceAt(pair, time, 4000)});
  const AssertionResult check = keepAllPromises({"", motion, seen.contact, seen.minimum}, exact);
  if (!check && !seen.failure) seen.failure = std::string("by the oracle: ") + check.message();
  return seen;
}

}  // namespace proximity_server::narrowphase
