#include "benchmark/echo_times.h"

#include "node/patience.h"

#include <ros/init.h>

#include <stdexcept>
#include <thread>

namespace proximity_server::benchmark {
namespace {

const char* const kTopic = "/bare_echo/message";
const char* const kEcho = "/bare_echo/echo";
constexpr std::uint32_t kQueueSize = 1000;
constexpr std::chrono::milliseconds kPause{7};  // as between two changed objects

}  // namespace

void serveEcho() {
  ros::NodeHandle nh;
  const ros::Publisher publisher = nh.advertise<std_msgs::UInt32>(kEcho, kQueueSize);
  const ros::Subscriber subscriber = nh.subscribe<std_msgs::UInt32>(
      kTopic, kQueueSize, [&](const std_msgs::UInt32::ConstPtr& message) { publisher.publish(message); },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  ros::spin();
}

EchoTimes::EchoTimes(ros::NodeHandle nh)
    : publisher_(nh.advertise<std_msgs::UInt32>(kTopic, kQueueSize)),
      subscriber_(nh.subscribe(kEcho, kQueueSize, &EchoTimes::onEcho, this, ros::TransportHints().tcpNoDelay())) {
  const bool connected = node::holdsWithin(
      node::kPatience, [&] { return publisher_.getNumSubscribers() > 0 && subscriber_.getNumPublishers() > 0; });
  if (!connected) throw std::runtime_error("the echo does not listen");
}

void EchoTimes::onEcho(const std_msgs::UInt32& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  last_ = message.data;
  last_arrival_ = Clock::now();
  arrived_.notify_all();
}

std::vector<double> EchoTimes::measure(double seconds) {
  std::vector<double> times;
  std_msgs::UInt32 message;
  for (const Clock::time_point start = Clock::now(); Clock::now() - start < std::chrono::duration<double>(seconds);) {
    ++message.data;
    const Clock::time_point sent = Clock::now();
    publisher_.publish(message);
    std::unique_lock<std::mutex> lock(mutex_);
    if (!arrived_.wait_for(lock, node::kPatience, [&] { return last_ == message.data; }))
      throw std::runtime_error("a message has no echo");
    times.push_back(std::chrono::duration<double>(last_arrival_ - sent).count());
    lock.unlock();
    std::this_thread::sleep_for(kPause);
  }
  return times;
}

}  // namespace proximity_server::benchmark
