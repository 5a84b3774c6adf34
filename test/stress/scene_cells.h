#pragma once

#include "chance.h"
#include "oracle/motion_oracle.h"
#include "proximity_server/scene/motion/limited_motion.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/scene.h"
#include "scene/pieces/interior.h"

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::scene {

// Robots with objects that come, go, move and are attached. All poses and parts follow from their description alone.

using narrowphase::longPose;
using narrowphase::LongPose;
using narrowphase::Matrix3l;
using narrowphase::Shape;
using narrowphase::Vector3l;

/// Cells that share one kind of trouble. Shares are between 0 and 1.
struct SceneFamily {
  const char* name;
  enum class Robot : unsigned char { Small, Example } robot = Robot::Small;
  enum class Poses : unsigned char { Anywhere, Aligned } poses = Poses::Anywhere;  ///< of objects
  int objects = 5;                                                                 ///< more or less
  double attached = 0.2;                                                           ///< share of the objects
  double moving = 0.2;                                                             ///< share of the objects
  double planes = 0.1;                                                             ///< share of the shapes
  double bulk = 0.05;   ///< share of the shapes that are many boxes
  double solids = 0.0;  ///< share of the objects that are closed meshes, as their triangles
  double jumps = 0.4;   ///< share of the states; in all others little moves
  int smallest = -1;    ///< [decades of m] of the shapes
  int largest = 0;
  int farthest = -1;           ///< [decades of m] of the cell from the origin of the poses; -1: it stands there
  double beyond_limits = 0.0;  ///< share of the joints
  bool has_any_size = false;   ///< the cell, from 1e-20 to 1e5 m
  double farthest_slide = 1;   ///< [decades of the size] of a joint in motion
  int rarity = 1;              ///< a slow family takes part in every so many rounds of a run only
};

const std::vector<SceneFamily>& sceneFamilies();

/// A convex part. The world is moved to SceneCell::origin(), so that its numbers are small.
struct WorldPart {
  Shape shape;  ///< padding included
  LongPose world_T_part;
  int number;  ///< of the <collision> or the shape of the object, counted from 1

  // Parts of a mesh have these, see Piece.
  std::shared_ptr<const Interior> interior = nullptr;
  bool is_representative = true;
};

/// All points x with normal . x <= offset.
struct WorldPlane {
  Vector3l normal;
  long double offset;  ///< [m] padding included
  int number;
};

/// The parts and planes that stand for a link or an object.
struct WorldSolid {
  std::vector<WorldPart> parts;
  std::vector<WorldPlane> planes;
};

/// A robot and its objects, state by state. Depends on nothing but the arguments.
class SceneCell {
 public:
  SceneCell(std::size_t family, unsigned seed, std::int64_t number);

  /// Changes objects, and moves what moves.
  void next();

  /// Begins a motion of the joints, until their limits, and of the frames, from the present state on.
  const Motion& startMotion();
  /// Places everything at a time [0, 1] of the motion: the bodies by the positions of their joints, the frames by their
  /// screws.
  void placeAt(double time);

  const std::shared_ptr<const SceneModel>& model() const { return model_; }
  const std::shared_ptr<const Objects>& objects() const { return objects_; }
  const BodyPoses& poses() const { return poses_; }
  const FramePoses& frames() const { return frame_poses_; }
  double size() const { return size_; }  ///< [m] of the cell
  /// In the frame of the poses.
  Eigen::Vector3d origin() const { return world_T_cell_.translation(); }

  /// All checked pairs, found by asking for the reason of each.
  std::vector<ShapeRefPair> checkedPairs() const;

  /// nullopt if a pose or all geometry is missing.
  std::optional<WorldSolid> solidOf(const ShapeRef& ref) const;

  /// [m] Taken off the distance of a pair.
  double paddingOf(const ShapeRefPair& pair) const;

  Chance& chance() { return chance_; }

  /// One time in three; of half of the pairs of links, and of half of the links with objects, other ones than of all
  /// others. Recorded scenes stay what they are: the random numbers that follow are the same.
  std::optional<PairDistances> someThresholds() const;

 private:
  /// A part of an object as it was described.
  struct Part {
    std::optional<Shape> shape;  ///< nothing: a half-space
    HalfSpace half_space{};
    LongPose object_T_part;
    double padding;
    int number;

    // Parts of a mesh have these, see Piece.
    std::shared_ptr<const Interior> interior = nullptr;
    bool is_representative = true;
  };

  /// [rad], or [m] of the cell.
  double unitOf(const Joint& joint) const { return joint.type == Joint::Type::Prismatic ? size_ : 1.0; }
  double shapeSize();
  Eigen::Isometry3d somePose(double reach);
  Shape someShape();
  ObjectShape someObjectShape(std::vector<Part>& parts, bool with_planes, double padding);
  Object someObject(const std::string& id, const Placement& placement);
  Object someClosedMesh(const std::string& id, const Placement& placement);
  Placement freePlacement();
  Attached attachment();
  Placement anyPlacement();
  ObjectRules someRules();
  ObjectChange someChange();
  std::string someId() { return objects_->object(chance_.oneOf(objects_->numbers()))->id; }
  void change();
  void jump();
  void step();
  void place();
  BodyPoses posesOf(const std::vector<double>& positions) const;
  LongPose inCell(const Eigen::Isometry3d& world_T_x) const;
  std::optional<LongPose> worldOf(const Placement& placement) const;

  const SceneFamily& family_;
  Chance chance_;
  std::shared_ptr<const SceneModel> model_;
  double magnitude_ = 1.0, size_ = 1.0;
  Eigen::Isometry3d world_T_cell_ = Eigen::Isometry3d::Identity();
  std::shared_ptr<const Objects> objects_;
  std::map<std::string, std::vector<Part>> described_;  ///< by id
  std::vector<double> positions_;
  std::vector<Eigen::Isometry3d> floating_;  ///< by body, of those with a joint without a position: in the parent body
  std::vector<double> travel_;               ///< of the motion
  std::optional<Motion> motion_;
  std::array<Eigen::Isometry3d, 3> known_frames_;
  int missing_frame_ = -1, missing_body_ = -1;
  int added_ = 0;
  BodyPoses poses_;
  FramePoses frame_poses_;
};

}  // namespace proximity_server::scene
