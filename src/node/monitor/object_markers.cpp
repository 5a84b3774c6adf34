#include "node/monitor/object_markers.h"

#include "node/monitor/markers.h"
#include "node/objects/change_frames.h"
#include "proximity_server/scene/model/kinematics.h"

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace proximity_server::node {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

constexpr double kPlaneSize = 10.0;        // [m] edge of the square that is drawn for a half-space
constexpr double kPlaneThickness = 0.002;  // [m] so that the square is visible from the side
constexpr double kMicrometre = 1e-6;       // [m]
constexpr int kConeSides = 24;             // RViz has no cones; a pyramid with this many sides looks round

void addTriangle(const Vector3d& a, const Vector3d& b, const Vector3d& c, Marker& marker) {
  for (const Vector3d& corner : {a, b, c}) marker.points.push_back(point(corner));
}

/// Draws the shapes of one object, each with a marker of its own.
class ShapeDrawing {
 public:
  ShapeDrawing(const Marker& base, const Isometry3d& frame_T_object, MarkerArray& array)
      : base_(base), frame_T_object_(frame_T_object), array_(array) {}

  void draw(const scene::ObjectShape& shape) {
    frame_T_shape_ = frame_T_object_ * shape.object_T_shape;
    std::visit([this](const auto& geometry) { drawGeometry(geometry); }, shape.geometry);
  }

 private:
  Marker& add(int type, const Vector3d& size, const Isometry3d& shape_T_marker = Isometry3d::Identity()) {
    Marker marker = base_;
    marker.type = type;
    marker.id = next_id_++;
    marker.pose = toMessage(frame_T_shape_ * shape_T_marker);
    setSize(marker, size);
    array_.markers.push_back(std::move(marker));
    return array_.markers.back();
  }

  /// Draws a primitive of shape_msgs.
  void drawGeometry(const narrowphase::Shape& shape) {
    using Kind = narrowphase::Shape::Kind;
    const Vector3d size = 2.0 * shape.halfExtents();
    if (shape.kind() == Kind::Point) add(Marker::SPHERE, Vector3d::Constant(2.0 * shape.margin()));
    if (shape.kind() == Kind::Box) add(Marker::CUBE, size);
    if (shape.kind() == Kind::Cylinder) add(Marker::CYLINDER, size);
    if (shape.kind() == Kind::Cone) drawCone(0.5 * size);
  }

  /// Draws a cone with its base at z = -half.z and its apex at z = half.z.
  void drawCone(const Vector3d& half) {
    Marker& marker = add(Marker::TRIANGLE_LIST, Vector3d::Ones());
    const auto onRim = [&](int side) {
      const double angle = 2.0 * M_PI * side / kConeSides;
      return Vector3d(half.x() * std::cos(angle), half.y() * std::sin(angle), -half.z());
    };
    for (int side = 0; side < kConeSides; ++side) {
      addTriangle(onRim(side), onRim(side + 1), {0.0, 0.0, half.z()}, marker);
      addTriangle(onRim(side + 1), onRim(side), {0.0, 0.0, -half.z()}, marker);
    }
  }

  /// Draws all boxes of one size with one marker. A map has few sizes: one, or one for each level of its octree.
  void drawGeometry(const scene::Boxes& boxes) {
    std::map<std::array<long long, 3>, std::vector<geometry_msgs::Point>> centres;  // by the size in micrometres
    for (const Eigen::AlignedBox3d& box : boxes.boxes) {
      const Vector3d size = box.sizes() / kMicrometre;
      centres[{std::llround(size.x()), std::llround(size.y()), std::llround(size.z())}].push_back(point(box.center()));
    }
    for (auto& [size, points] : centres) {
      const Vector3d metres = kMicrometre * Vector3d(static_cast<double>(size[0]), static_cast<double>(size[1]),
                                                     static_cast<double>(size[2]));
      add(Marker::CUBE_LIST, metres).points = std::move(points);
    }
  }

  void drawGeometry(const scene::TriangleMesh& mesh) {
    Marker& marker = add(Marker::TRIANGLE_LIST, Vector3d::Ones());
    for (const auto& corners : mesh.triangles)
      addTriangle(mesh.vertices[corners[0]], mesh.vertices[corners[1]], mesh.vertices[corners[2]], marker);
  }

  void drawGeometry(const scene::MeshFile& file) { add(Marker::MESH_RESOURCE, file.scale).mesh_resource = file.uri; }

  /// Draws a square in the plane, around the point that is nearest to the origin of the shape.
  void drawGeometry(const scene::HalfSpace& half_space) {
    const Vector3d normal = half_space.normal.normalized();
    Isometry3d shape_T_plane(scene::turnFromZ(normal));
    shape_T_plane.translation() = (half_space.offset - 0.5 * kPlaneThickness) * normal;
    add(Marker::CUBE, {kPlaneSize, kPlaneSize, kPlaneThickness}, shape_T_plane);
  }

  const Marker& base_;
  const Isometry3d frame_T_object_;
  MarkerArray& array_;
  Isometry3d frame_T_shape_;
  int next_id_ = 0;
};

std_msgs::ColorRGBA colourOf(const scene::Placement& placement) {
  const bool is_held = std::holds_alternative<scene::Attached>(placement);
  std_msgs::ColorRGBA colour;
  colour.r = 0.9f;
  colour.g = is_held ? 0.6f : 0.85f;
  colour.b = is_held ? 0.2f : 0.75f;
  colour.a = 0.6f;
  return colour;
}

}  // namespace

MarkerArray objectMarkers(const Robot& robot, const scene::Objects& objects) {
  MarkerArray array = noMarkers();
  const ChangeFrames frames(robot);
  for (const int number : objects.numbers()) {
    const scene::Object& object = *objects.object(number);
    if (robot.config().findTracked(object.id)) continue;  // it moves with each message, but these are published rarely
    Marker base;
    base.header.frame_id = scene::carrierOf(object, frames);
    base.ns = object.id;
    base.frame_locked = true;
    base.color = colourOf(object.placement);
    ShapeDrawing drawing(base, scene::poseInCarrier(object), array);
    for (const scene::ObjectShape& shape : scene::givenShapesOf(object)) drawing.draw(shape);
  }
  return array;
}

}  // namespace proximity_server::node
