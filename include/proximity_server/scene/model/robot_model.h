#pragma once

#include "proximity_server/narrowphase/shape/shape.h"
#include "proximity_server/scene/model/joint_inequality.h"
#include "proximity_server/scene/pieces/representation.h"

#include <Eigen/Geometry>

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::scene {

class Interior;

/// A convex part of a body's collision geometry.
struct Piece {
  narrowphase::Shape shape;  ///< with the padding as margin
  Eigen::Isometry3d body_T_piece;
  int collision;  ///< index into RobotModel::collisions

  /// true for one piece of each connected part of a mesh, and for every piece that is not of a mesh; see MeshPieces
  bool is_representative = true;
  /// the space inside the whole mesh; stored in one of its pieces, in the frame of the piece
  std::shared_ptr<const Interior> interior = nullptr;
};

/// One <collision> element.
struct Collision {
  std::string name;         ///< its name attribute, or ""
  std::string description;  ///< for people: "box 0.1 x 0.2 x 0.3", "mesh package://..."
  int link;                 ///< index into RobotModel::links
  int number;               ///< n-th <collision> of its link, counted from 1
  Representation representation;
  double deviation;         ///< [m] how far the pieces lie outside of the mesh, see MeshPieces
  std::vector<int> pieces;  ///< the pieces of this element, indices into RobotModel::pieces
  double uncovered = 0.0;   ///< [m] how far the mesh lies outside of the pieces, see MeshPieces

  /// See MeshPieces; NaN for a primitive.
  double volume_ratio = std::numeric_limits<double>::quiet_NaN();
  bool is_visual = false;  ///< a <visual> of a link without <collision>, see ModelOptions::collision_from_visual
};

struct Link {
  std::string name;
  int body;  ///< index into RobotModel::bodies
  Eigen::Isometry3d body_T_link;
  std::vector<int> collisions;  ///< indices into RobotModel::collisions, in the URDF's order
  int parent = -1;              ///< the link at the other end of the (fixed or movable) joint above it; -1 for the root
};

/// A movable joint. Fixed joints are merged into bodies.
struct Joint {
  enum class Type : unsigned char { Revolute, Continuous, Prismatic, Floating, Planar };
  std::string name;
  Type type;
  int parent_link;
  int child_link;
  Eigen::Isometry3d parent_T_joint;  ///< in the parent link's frame, at position 0
  Eigen::Vector3d axis;              ///< unit, joint frame; the normal of a planar joint
  double lower, upper;               ///< [rad] or [m]; +-infinity if the joint has no limit
  double max_velocity;               ///< [rad/s] or [m/s]; infinity if not stated
  struct Mimic {
    int joint;  ///< index into RobotModel::joints
    double multiplier, offset;
  };
  std::optional<Mimic> mimic;
};

/// Links that are joined by fixed joints: they move together. The frame of a body is the frame of its first link.
struct Body {
  int link;    ///< the link that gives the frame: the root, or the child of `joint`
  int joint;   ///< the movable joint that carries it, index into RobotModel::joints; -1 for a root body
  int parent;  ///< the body at the other end of that joint; -1 for a root body
  std::vector<int> links;
  /// the pieces of the whole body; a capsule replaces the cylinder and the spheres that form it
  std::vector<int> pieces;
  int robot = 0;  ///< index into RobotModel::robots
};

/// One of the robots of a model.
struct Member {
  std::string name;       ///< "left"; "" if the model has only one robot
  std::string urdf_name;  ///< the name of the robot in its URDF

  /// Convert a name of a link, joint or group of the robot to its name in the model, and back: "elbow" is "left/elbow"
  /// there, or "elbow" if the model has only one robot.
  std::string nameInModel(const std::string& own) const { return name.empty() ? own : name + "/" + own; }
  std::string ownName(const std::string& in_model) const {
    return name.empty() ? in_model : in_model.substr(name.size() + 1);
  }

  /// A sentence about the robot: it begins with the robot's name, if it has one.
  std::string sentence(const std::string& text) const {
    return name.empty() ? text : "robot \"" + name + "\": " + text;
  }
};

/// A robot in the form that the queries use, or several robots that joined() has made one. It never changes after
/// loading. The bodies are ordered robot by robot, and within a robot parents come first; the first body of each robot
/// is its root.
struct RobotModel {
  std::string name;
  std::vector<Link> links;
  std::vector<Joint> joints;
  std::vector<std::string> fixed_joints;  ///< the names of the joints that were merged into bodies
  std::vector<Body> bodies;
  std::vector<Collision> collisions;
  std::vector<Piece> pieces;
  std::vector<std::string> warnings;            ///< each is one sentence about input that is odd but legal
  std::vector<Member> robots{Member{}};         ///< see joined()
  std::vector<JointInequality> inequalities{};  ///< limits that couple joints, see setJointInequalities()

  /// The index of a link, or -1.
  int findLink(const std::string& name) const;

  /// True if the link has collision geometry.
  bool hasGeometry(int link) const;

  /// The <collision> element of a piece.
  const Collision& collisionOf(const Piece& piece) const { return collisions[piece.collision]; }

  /// The pieces of the <collision> elements of a link; indices into `pieces`.
  std::vector<int> piecesOf(int link) const;

  /// The robot of a link.
  const Member& robotOf(int link) const { return robots[bodies[links[link].body].robot]; }

  /// roots(): the root body of each of `robots`. rootLink(): the root link of the first one.
  std::vector<int> roots() const;
  int rootLink() const { return bodies.front().link; }

  /// The path between two links: how many movable joints it has, and whether a third link on it has geometry. Counting
  /// ends as soon as there are several joints and such a link. Links of different robots have no path: nullopt.
  struct Connection {
    int movable_joints = 0;
    bool passes_geometry = false;
  };
  std::optional<Connection> connection(int link_a, int link_b) const;

  /// True if two links are joined by one movable joint, possibly through fixed links that have no geometry of their
  /// own.
  bool areNeighbours(int link_a, int link_b) const;

  /// The joint that determines the position of a joint: position = offset + multiplier * position of the leader. A
  /// joint that is not a mimic joint is its own leader.
  Joint::Mimic leaderOf(int joint) const;

  /// [m] An upper bound of the distance of any point of the link's geometry from a point, which is given in the frame
  /// of the link's body.
  double reachOf(int link, const Eigen::Vector3d& point) const;
};

/// "revolute", "continuous", "prismatic", "floating" or "planar".
const char* toString(Joint::Type type);

/// True if the joint has one degree of freedom; false for floating and planar joints.
bool hasOnePosition(const Joint& joint);

}  // namespace proximity_server::scene
