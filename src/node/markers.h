#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <string>
#include <vector>

#include "config.h"
#include "proximity_server/Clearance.h"
#include "robot.h"

namespace proximity_server {

/// The pieces that stand for the robot, each fixed in the frame of its link, see tfFrame(). Paddings are not drawn.
visualization_msgs::MarkerArray pieceMarkers(const RobotModel& robot, const std::string& tf_prefix);

/// A line between the closest points of every listed pair and a label with its distance, coloured by the level that
/// this distance alone would mean. Labels beyond those of this clearance are taken away, as many as `labels_before`.
visualization_msgs::MarkerArray witnessMarkers(const Clearance& clearance, const MonitorSettings& settings,
                                               std::size_t labels_before);

/// Takes away all that was drawn.
visualization_msgs::MarkerArray noMarkers();

}  // namespace proximity_server
