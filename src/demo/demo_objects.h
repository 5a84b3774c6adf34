#pragma once

#include <proximity_server/ObjectChanges.h>
#include <proximity_server/ObjectList.h>
#include <ros/ros.h>

#include <cstdint>
#include <string>
#include <vector>

namespace proximity_server::demo {

/// What stands around the robot of the demo, and the bar that it carries: gives them to the node, also after each start of it.
///
/// Others:     What others remove stays away until the motion begins anew, which puts back what is missing; a bar that is not there is
///             not carried meanwhile.
/// Parameters: see config/demo/objects.yaml; std::invalid_argument names the one that is missing.
/// Failure:    what the node refuses is logged as a warning, and tried again.
class DemoObjects {
 public:
  DemoObjects(ros::NodeHandle& nh, const ros::NodeHandle& private_nh);

  /// Sends what the node does not know yet at this time [s] of the motion.
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
  ObjectChange bar_;  ///< as it stands on its place
  std::vector<PairRule> rules_;
  ObjectChange grip_;              ///< attaches the bar to the hand
  double held_from_, held_until_;  ///< [s] of the motion

  std::uint64_t node_start_ = 0;  ///< the latest start of the node that is known; 0: none
  std::uint64_t known_to_ = 0;    ///< the start of the node that everything was sent to
  std::uint64_t revision_ = 0;    ///< of the objects after our latest change
  double time_ = 0.0;             ///< [s] of the motion, at the latest update
  ObjectList::ConstPtr present_;  ///< the latest list
  ros::ServiceClient apply_;
  ros::Subscriber objects_;
};

}  // namespace proximity_server::demo
