#include "node/soak/soak_monitor.h"

#include "node/load/node_under_load.h"

#include <chrono>

namespace proximity_server::node {

using namespace scene;
namespace {

const std::string kTopic = "clearance";

/// [s] that a message may take from the node to us on a machine that is full of work.
constexpr double kWay = 2.0;

}  // namespace

SoakMonitor::SoakMonitor(ros::NodeHandle nh, const std::shared_ptr<const SceneModel>& model, SoakRecord& record,
                         const Settings& settings)
    : record_(record), settings_(settings), checks_(model) {
  subscriber_ =
      nh.subscribe(kNodeName + "/clearance", 1000, &SoakMonitor::onClearance, this, ros::TransportHints().tcpNoDelay());
}

bool SoakMonitor::awaitRightAnswer(const ros::Time& moment, double patience) {
  std::unique_lock<std::mutex> lock(mutex_);
  return arrived_.wait_for(lock, std::chrono::duration<double>(patience), [&] { return last_right_ >= moment; });
}

void SoakMonitor::follow(const SoakObjects* objects) {
  const std::lock_guard<std::mutex> lock(mutex_);
  objects_ = objects;
}

/// Whether it is known which objects it is about.
bool SoakMonitor::takeObjectsOf(const Clearance& message) {
  if (!objects_) return message.objects_revision == 0;
  const SoakObjects::Set objects = objects_->ofRevision(message.objects_revision);
  if (objects) checks_.use(objects);
  return objects != nullptr;
}

Verdict SoakMonitor::verdict(const Clearance& message) {
  const double age = message.tf_age.toSec(), now_age = (ros::Time::now() - message.header.stamp).toSec();
  if (age > settings_.max_tf_age) return "its transforms were " + std::to_string(age) + " s old";
  if (now_age > settings_.max_tf_age + kWay) return "it came " + std::to_string(now_age) + " s after its transforms";
  return checks_.check(message, settings_.levels);
}

void SoakMonitor::onClearance(const Clearance& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (message.level == Clearance::INVALID) return record_.count(kTopic, SoakRecord::Outcome::Refused);
  if (record_.isMisled(message.header.stamp)) return record_.count(kTopic, SoakRecord::Outcome::Misled);
  if (!takeObjectsOf(message)) return record_.count(kTopic, SoakRecord::Outcome::Lost);
  const Verdict wrong = verdict(message);
  if (!wrong.empty()) {
    return record_.countWrong(kTopic, "at " + std::to_string(message.header.stamp.toSec()) + ": " + wrong);
  }
  record_.count(kTopic, SoakRecord::Outcome::Right);
  last_right_ = message.header.stamp;
  arrived_.notify_all();
}

}  // namespace proximity_server::node
