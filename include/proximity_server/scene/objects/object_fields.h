#pragma once

#include "proximity_server/scene/objects/object.h"
#include "proximity_server/scene/objects/object_shape.h"

#include <Eigen/Geometry>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

// One description of an object, for messages, files and scripts: each of them fills an ObjectEdit, makes its shapes by
// the functions below, and then calls completeFields(). Fields have the names of ObjectChange.msg.
//
// Failure: all functions throw std::invalid_argument with the field and the reason, but without the object.

namespace proximity_server::scene {

/// The place of an object, in the frame of the link that holds it or of the frame with which it moves.
struct ObjectPlace {
  std::string link;                      ///< "": no link holds it
  std::vector<std::string> touch_links;  ///< links that it may touch besides its own link
  std::string frame;                     ///< the frame if no link holds it; "": the frame of the answers
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< in the frame of `link` or in `frame`
  std::optional<std::string> pose_frame = {};  ///< the frame in which the pose is given, if it is another one
};

/// The poses of shapes for each kind of shapes, in the order of kShapeKinds. A kind without poses stays where it is.
using ShapePoses = std::array<std::vector<Eigen::Isometry3d>, std::variant_size_v<decltype(ObjectShape::geometry)>>;

/// One operation on one object, before its names are looked up.
struct ObjectEdit {
  enum class Operation : unsigned char { Add, Replace, Append, Move, Attach, Detach, Remove };
  /// Attach and Detach: the object gets the pose of `place` (Given), or stays where it is at that time (Kept).
  enum class Pose : unsigned char { Given, Kept };

  std::string id;  ///< for Remove, "*" stands for all objects
  ObjectPlace place;
  double padding = 0.0;  ///< [m] for Add and Replace
  /// Add, Replace: all shapes of the object. Append: the new shapes, placed as if they were an object of their own.
  std::vector<ObjectShape> shapes;
  std::string source;  ///< messages about the operation begin with it: "cell.yaml, line 3: objects[0] "table""
  Operation operation = Operation::Add;
  Pose pose = Pose::Given;
  /// for Add and Replace: the geometry of the shapes, if it has been made already
  std::shared_ptr<const ObjectGeometry> geometry = nullptr;
  ShapePoses shape_poses = {};  ///< of `shapes` until completeFields(); Move: of the shapes of the object
};

/// A kind of shapes, with the names of its lists. The index is the one of ObjectShape::geometry.
struct ShapeKind {
  const char* shapes;
  const char* poses;
};
constexpr std::array<ShapeKind, std::tuple_size_v<ShapePoses>> kShapeKinds = {{{"primitives", "primitive_poses"},
                                                                               {"boxes", "boxes_poses"},
                                                                               {"meshes", "mesh_poses"},
                                                                               {"mesh_files", "mesh_file_poses"},
                                                                               {"planes", "plane_poses"}}};

/// An operation with the fields that it takes besides the id. A Move of a message also takes poses of shapes.
struct OperationFields {
  const char* name;
  ObjectEdit::Operation operation;
  std::vector<std::string> takes;
};
/// In the order of ObjectEdit::Operation, which has the numbers of ObjectChange.msg.
const std::array<OperationFields, 7>& operationFields();

/// Returns the pose of an object. Refuses one that is not finite, or farther than 1e6 m from its frame.
const Eigen::Isometry3d& requireReach(const Eigen::Isometry3d& pose);

[[noreturn]] void refuseField(const std::string& field, const std::string& reason);

/// Puts the shapes into their poses. Refuses fields that do not fit each other or the operation, and a bad padding.
void completeFields(ObjectEdit& edit);

/// Puts shapes into these poses.
void placeShapes(const ShapePoses& poses, std::vector<ObjectShape>& shapes);

/// Makes a pose. A quaternion of zeros is the identity; any other is normalised.
Eigen::Isometry3d poseFrom(const Eigen::Vector3d& position, Eigen::Quaterniond orientation);

// Shapes. makeObject() checks the rest.

/// `type` is the name or the number of a type of SolidPrimitive.msg.
narrowphase::Shape primitiveFrom(const std::string& type, const std::vector<double>& dimensions);
/// There is one size, or one for each centre.
Boxes boxesFrom(const std::vector<Eigen::Vector3d>& centres, const std::vector<Eigen::Vector3d>& sizes);
TriangleMesh meshFrom(std::vector<Eigen::Vector3d> vertices, std::vector<std::array<int, 3>> triangles);
/// A relative path begins in `folder`. A scale of zeros is 1.
MeshFile meshFileFrom(const std::string& uri, const std::string& folder, const Eigen::Vector3d& scale);
/// The half-space a x + b y + c z + d <= 0.
HalfSpace halfSpaceFrom(double a, double b, double c, double d);

}  // namespace proximity_server::scene
