#pragma once

#include <proximity_server/Clearance.h>
#include "node/soak/answer_checks.h"
#include "node/soak/soak_objects.h"
#include "node/soak/soak_record.h"

#include <ros/node_handle.h>

#include <condition_variable>
#include <mutex>

namespace proximity_server::node {

using namespace scene;

/// Listens to ~clearance and checks every message: INVALID, or right and not stale.
class SoakMonitor {
 public:
  struct Settings {
    double max_tf_age;  ///< [s] of the node
    AnswerChecks::Levels levels;
  };
  /// Everything must outlive this.
  SoakMonitor(ros::NodeHandle nh, const std::shared_ptr<const SceneModel>& model, SoakRecord& record,
              const Settings& settings);

  /// From now on the node may have these objects, until nullptr is given.
  void follow(const SoakObjects* objects);

  /// Waits for a cycle that is right about poses of after `moment`; false where there is none within `patience` [s].
  bool awaitRightAnswer(const ros::Time& moment, double patience);

 private:
  void onClearance(const Clearance& message);
  bool takeObjectsOf(const Clearance& message);
  Verdict verdict(const Clearance& message);

  SoakRecord& record_;
  const Settings settings_;
  AnswerChecks checks_;
  mutable std::mutex mutex_;  // guards all that follows
  std::condition_variable arrived_;
  const SoakObjects* objects_ = nullptr;
  ros::Time last_right_;  ///< stamp of the last right answer
  ros::Subscriber subscriber_;
};

}  // namespace proximity_server::node
