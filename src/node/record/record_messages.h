#pragma once

#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/Clearance.h"
#include "proximity_server/Record.h"

#include <dynamic_reconfigure/Config.h>
#include <sensor_msgs/JointState.h>
#include <tf2_msgs/TFMessage.h>

#include <string>
#include <vector>

// The messages of a record, and how a replay reads them.

namespace proximity_server::node {

/// The topics of a record of the node with this name, "/proximity_server".
struct RecordTopics {
  explicit RecordTopics(const std::string& node)
      : clearance(node + "/clearance"),
        robot(node + "/record/robot"),
        settings(node + "/record/settings"),
        objects(node + "/record/objects"),
        poses(node + "/record/poses") {}
  std::string clearance;                 ///< Clearance, as it was published; the last message of each cycle
  std::string robot;                     ///< Record: when another robot is monitored
  std::string settings;                  ///< dynamic_reconfigure/Config: the live parameters, when they change
  std::string objects;                   ///< std_msgs/String: all objects and rules as YAML, when they change
  std::string poses;                     ///< tf2_msgs/TFMessage of each cycle: all poses that the answer is about
  std::string joints = "/joint_states";  ///< sensor_msgs/JointState of each cycle, from these poses
};

/// One cycle of the monitor: its input and its answer.
struct RecordedCycle {
  ros::Time time;  ///< of the cycle
  MonitorSettings settings;
  scene::BodyPoses poses;
  scene::FramePoses frames;  ///< of Objects::frames()
  Clearance clearance;
};

Record recordOf(const Robot& robot, const std::string& event, const ros::Time& stamp);

/// The known poses of bodies, by the frames of their links, and of frames; all in the reference frame.
tf2_msgs::TFMessage posesOf(const Robot& robot, const std::vector<std::string>& frames, const RecordedCycle& cycle);

/// The inverse of posesOf().
void placePoses(const tf2_msgs::TFMessage& message, const Robot& robot, const std::vector<std::string>& frames,
                RecordedCycle& cycle);

/// The positions [rad] or [m] of the joints that have one and that the poses tell. The velocities [rad/s] or [m/s] are
/// the way since `before`, divided by the time since then; there are none if `before` has other joints or is too old.
sensor_msgs::JointState jointsOf(const Robot& robot, const RecordedCycle& cycle, const sensor_msgs::JointState& before);

/// The inverse of monitorSettingsFrom().
dynamic_reconfigure::Config toMessage(const MonitorSettings& settings);

}  // namespace proximity_server::node
