#pragma once

#include <proximity_server/ObjectChanges.h>
#include <proximity_server/ObjectList.h>

#include <ros/ros.h>

#include <cstdint>
#include <string>
#include <vector>

namespace proximity_server::demo {

/// Gives the node the objects around the robot of the demo, and the bar that the robot carries; also after a restart of
/// the node. If somebody removes an object, it comes back when the motion begins anew. A bar that was removed is not
/// carried until then.
///
/// Parameters: see config/demo/objects.yaml. The constructor throws std::invalid_argument naming a parameter that is
///             missing.
/// Failure:    if the node refuses changes, a warning is logged, and they are tried again.
class DemoObjects {
 public:
  DemoObjects(ros::NodeHandle& nh, const ros::NodeHandle& private_nh);

  /// Sends the changes that are due at this time [s] of the motion and that the node does not have yet.
  void update(double time);

 private:
  void onObjects(const ObjectList::ConstPtr& list);
  const ObjectInfo* find(const std::string& id) const;
  bool isAnyMissing() const;
  void sendAll();
  void pickUp();
  void putDown();
  bool apply(const ObjectChanges& changes);

  std::vector<ObjectChange> boxes_;
  ObjectChange bar_;  ///< puts the bar on its place
  std::vector<PairRule> rules_;
  ObjectChange attach_bar_;        ///< attaches the bar to the hand
  double held_from_, held_until_;  ///< [s] times of the motion between which the robot holds the bar

  std::uint64_t node_start_ = 0;      ///< the latest start of the node that is known; 0: none
  std::uint64_t sent_to_ = 0;         ///< the start of the node that everything was sent to
  std::uint64_t revision_ = 0;        ///< revision of the objects after our latest change
  double time_ = 0.0;                 ///< [s] time of the motion at the latest update
  ObjectList::ConstPtr latest_list_;  ///< the latest list
  ros::ServiceClient apply_;
  ros::Subscriber objects_;
};

}  // namespace proximity_server::demo
