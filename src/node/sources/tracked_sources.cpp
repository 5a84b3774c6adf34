#include "node/sources/tracked_sources.h"

#include "node/objects/change_frames.h"
#include "node/sources/cloud_colours.h"
#include "node/sources/octomap_message.h"
#include "node/sources/tracked_points.h"
#include "node/threads/request_queue.h"
#include "proximity_server/scene/sensed/octree.h"
#include "system/number_text.h"

#include <ros/console.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

namespace proximity_server::node {
namespace {

void warn(const TrackedSource& source, const std::string& reason) {
  ROS_WARN_STREAM_THROTTLE(
      1.0, system::readable(source.text() + ": a message on '" + source.topic + "' is left out: " + reason));
}

}  // namespace

TrackedSources::TrackedSources(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh, TfPoses& tf,
                               ObjectStore& store, TrackedAges& ages)
    : nh_(nh),
      tf_(tf),
      store_(store),
      ages_(ages),
      points_pub_(ros::NodeHandle(private_nh).advertise<sensor_msgs::PointCloud2>("sensed_points", 1)) {}

void TrackedSources::follow(const Robot& robot) {
  const std::vector<TrackedSource>& tracked = robot.config().tracked;
  const auto is_of = [](const auto& subscription, const TrackedSource& source) {
    return subscription->source == source;
  };
  if (std::equal(subscriptions_.begin(), subscriptions_.end(), tracked.begin(), tracked.end(), is_of)) {
    for (const std::unique_ptr<Subscription>& subscription : subscriptions_)  // a map that is latched comes once more
      if (subscription->source.isMap()) subscribe<OctomapMessage>(*subscription);
    return;
  }
  subscriptions_.clear();
  for (const TrackedSource& source : tracked) {
    Subscription& subscription = *subscriptions_.emplace_back(std::make_unique<Subscription>());
    subscription.source = source;
    if (source.sensing && !source.isMap()) subscription.boxes.emplace(*source.sensing);
    if (source.type == TrackedSource::Type::PoseArray)
      subscribe<geometry_msgs::PoseArray>(subscription);
    else if (source.type == TrackedSource::Type::PointCloud2)
      subscribe<sensor_msgs::PointCloud2>(subscription);
    else
      subscribe<OctomapMessage>(subscription);
    subscription.spinner.start();
  }
}

template <class Message>
void TrackedSources::subscribe(Subscription& subscription) {
  subscription.subscriber =
      withQueue(nh_, subscription.queue)
          .subscribe<Message>(
              subscription.source.topic, 1,
              [this, &subscription](const boost::shared_ptr<const Message>& message) { take(subscription, *message); },
              {}, ros::TransportHints().tcpNoDelay());
}

template <class Message>
void TrackedSources::take(Subscription& subscription, const Message& message) {
  const TrackedSource& source = subscription.source;
  const std::string refusal = ages_.refusalOf(source.name, message.header.stamp, ros::Time::now());
  if (!refusal.empty()) return warn(source, refusal);
  try {
    if constexpr (std::is_same_v<Message, OctomapMessage>) {
      placeMap(source, message);
    } else {
      if constexpr (std::is_same_v<Message, sensor_msgs::PointCloud2>)
        if (subscription.boxes) return placeCloud(subscription, message);
      place(source, message.header, pointsOf(message));
    }
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
    const Eigen::Isometry3d pose = poseOf(*robot, source, header);
    for (Eigen::Vector3d& point : points) point = pose * point;
  }
  store_.track(robot, source, ballsAround(points, source.radius), [&] { ages_.accept(source.name, header.stamp); });
}

/// The pose of the frame of a message in the reference frame, at its time.
Eigen::Isometry3d TrackedSources::poseOf(const Robot& robot, const TrackedSource& source,
                                         const std_msgs::Header& header) {
  ChangeFrames frames(robot, frameFinder(tf_, header.stamp, source.max_age));
  return frames.seenFrom(robot.referenceFrame(), frames.named(header.frame_id), Eigen::Isometry3d::Identity());
}

/// Gives the boxes of a cloud to the store, without the points of the robot where it was at the time of the cloud.
void TrackedSources::placeCloud(Subscription& subscription, const sensor_msgs::PointCloud2& message) {
  const TrackedSource& source = subscription.source;
  const ObjectStore::CurrentObjects now = store_.current();
  const std::shared_ptr<const Robot>& robot = now.robot;
  std::vector<Eigen::Vector3d> points = returnsOf(message);
  CloudBoxes::Moment at;
  at.time = message.header.stamp.toSec();
  if (!points.empty()) {
    at.sensor = poseOf(*robot, source, message.header);
    PoseSnapshot where = tf_.await(*robot, CloudBoxes::bodiesOf(*robot), message.header.stamp, source.max_age);
    if (where.status.code != QueryStatus::OK) throw ChangeError(where.status.code, where.status.message);
    at.poses = std::move(where.poses);
  }
  SensedCloud cloud;
  SeenShapes seen;
  seen.shapes = subscription.boxes->make(robot, *now.objects.all, at, points, cloud);
  store_.track(robot, source, std::move(seen), [&] { ages_.accept(source.name, message.header.stamp, cloud); });
  publish(robot, source.name, message.header, at, points);
}

/// Gives the occupied space of a map to the store. It stands in its frame, wherever that moves.
void TrackedSources::placeMap(const TrackedSource& source, const OctomapMessage& message) {
  if (message.header.frame_id.empty()) throw std::invalid_argument("its frame_id is empty");
  SensedCloud cloud;
  const auto begin = std::chrono::steady_clock::now();
  scene::Boxes map{scene::occupiedBoxes({message.id, message.is_binary != 0, message.resolution, message.data})};
  cloud.boxes = map.boxes.size();
  SeenShapes seen;
  seen.frame = message.header.frame_id;
  if (!map.boxes.empty()) seen.shapes.push_back({std::move(map)});
  cloud.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  store_.track(store_.current().robot, source, std::move(seen),
               [&] { ages_.accept(source.name, message.header.stamp, cloud); });
}

/// Publishes the points [m] of a source that is in the store, with their colours, in the frame of the sensor, which is
/// where rays to them begin. Given are points in the reference frame.
void TrackedSources::publish(const std::shared_ptr<const Robot>& robot, const std::string& source,
                             const std_msgs::Header& header, const CloudBoxes::Moment& at,
                             const std::vector<Eigen::Vector3d>& points) {
  if (points_pub_.getNumSubscribers() == 0) return;
  const ObjectStore::CurrentObjects now = store_.current();
  if (now.robot != robot) return;  // a reload
  const std::vector<std::uint32_t> colours = coloursOf(*robot, now.objects.all, source, at.poses, points);
  const Eigen::Isometry3d sensor_T_reference = at.sensor.inverse();
  sensor_msgs::PointCloud2 cloud;
  cloud.header.stamp = header.stamp;
  cloud.header.frame_id = header.frame_id;
  sensor_msgs::PointCloud2Modifier modifier(cloud);
  modifier.setPointCloud2FieldsByString(2, "xyz", "rgb");
  modifier.resize(points.size());
  if (!points.empty()) {  // an iterator needs a first byte
    sensor_msgs::PointCloud2Iterator<float> out(cloud, "x");
    sensor_msgs::PointCloud2Iterator<std::uint32_t> colour(cloud, "rgb");
    for (std::size_t i = 0; i < points.size(); ++i, ++out, ++colour) {
      const Eigen::Vector3d point = sensor_T_reference * points[i];
      for (int axis = 0; axis < 3; ++axis) out[axis] = static_cast<float>(point[axis]);
      *colour = colours[i];
    }
  }
  points_pub_.publish(cloud);
}

}  // namespace proximity_server::node
