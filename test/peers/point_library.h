#pragma once

#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/mesh/triangle_mesh.h"
#include "proximity_server/scene/model/kinematics.h"

#include <Eigen/Geometry>

#include <memory>
#include <vector>

namespace proximity_server::peers {

using namespace scene;

/// The mesh of a <collision>, as its file has it, or the triangles of its box.
struct LinkMesh {
  int body;
  Eigen::Isometry3d body_T_mesh;
  TriangleMesh mesh;
};

/// The meshes of a robot all of whose geometry is boxes, and meshes without a scale. Throws std::invalid_argument for other geometry.
std::vector<LinkMesh> linkMeshes(const RobotModel& robot, const MeshResolver& resolve);

/// A library that answers how far points are from a robot.
class PointLibrary {
 public:
  virtual ~PointLibrary() = default;

  /// Takes the poses, and writes the distance [m] of each point into `distances`: one above the threshold if it is farther
  /// than that. This is what is timed.
  virtual void ask(const BodyPoses& poses, const std::vector<Eigen::Vector3d>& points, double threshold,
                   std::vector<double>& distances) = 0;
};

/// FCL with a tree of triangles (OBBRSS) for each mesh, and a sphere of radius 0 for the point: the meshes by the distance
/// of their boxes, until none can be nearer than the nearest so far, which is the bound of each query. Inside of a mesh it
/// has the distance from the triangles.
std::unique_ptr<PointLibrary> fclPoints(const std::vector<LinkMesh>& meshes);

/// A kd-tree (nanoflann) of the vertices of each mesh, with the same order of the meshes. Its answers are too large:
/// triangles are nearer than their corners. nullptr if this build has no nanoflann.
std::unique_ptr<PointLibrary> vertexTrees(const std::vector<LinkMesh>& meshes);

}  // namespace proximity_server::peers
