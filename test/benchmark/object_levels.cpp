#include "benchmark/object_levels.h"

#include "node/load/node_under_load.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string>

namespace proximity_server::benchmark {
namespace {

constexpr double kFar = 100.0;  // [m] from the robot, which is smaller
constexpr int kOthers = 100;    // balls of the stream, all of them farther away
constexpr std::chrono::seconds kPatience{20};
constexpr std::chrono::milliseconds kPause{7};  // between two messages, so that they fall on all phases of a cycle

ObjectChange ballAt(const std::string& id, double x) {
  ObjectChange change;
  change.operation = ObjectChange::REPLACE;
  change.id = id;
  change.primitives.resize(1);
  change.primitives[0].type = shape_msgs::SolidPrimitive::SPHERE;
  change.primitives[0].dimensions = {0.5};
  change.pose.position.x = x;
  return change;
}

ObjectChanges messageOf(const ObjectChange& change) {
  ObjectChanges message;
  message.changes = {change};
  return message;
}

}  // namespace

ObjectLevels::ObjectLevels(ros::NodeHandle nh)
    : publisher_(nh.advertise<ObjectChanges>(node::kNodeName + "/apply_objects", 10000)),
      subscriber_(nh.subscribe(node::kNodeName + "/clearance", 1000, &ObjectLevels::onClearance, this,
                               ros::TransportHints().tcpNoDelay())) {
  for (const Clock::time_point start = Clock::now();
       publisher_.getNumSubscribers() == 0 || subscriber_.getNumPublishers() == 0;) {
    if (Clock::now() - start > kPatience) throw std::runtime_error("the node does not listen to changes of objects");
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

ObjectLevels::~ObjectLevels() {
  ObjectChange remove;
  remove.operation = ObjectChange::REMOVE;
  remove.id = "*";
  publisher_.publish(messageOf(remove));
}

void ObjectLevels::onClearance(const Clearance& clearance) {
  const double distance = clearance.object_minimum.distance;
  if (std::isnan(distance)) return;  // there is no object
  const Place place = distance > 0.5 * kFar ? Place::FarAway : Place::InTheRobot;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (place_ == place) return;
  place_ = place;
  placed_ = Clock::now();
  arrived_.notify_all();
}

double ObjectLevels::timeToLevelAt(Place place) {
  const ObjectChanges message = messageOf(ballAt("ball", place == Place::InTheRobot ? 0.0 : kFar));
  const Clock::time_point start = Clock::now();
  publisher_.publish(message);
  std::unique_lock<std::mutex> lock(mutex_);
  if (!arrived_.wait_for(lock, kPatience, [&] { return place_ == place; }))
    throw std::runtime_error("a changed object has no level");
  return std::chrono::duration<double>(placed_ - start).count();
}

std::vector<double> ObjectLevels::measure(double seconds, double stream) {
  std::atomic<bool> ends{false};
  std::thread others;
  if (stream > 0.0) {
    others = std::thread([&] {
      ros::WallRate rate(stream);
      for (int i = 0; !ends; ++i) {
        publisher_.publish(messageOf(ballAt("other " + std::to_string(i % kOthers), 2.0 * kFar + 0.001 * (i % 1000))));
        rate.sleep();
      }
    });
  }
  std::vector<double> times;
  try {
    for (const Clock::time_point start = Clock::now(); Clock::now() - start < std::chrono::duration<double>(seconds);) {
      times.push_back(timeToLevelAt(Place::InTheRobot));
      std::this_thread::sleep_for(kPause);
      times.push_back(timeToLevelAt(Place::FarAway));
      std::this_thread::sleep_for(kPause);
    }
  } catch (...) {
    ends = true;
    if (others.joinable()) others.join();
    throw;
  }
  ends = true;
  if (others.joinable()) others.join();
  return times;
}

}  // namespace proximity_server::benchmark
