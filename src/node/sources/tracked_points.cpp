#include "node/sources/tracked_points.h"

#include "proximity_server/scene/sensed/point_record.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace proximity_server::node {
namespace {

using scene::PointRecord;
using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

/// Adds a point. The index in the message is for the text.
void add(const Eigen::Vector3d& point, std::uint64_t index, std::vector<Eigen::Vector3d>& points) {
  if (!point.allFinite()) throw std::invalid_argument("point " + std::to_string(index) + " is not finite");
  if (points.size() == kMostTrackedPoints)
    throw std::invalid_argument("it has more than " + std::to_string(kMostTrackedPoints) + " points");
  points.push_back(point);
}

PointRecord::Field coordinateOf(const PointCloud2& cloud, const std::string& name) {
  const auto is_it = [&](const PointField& field) { return field.name == name; };
  const auto found = std::find_if(cloud.fields.begin(), cloud.fields.end(), is_it);
  if (found == cloud.fields.end()) throw std::invalid_argument("it has no field " + name);
  if (found->datatype != PointField::FLOAT32 && found->datatype != PointField::FLOAT64)
    throw std::invalid_argument("its field " + name + " is neither FLOAT32 nor FLOAT64");
  const PointRecord::Field coordinate{found->offset, PointRecord::Type::Float,
                                      found->datatype == PointField::FLOAT32 ? 4U : 8U};
  if (coordinate.offset + coordinate.size > cloud.point_step)
    throw std::invalid_argument("its field " + name + " ends beyond point_step");
  return coordinate;
}

/// Calls visit(point, index) for the points of a cloud.
template <class Visit>
void forEachPoint(const PointCloud2& message, const Visit& visit) {
  const std::uint64_t width = message.width, height = message.height, step = message.point_step,
                      row_step = message.row_step;  // products of 32 bits fit into 64
  if (width * height == 0) return;
  const PointRecord record{{coordinateOf(message, "x"), coordinateOf(message, "y"), coordinateOf(message, "z")},
                           message.is_bigendian != 0};
  if (width * step > row_step) throw std::invalid_argument("width times point_step is more than row_step");
  if (row_step * height > message.data.size())
    throw std::invalid_argument("row_step times height is more than its data");
  for (std::uint64_t i = 0; i < width * height; ++i)
    visit(record.at(message.data.data() + (i / width) * row_step + (i % width) * step), i);
}

}  // namespace

SeenShapes ballsAround(const std::vector<Eigen::Vector3d>& points, double radius) {
  SeenShapes balls;
  for (const Eigen::Vector3d& point : points) balls.place.translation() += point / static_cast<double>(points.size());
  for (const Eigen::Vector3d& point : points)
    balls.shapes.push_back({narrowphase::Shape(narrowphase::Sphere{radius}),
                            Eigen::Isometry3d(Eigen::Translation3d(point - balls.place.translation()))});
  return balls;
}

std::vector<Eigen::Vector3d> pointsOf(const geometry_msgs::PoseArray& message) {
  std::vector<Eigen::Vector3d> points;
  for (const geometry_msgs::Pose& pose : message.poses)
    add({pose.position.x, pose.position.y, pose.position.z}, points.size(), points);
  return points;
}

std::vector<Eigen::Vector3d> pointsOf(const PointCloud2& message) {
  std::vector<Eigen::Vector3d> points;
  forEachPoint(message, [&](const Eigen::Vector3d& point, std::uint64_t index) {
    if (!point.hasNaN()) add(point, index, points);
  });
  return points;
}

std::vector<Eigen::Vector3d> returnsOf(const PointCloud2& message) {
  std::vector<Eigen::Vector3d> points;
  forEachPoint(message, [&](const Eigen::Vector3d& point, std::uint64_t) {
    if (point.allFinite()) points.push_back(point);
  });
  return points;
}

}  // namespace proximity_server::node
