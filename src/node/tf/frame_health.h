#pragma once

#include "node/robot/robot.h"

#include <ros/time.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <cstdint>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

namespace proximity_server::node {

/// Keeps when each frame arrived on /tf, and from whom. It tells why a transform is too old, and warns of frames that
/// have two parents or publishers, or that come too rarely. Times of arrival are in ROS time. Thread-safe.
///
/// The age of the latest transform of a frame is the sum of three times. The longest of them names the kind of fault:
///
/// 1. silence: the time since the latest message;
/// 2. a stamp that stands still: the time from the first to the latest message with its stamp;
/// 3. delay: the age of the stamp when the first message with it came.
class FrameHealth {
 public:
  /// Adds a message of /tf from the node `publisher`. Allocates memory only for a frame, a parent or a publisher that is
  /// new.
  void add(const tf2_msgs::TFMessage& message, const std::string& publisher, const ros::Time& now);

  /// Forgets all frames, because the clock jumped back.
  void forget();

  /// The frame between the ends of an edge that has the oldest transform, with the kind of fault: "no message of frame
  /// 'odom' has come for 3 s". Returns "" if /tf does not have the frame.
  std::string causeOf(const tf2::BufferCore& buffer, const TfEdge& edge, const ros::Time& now) const;

  /// A sentence for each kind of fault of the frames between the ends of these edges, which are indices into
  /// Robot::tfEdges(): two parents, two publishers, and a rate below `rate` [Hz], measured by the stamps since the
  /// previous call. If `rate` is 0, no rate is too low.
  std::vector<std::string> warnings(const tf2::BufferCore& buffer, const Robot& robot, const std::vector<int>& edges,
                                    double rate, const ros::Time& now);

 private:
  using Nanoseconds = std::int64_t;

  /// A parent or a publisher.
  struct Source {
    std::string name;
    Nanoseconds first, last;  // arrivals, without a long pause between them
  };
  struct Frame {
    Nanoseconds stamp;         // of the latest message
    Nanoseconds arrived;       // the latest message
    Nanoseconds moved;         // the first message with this stamp
    Nanoseconds counted_from;  // the stamp where `count` began
    int count;                 // of new stamps
    std::vector<Source> parents, publishers;
  };

  static void note(const std::string& name, Nanoseconds now, std::vector<Source>& sources);
  static std::string twoOf(const std::vector<Source>& sources, Nanoseconds now);
  static double takeRate(Frame& frame);

  mutable std::mutex mutex_;
  std::unordered_map<std::string, Frame> frames_;  // by child frame
};

}  // namespace proximity_server::node
