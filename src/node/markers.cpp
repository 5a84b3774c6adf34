#include "markers.h"

#include <cstdio>
#include <utility>

#include "clearance_level.h"
#include "tf_frames.h"

namespace proximity_server {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

std_msgs::ColorRGBA colour(float r, float g, float b, float a) {
  std_msgs::ColorRGBA result;
  result.r = r;
  result.g = g;
  result.b = b;
  result.a = a;
  return result;
}

std_msgs::ColorRGBA levelColour(std::uint8_t level) {
  switch (level) {
    case Clearance::CLEAR:
      return colour(0.2f, 0.8f, 0.2f, 1.0f);
    case Clearance::WARN:
      return colour(1.0f, 0.8f, 0.0f, 1.0f);
    case Clearance::STOP:
      return colour(1.0f, 0.4f, 0.0f, 1.0f);
    default:
      return colour(1.0f, 0.0f, 0.0f, 1.0f);
  }
}

geometry_msgs::Point point(const Eigen::Vector3d& vector) {
  geometry_msgs::Point result;
  result.x = vector.x();
  result.y = vector.y();
  result.z = vector.z();
  return result;
}

void setPose(Marker& marker, const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond rotation(pose.linear());
  marker.pose.position = point(pose.translation());
  marker.pose.orientation.w = rotation.w();
  marker.pose.orientation.x = rotation.x();
  marker.pose.orientation.y = rotation.y();
  marker.pose.orientation.z = rotation.z();
}

void setSize(Marker& marker, const Eigen::Vector3d& size) {
  marker.scale.x = size.x();
  marker.scale.y = size.y();
  marker.scale.z = size.z();
}

/// Draws the parts of one piece into an array.
class PieceDrawing {
 public:
  PieceDrawing(const RobotModel& robot, const std::string& tf_prefix, const Piece& piece, MarkerArray& array)
      : shape_(piece.shape), array_(array) {
    const Collision& collision = robot.collisions[static_cast<std::size_t>(piece.collision)];
    const Link& link = robot.links[static_cast<std::size_t>(collision.link)];
    link_T_piece_ = link.body_T_link.inverse() * piece.body_T_piece;
    base_.header.frame_id = tfFrame(tf_prefix, link.name);
    base_.ns = "pieces";
    base_.frame_locked = true;
    base_.color = colour(0.3f, 0.5f, 0.9f, 0.35f);
  }

  void draw() {
    const Eigen::Vector3d size = 2.0 * shape_.halfExtents();
    const Eigen::Vector3d ball = Eigen::Vector3d::Constant(2.0 * shape_.margin());
    switch (shape_.kind()) {
      case Shape::Kind::Point:
        return add(Marker::SPHERE, ball);
      case Shape::Kind::Segment:
        add(Marker::CYLINDER, {ball.x(), ball.y(), size.z()});
        add(Marker::SPHERE, ball, 0.5 * size.z());
        return add(Marker::SPHERE, ball, -0.5 * size.z());
      case Shape::Kind::Box:
        return add(Marker::CUBE, size);
      case Shape::Kind::Cylinder:
        return add(Marker::CYLINDER, size);
      case Shape::Kind::Ellipsoid:
        return add(Marker::SPHERE, size);
      case Shape::Kind::Hull:
        return addTriangles();
      case Shape::Kind::Cone:
      case Shape::Kind::Sweep:
        return;  // neither in URDF nor in RViz
    }
  }

 private:
  /// `height` [m] along the piece's z axis.
  void add(int type, const Eigen::Vector3d& size, double height = 0.0) {
    Marker marker = base_;
    marker.type = type;
    marker.id = static_cast<int>(array_.markers.size());
    setPose(marker, link_T_piece_ * Eigen::Translation3d(0.0, 0.0, height));
    setSize(marker, size);
    array_.markers.push_back(std::move(marker));
  }

  void addTriangles() {
    add(Marker::TRIANGLE_LIST, Eigen::Vector3d::Ones());
    Marker& marker = array_.markers.back();
    for (const auto& triangle : shape_.hull().triangles()) {
      for (const int vertex : triangle) {
        marker.points.push_back(point(shape_.hull().vertices()[static_cast<std::size_t>(vertex)]));
      }
    }
    if (marker.points.empty()) array_.markers.pop_back();
  }

  const Shape& shape_;
  MarkerArray& array_;
  Eigen::Isometry3d link_T_piece_;
  Marker base_;
};

Marker label(const Proximity& pair, const std_msgs::Header& header, int id) {
  Marker marker;
  marker.header = header;
  marker.ns = "distances";
  marker.id = id;
  marker.type = Marker::TEXT_VIEW_FACING;
  marker.pose.orientation.w = 1.0;
  marker.pose.position.x = 0.5 * (pair.point_a.x + pair.point_b.x);
  marker.pose.position.y = 0.5 * (pair.point_a.y + pair.point_b.y);
  marker.pose.position.z = 0.5 * (pair.point_a.z + pair.point_b.z);
  marker.scale.z = 0.03;
  char text[32];
  std::snprintf(text, sizeof text, "%.1f mm", 1000.0 * pair.distance);
  marker.text = text;
  return marker;
}

Marker taken(const std_msgs::Header& header, const char* ns, int id) {
  Marker marker;
  marker.header = header;
  marker.ns = ns;
  marker.id = id;
  marker.action = Marker::DELETE;
  return marker;
}

}  // namespace

MarkerArray pieceMarkers(const RobotModel& robot, const std::string& tf_prefix) {
  MarkerArray array;
  for (const Body& body : robot.bodies) {
    for (const int piece : body.pieces)
      PieceDrawing(robot, tf_prefix, robot.pieces[static_cast<std::size_t>(piece)], array).draw();
  }
  return array;
}

MarkerArray witnessMarkers(const Clearance& clearance, const MonitorSettings& settings, std::size_t labels_before) {
  MarkerArray array;
  Marker lines;
  lines.header = clearance.header;
  lines.ns = "witnesses";
  lines.type = Marker::LINE_LIST;
  lines.pose.orientation.w = 1.0;
  lines.scale.x = 0.004;
  for (const Proximity& pair : clearance.below_threshold) {
    if (!pair.points_valid) continue;
    const std_msgs::ColorRGBA pair_colour = levelColour(clearanceLevel(pair.distance, Clearance::INVALID, settings));
    lines.points.insert(lines.points.end(), {pair.point_a, pair.point_b});
    lines.colors.insert(lines.colors.end(), 2, pair_colour);
    array.markers.push_back(label(pair, clearance.header, static_cast<int>(array.markers.size())));
    array.markers.back().color = pair_colour;
  }
  for (std::size_t i = array.markers.size(); i < labels_before; ++i) {
    array.markers.push_back(taken(clearance.header, "distances", static_cast<int>(i)));
  }
  if (lines.points.empty()) lines.action = Marker::DELETE;
  array.markers.push_back(std::move(lines));
  return array;
}

MarkerArray noMarkers() {
  MarkerArray array;
  array.markers.resize(1);
  array.markers.front().action = Marker::DELETEALL;
  return array;
}

}  // namespace proximity_server
