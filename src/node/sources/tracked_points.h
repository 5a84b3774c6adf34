#pragma once

#include "node/objects/object_store.h"

#include <geometry_msgs/PoseArray.h>
#include <sensor_msgs/PointCloud2.h>
#include <Eigen/Geometry>

#include <cstddef>
#include <vector>

// The points of the messages of tracked sources [m], in the frame of the message.
//
// Failure: throws std::invalid_argument with the reason: more than kMostTrackedPoints, or a coordinate that is not
//          finite. In a cloud a point with a NaN is no return of the sensor, and is left out.

namespace proximity_server::node {

/// A ball around each point [m].
SeenShapes ballsAround(const std::vector<Eigen::Vector3d>& points, double radius);

constexpr std::size_t kMostTrackedPoints = 1000;

std::vector<Eigen::Vector3d> pointsOf(const geometry_msgs::PoseArray& message);

/// Reads a cloud of any layout with x, y and z as FLOAT32 or FLOAT64.
/// Failure: as above, and if the sizes that the message states do not fit each other or its data.
std::vector<Eigen::Vector3d> pointsOf(const sensor_msgs::PointCloud2& message);

/// All points of a cloud that are finite, however many. REP 117 has other numbers where a sensor sees nothing.
/// Failure: as above, if sizes do not fit.
std::vector<Eigen::Vector3d> returnsOf(const sensor_msgs::PointCloud2& message);

}  // namespace proximity_server::node
