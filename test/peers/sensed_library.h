#pragma once

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/robot_model.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>

#include <Eigen/Geometry>

#include <memory>
#include <vector>

namespace proximity_server::peers {

using namespace scene;

/// FCL 0.7 as MoveIt uses it for what a camera sees: a dynamic AABB tree of the surroundings is asked for each part of a
/// link, with the smallest distance so far as the bound. The surroundings are an octree of octomap, or boxes.
///
/// A query that throws or aborts counts as far, and failures() as one more.
class FclSensed {
 public:
  enum class Parts {
    Triangles,  ///< boxes and hulls of a link are one tree of triangles (OBBRSS), as MoveIt has meshes
    Hulls       ///< each is a convex shape
  };
  /// Throws std::invalid_argument for a piece that FCL cannot describe.
  FclSensed(const RobotModel& robot, const std::vector<int>& links, Parts parts);

  /// Makes the surroundings: an octree with the leaves of these points; without rays, which would make other leaves free.
  void seeOctree(const std::vector<Eigen::Vector3d>& points, double resolution);
  void seeBoxes(const std::vector<Eigen::AlignedBox3d>& boxes);

  /// [m] The smallest distance of a link from the surroundings; infinite without any.
  double minimum(const BodyPoses& poses);

  int failures() const { return failures_; }

 private:
  struct Part {
    int body;
    Eigen::Isometry3d body_T_part;
    std::unique_ptr<fcl::CollisionObjectd> object;
  };
  struct Search {
    double distance;
    int failures;
  };

  static bool visit(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* search, double& reach);
  void see(std::vector<std::unique_ptr<fcl::CollisionObjectd>> seen);

  std::vector<Part> parts_;
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> seen_;
  std::unique_ptr<fcl::DynamicAABBTreeCollisionManagerd> manager_;
  int failures_ = 0;
};

}  // namespace proximity_server::peers
