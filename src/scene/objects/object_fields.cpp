#include "proximity_server/scene/objects/object_fields.h"

#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "scene/mesh/input_limits.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::Shape;
using Operation = ObjectEdit::Operation;
using Names = std::vector<std::string>;

Names withShapes(Names fields) {
  for (const ShapeKind& kind : kShapeKinds) fields.insert(fields.end(), {kind.shapes, kind.poses});
  return fields;
}

}  // namespace

void refuseField(const std::string& field, const std::string& reason) {
  throw std::invalid_argument(field + ": " + reason);
}

const Eigen::Isometry3d& requireReach(const Eigen::Isometry3d& pose) {
  if (!pose.matrix().allFinite() || pose.translation().norm() > kFarthest)
    refuseField("pose", std::string("it is ") + kTooFar + " from its frame, or not finite");
  return pose;
}

// --- fields

const std::array<OperationFields, 7>& operationFields() {
  static const Names whole = withShapes({"link", "touch_links", "frame", "pose", "padding"});
  static const std::array<OperationFields, 7> all = {
      {{"ADD", Operation::Add, whole},
       {"REPLACE", Operation::Replace, whole},
       {"APPEND", Operation::Append, withShapes({"touch_links", "pose"})},
       {"MOVE", Operation::Move, {"frame", "pose"}},
       {"ATTACH", Operation::Attach, {"link", "touch_links", "pose", "keep_pose"}},
       {"DETACH", Operation::Detach, {"frame"}},
       {"REMOVE", Operation::Remove, {}}}};
  return all;
}

void completeFields(ObjectEdit& edit) {
  const OperationFields& operation = operationFields()[static_cast<std::size_t>(edit.operation)];
  const auto takes = [&](const char* field) {
    return std::find(operation.takes.begin(), operation.takes.end(), field) != operation.takes.end();
  };
  const bool takes_shapes = takes(kShapeKinds[0].shapes), detaches = edit.operation == Operation::Detach;
  const auto require = [&](const char* field, bool is_empty, bool is_taken) {
    if (!is_empty && !is_taken) refuseField(field, std::string(operation.name) + " does not take it");
  };
  require("shapes", edit.shapes.empty(), takes_shapes);
  for (std::size_t kind = 0; kind < kShapeKinds.size(); ++kind)
    require(kShapeKinds[kind].poses, edit.shape_poses[kind].empty(), takes_shapes || edit.operation == Operation::Move);
  require("padding", edit.padding == 0.0, takes("padding"));
  require("link", edit.place.link.empty(), takes("link"));
  require("touch_links", edit.place.touch_links.empty(), takes("touch_links"));
  require("frame", edit.place.frame.empty(), takes("frame"));
  require("keep_pose", edit.pose == ObjectEdit::Pose::Given, detaches || takes("keep_pose"));
  if (!edit.place.link.empty() && !edit.place.frame.empty()) refuseField("frame", "it goes without link only");
  if (!(edit.padding >= 0.0) || !std::isfinite(edit.padding)) refuseField("padding", "it is negative, or not finite");
  if (!takes_shapes) return;
  if (edit.shapes.empty())
    throw std::invalid_argument(edit.operation == Operation::Append ? "shapes: there are none" : "it has no shape");
  placeShapes(edit.shape_poses, edit.shapes);
  edit.shape_poses = {};
}

void placeShapes(const ShapePoses& poses, std::vector<ObjectShape>& shapes) {
  for (std::size_t kind = 0; kind < poses.size(); ++kind) {
    std::size_t count = 0;
    for (ObjectShape& shape : shapes)
      if (shape.geometry.index() == kind && count++ < poses[kind].size()) shape.object_T_shape = poses[kind][count - 1];
    if (!poses[kind].empty() && count != poses[kind].size())
      refuseField(kShapeKinds[kind].poses,
                  std::to_string(poses[kind].size()) + " poses for " + std::to_string(count) + " shapes of this kind");
  }
}

Isometry3d poseFrom(const Vector3d& position, Eigen::Quaterniond orientation) {
  if (!position.allFinite()) throw std::invalid_argument("the position is not finite");
  if (!orientation.coeffs().allFinite()) throw std::invalid_argument("the orientation is not finite");
  if (orientation.coeffs() == Eigen::Vector4d::Zero()) orientation.setIdentity();
  orientation.coeffs().stableNormalize();
  return Eigen::Translation3d(position) * orientation;
}

// --- shapes

Shape primitiveFrom(const std::string& type, const std::vector<double>& d) {
  const auto is = [&](const char* name, const char* number, std::size_t count, const char* meaning) {
    if (type != name && type != number) return false;
    if (d.size() == count) return true;
    throw std::invalid_argument("dimensions has " + std::to_string(d.size()) + " numbers instead of " + meaning);
  };
  if (is("BOX", "1", 3, "3, the edges along x, y and z")) return narrowphase::Box{{d[0], d[1], d[2]}};
  if (is("SPHERE", "2", 1, "1, the radius")) return narrowphase::Sphere{d[0]};
  if (is("CYLINDER", "3", 2, "2, height and radius")) return narrowphase::Cylinder{d[1], d[0]};
  if (is("CONE", "4", 2, "2, height and radius")) return narrowphase::Cone{d[1], d[0]};
  throw std::invalid_argument("type " + type + " is none of BOX, SPHERE, CYLINDER and CONE");
}

Boxes boxesFrom(const std::vector<Vector3d>& centres, const std::vector<Vector3d>& sizes) {
  if (sizes.size() != 1 && sizes.size() != centres.size())
    throw std::invalid_argument("sizes has " + std::to_string(sizes.size()) + " entries, neither 1 nor the " +
                                std::to_string(centres.size()) + " of centres");
  Boxes boxes;
  boxes.boxes.reserve(centres.size());
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const Vector3d half = 0.5 * sizes[sizes.size() == 1 ? 0 : i];
    boxes.boxes.emplace_back(centres[i] - half, centres[i] + half);
  }
  return boxes;
}

TriangleMesh meshFrom(std::vector<Vector3d> vertices, std::vector<std::array<int, 3>> triangles) {
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (const int vertex : triangles[i])
      if (vertex < 0 || static_cast<std::size_t>(vertex) >= vertices.size())
        throw std::invalid_argument("triangles[" + std::to_string(i) + "] names vertex " + std::to_string(vertex) +
                                    " of " + std::to_string(vertices.size()));
  return {std::move(vertices), std::move(triangles)};
}

MeshFile meshFileFrom(const std::string& uri, const std::string& folder, const Vector3d& scale) {
  MeshFile file{absoluteUri(uri, folder), scale};
  if (scale == Vector3d::Zero()) file.scale.setOnes();
  if (!file.scale.allFinite() || (file.scale.array() == 0.0).any())
    throw std::invalid_argument("scale has a number that is zero or not finite");
  return file;
}

HalfSpace halfSpaceFrom(double a, double b, double c, double d) {
  const Vector3d normal(a, b, c);
  const double length = normal.stableNorm(), offset = -d / length;
  if (!(length > 0.0) || !std::isfinite(length) || !std::isfinite(offset))
    throw std::invalid_argument("coef: a number is not finite, or a, b and c are zero");
  return {normal / length, offset};
}

}  // namespace proximity_server::scene
