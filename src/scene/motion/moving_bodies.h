#pragma once

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/robot_motion.h"
#include "scene/bounds/bounds.h"

#include <array>
#include <vector>

namespace proximity_server::scene {

/// The poses of a robot and its objects in motion. The poses of the robot are computed once for each time.
///
/// A frame has a number. -1 is the frame of the poses, and each body of the robot has its own number. The next numbers
/// belong to the world, if it is not the frame of the poses, of the frames of moving objects, and of the frames that
/// add() added.
class PosesInTime {
 public:
  using Segment = RobotMotion::Segment;

  PosesInTime() = default;
  explicit PosesInTime(const RobotMotion& motion) { follow(motion); }

  /// Takes the next motion, which must outlive its use.
  void follow(const RobotMotion& motion);

  static constexpr double kMiddle = 0.5;  ///< the time in the middle of the motion

  const RobotMotion& motion() const { return *motion_; }
  const BodyPoses& at(double time);

  const Segment& segment(int frame) const {
    const auto index = static_cast<std::size_t>(frame), bodies = motion_->segments().size();
    return index < bodies ? motion_->segments()[index] : others_[index - bodies];
  }

  int world() const { return world_; }
  int moving(int index) const { return first_moving_ + index; }  ///< one of RobotMotion::ObjectFrames::moving

  /// Adds a frame that rests in the world, and returns its number.
  int add(const Eigen::Isometry3d& world_T_frame);

  /// True if the poses of a frame and of all its ancestors are known.
  bool isKnown(int frame) const;

  /// The pose of a known frame in the frame of the poses.
  Eigen::Isometry3d pose(int frame, double time);

  /// The frames between which a way leads from one frame to another: first each is left for its parent, then each is
  /// entered from its parent.
  struct Way {
    std::vector<int> left, entered;
    std::size_t size() const { return left.size() + entered.size(); }
    /// The frame whose joint is step i.
    int frame(std::size_t i) const { return i < left.size() ? left[i] : entered[i - left.size()]; }

    /// The smallest sum of what the steps do to the two ends, as they are seen from one of the frames of the way:
    /// `to_from(frame)` of each step between it and the first frame, and `to_to(frame)` of the others. Both are called
    /// from the end on. `sums` is working memory.
    template <class ToFrom, class ToTo>
    double smallestSum(std::vector<double>& sums, const ToFrom& to_from, const ToTo& to_to) const {
      sums.assign(1, 0.0);
      for (std::size_t i = 0; i < size(); ++i) sums.push_back(sums.back() + to_from(frame(i)));
      double smallest = sums.back(), others = 0.0;
      for (std::size_t i = size(); i-- > 0;) {
        others += to_to(frame(i));
        smallest = std::min(smallest, sums[i] + others);
      }
      return smallest;
    }
  };
  /// Valid until the next call.
  const Way& wayBetween(int from, int to) const;

 private:
  struct Known {
    double time;
    int poses;  ///< index into poses_
  };

  const RobotMotion* motion_ = nullptr;
  int world_ = -1, first_moving_ = 0;
  std::vector<Segment> others_;   ///< the frames behind the bodies
  std::vector<Known> known_;      ///< by time
  std::vector<BodyPoses> poses_;  ///< kept for the next motion
  mutable Way way_;
};

/// The body from which two moving bodies are seen. Middle: the body in the middle of the moving joints, so that each of
/// the two moves little; if only one joint moves, the body from which the other one moves less. A or B: one of the two.
/// A large shape should be seen at rest, because its far ends move much with every turn.
enum class SeenFrom : unsigned char { Middle, A, B };

/// Two bodies in motion, or other frames of PosesInTime, seen from a body between them.
class MovingBodies {
 public:
  MovingBodies() = default;

  /// `a` and `b` bound all parts of the bodies that later calls are about.
  MovingBodies(const PosesInTime& poses, int body_a, const Bounds& a, int body_b, const Bounds& b,
               SeenFrom seen_from = SeenFrom::Middle) {
    follow(poses, body_a, a, body_b, b, seen_from);
  }

  /// Takes other bodies.
  void follow(const PosesInTime& poses, int body_a, const Bounds& a, int body_b, const Bounds& b, SeenFrom seen_from);

  /// False if a pose is missing.
  bool isKnown() const { return is_known_; }

  /// The motions of a body; never empty.
  const narrowphase::MotionChain& chainOfA() const { return chain_a_; }
  const narrowphase::MotionChain& chainOfB() const { return chain_b_; }

  /// The body from which they are seen; -1: the frame of the poses.
  int middle() const { return middle_; }

  /// An interval of time by bisection: the whole motion is number 1, the halves of n are 2 n and 2 n + 1.
  struct Interval {
    explicit Interval(int number);
    std::array<Interval, 2> halves() const { return {Interval(2 * number), Interval(2 * number + 1)}; }

    /// True if the interval is longer than the whole motion is after so many halvings.
    bool isLongerThan(int level) const { return number < 1 << level; }

    int number;
    double begin, end;
  };

  /// [m] An upper bound of the distance of any point of the two from the origin of the body from which they are seen,
  /// at any time.
  double reach() const;

  /// `gap`: a lower bound [m] of the signed distance, during an interval, of the contents of two spheres that are fixed
  /// to the bodies. `travel`: how far [m] the sphere of b moves as seen from the sphere of a.
  struct SphereGap {
    double gap, travel;
  };
  SphereGap sphereGap(const Bounds& a, const Bounds& b, const Interval& interval, PosesInTime& poses);

  /// [m] An upper bound of the effect of the rounding of chainOfA() and chainOfB() on a distance. It is 0 if all frames
  /// between the two are bodies of the robot. Otherwise frames may be far from each other, and the chains merge frames
  /// at rest.
  double chainRounding() const { return kPoseRounding * path_length_; }

  /// [m] An upper bound of the effect of the rounding of poses on a distance at one time, which includes poses in the
  /// world.
  double roundingAt(double time, PosesInTime& poses) const;

  /// `motion`: an upper bound [m] of how far a point of one body moves during an interval, seen from the other body,
  /// from its place in the middle of the interval. `rounding` [m]: the rounding of a distance.
  struct Drift {
    double motion, rounding;
  };
  Drift driftIn(const Interval& interval, PosesInTime& poses);

  /// [m] A lower bound like sphereGap(), for boxes: the gap in the middle of the interval, minus how far a
  /// point can move from there.
  double boxGap(const Bounds& a, const Bounds& b, const Interval& interval, PosesInTime& poses);

 private:
  /// The motion of both bodies during an interval; it is the same for all of their parts.
  struct IntervalMotion {
    Eigen::Isometry3d a_begin, b_begin, a_middle, b_middle, a_end, b_end;
    double bulge;     ///< [m] how far a point of b, seen from a point of a, leaves the chord from its begin to its end
    double drift;     ///< [m] how far it moves from its place in the middle of the interval
    double rounding;  ///< [m] of a distance
  };

  const IntervalMotion& motionIn(const Interval& interval, PosesInTime& poses);

  int body_a_ = -1, body_b_ = -1;
  bool is_known_ = false;
  int middle_ = -1;
  narrowphase::MotionChain chain_a_, chain_b_;  ///< screws at rest are merged
  Bounds a_, b_;
  /// [m] The sum of the distances from frame to frame; 0 if all of these are bodies of the robot.
  double path_length_ = 0.0;
  double length_ = 0.0;  ///< [m] of the chains and the path together; the poses of all of them are rounded
  struct KnownInterval {
    int number;
    IntervalMotion motion;
  };
  std::vector<KnownInterval> intervals_;
};

}  // namespace proximity_server::scene
