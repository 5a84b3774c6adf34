#include "peers/swept_bisection.h"

#include "proximity_server/narrowphase/signed_distance.h"

#include <vector>

namespace proximity_server::peers {

using namespace narrowphase;
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// x -> start^-1 exp(-twist t) x, where the motion is exp(twist t) start.
ScrewMotion inverse(const ScrewMotion& motion) {
  const Vector3d at_origin = motion.linear - motion.angular.cross(motion.start.translation());
  ScrewMotion result;
  result.start = motion.start.inverse(Eigen::Isometry);
  result.linear = -(result.start.linear() * at_origin);
  result.angular = -(result.start.linear() * motion.angular);
  return result;
}

struct Interval {
  double begin, end;
  double duration() const { return end - begin; }
  double middle() const { return 0.5 * (begin + end); }
};

/// A convex shape that holds all that a shape sweeps in an interval, in its own frame at the interval's beginning.
struct SweptVolume {
  Shape shape;
  double beyond_begin;  ///< [m] no point of it is farther from where the shape stands at the beginning
};

SweptVolume sweptVolume(const Shape& shape, const MotionChain& motion, const Interval& interval) {
  const MotionBound bound =
      motionBound(motion, shape.centre(), shape.coreRadius() + shape.margin(), interval.begin, interval.end);
  // The hull of the two ends holds the chords of all paths, whatever leads from one end to the other; the arcs leave
  // them by no more than the padding.
  const double arcs = bound.acceleration * interval.duration() * interval.duration() / 8.0;
  const Isometry3d end = poseAt(motion, interval.begin).inverse(Eigen::Isometry) * poseAt(motion, interval.end);
  const Shape swept = shape.sweptTo(end).padded(arcs);
  return {swept, bound.speed() * interval.duration() + arcs};
}

class Bisection {
 public:
  Bisection(const Shape& a, const MotionChain& a_motion, const Shape& b, const MotionChain& b_motion,
            const ContactOptions& options)
      : a_(a), b_(b), a_motion_(a_motion), motion_(relativeMotion(a_motion, b_motion)), options_(options) {}

  TimeOfContact run();

 private:
  bool isFree(const Interval& interval, const SweptVolume& volume);
  /// Half of the tolerance for what the volume adds, a quarter for each distance.
  bool isShort(const SweptVolume& volume) const { return volume.beyond_begin <= 0.5 * options_.tolerance; }
  void touchAt(double time);

  const Shape& a_;
  const Shape& b_;
  const MotionChain& a_motion_;
  MotionChain motion_;  // of b in the frame of a
  ContactOptions options_;
  TimeOfContact result_;
};

bool Bisection::isFree(const Interval& interval, const SweptVolume& volume) {
  Options question = Options::above(options_.contact_distance);
  question.distance_tolerance = 0.25 * options_.tolerance;
  ++result_.queries;
  const Isometry3d a_T_b = poseAt(motion_, interval.begin);
  return signedDistance(a_, volume.shape, a_T_b, question).lower_bound > options_.contact_distance;
}

void Bisection::touchAt(double time) {
  Options question;
  question.distance_tolerance = 0.25 * options_.tolerance;
  ++result_.queries;
  SignedDistance& touch = result_.at_contact;
  touch = signedDistance(a_, b_, poseAt(motion_, time), question);
  const Isometry3d pose = poseAt(a_motion_, time);
  touch.point_a = pose * touch.point_a;
  touch.point_b = pose * touch.point_b;
  touch.normal = pose.linear() * touch.normal;
  result_.contact = true;
  result_.t_contact = time;
}

TimeOfContact Bisection::run() {
  result_.t_free = options_.begin;
  if (!poseAt(motion_, options_.begin).matrix().allFinite() || !poseAt(motion_, options_.end).matrix().allFinite())
    return result_;
  result_.status = Status::Converged;
  std::vector<Interval> later = {{options_.begin, options_.end}};
  while (!later.empty()) {
    const Interval interval = later.back();
    const SweptVolume volume = sweptVolume(b_, motion_, interval);
    if (result_.queries >= options_.max_queries) {
      result_.status = Status::IterationLimit;
      return result_;
    }
    later.pop_back();
    if (isFree(interval, volume)) {
      result_.t_free = interval.end;
      continue;
    }
    if (isShort(volume)) {
      touchAt(interval.begin);
      return result_;
    }
    const double middle = interval.middle();
    if (middle <= interval.begin || middle >= interval.end) {
      result_.status = Status::Degenerate;
      return result_;
    }
    later.push_back({middle, interval.end});
    later.push_back({interval.begin, middle});
  }
  return result_;
}

}  // namespace

MotionChain relativeMotion(const MotionChain& a_motion, const MotionChain& b_motion) {
  MotionChain relative;
  for (auto screw = a_motion.rbegin(); screw != a_motion.rend(); ++screw) relative.push_back(inverse(*screw));
  relative.insert(relative.end(), b_motion.begin(), b_motion.end());
  return relative;
}

TimeOfContact timeOfContactBySweeping(const Shape& a, const MotionChain& a_motion, const Shape& b,
                                      const MotionChain& b_motion, const ContactOptions& options) {
  return Bisection(a, a_motion, b, b_motion, options).run();
}

}  // namespace proximity_server::peers
