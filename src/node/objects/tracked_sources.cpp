#include "node/objects/tracked_sources.h"

#include "node/objects/change_frames.h"
#include "node/objects/tracked_points.h"
#include "node/threads/request_queue.h"
#include "system/number_text.h"

#include <ros/console.h>

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::node {
namespace {

void warn(const TrackedSource& source, const std::string& reason) {
  ROS_WARN_STREAM_THROTTLE(1.0, system::readable("tracked source '" + source.name + "': a message on '" + source.topic +
                                                 "' is left out: " + reason));
}

}  // namespace

void TrackedSources::follow(const Robot& robot) {
  const std::vector<TrackedSource>& tracked = robot.config().tracked;
  const auto is_of = [](const auto& subscription, const TrackedSource& source) {
    return subscription->source == source;
  };
  if (std::equal(subscriptions_.begin(), subscriptions_.end(), tracked.begin(), tracked.end(), is_of)) return;
  subscriptions_.clear();
  for (const TrackedSource& source : tracked) {
    Subscription& subscription = *subscriptions_.emplace_back(std::make_unique<Subscription>());
    subscription.source = source;
    if (source.type == TrackedSource::Type::PoseArray)
      subscribe<geometry_msgs::PoseArray>(subscription);
    else
      subscribe<sensor_msgs::PointCloud2>(subscription);
    subscription.spinner.start();
  }
}

template <class Message>
void TrackedSources::subscribe(Subscription& subscription) {
  subscription.subscriber = withQueue(nh_, subscription.queue)
                                .subscribe<Message>(
                                    subscription.source.topic, 1,
                                    [this, &source = subscription.source](
                                        const boost::shared_ptr<const Message>& message) { take(source, *message); },
                                    {}, ros::TransportHints().tcpNoDelay());
}

template <class Message>
void TrackedSources::take(const TrackedSource& source, const Message& message) {
  const std::string refusal = ages_.refusalOf(source.name, message.header.stamp, ros::Time::now());
  if (!refusal.empty()) return warn(source, refusal);
  try {
    place(source, message.header, pointsOf(message));
  } catch (const ChangeError& error) {  // a frame is not known; the message before it counts until it is too old
    ages_.refuse(source.name, error.what(), /*is_stale=*/false);
    warn(source, error.what());
  } catch (const std::exception& error) {
    ages_.refuse(source.name, error.what(), /*is_stale=*/true);
    warn(source, error.what());
  }
}

/// Gives the points, which are in the frame of the header, to the store.
void TrackedSources::place(const TrackedSource& source, const std_msgs::Header& header,
                           std::vector<Eigen::Vector3d> points) {
  const std::shared_ptr<const Robot> robot = store_.current().robot;
  if (!points.empty()) {
    ChangeFrames frames(*robot, frameFinder(tf_, header.stamp, source.max_age));
    const Eigen::Isometry3d pose =
        frames.seenFrom(robot->referenceFrame(), frames.named(header.frame_id), Eigen::Isometry3d::Identity());
    for (Eigen::Vector3d& point : points) point = pose * point;
  }
  store_.track(robot, source, points, [&] { ages_.accept(source.name, header.stamp); });
}

}  // namespace proximity_server::node
