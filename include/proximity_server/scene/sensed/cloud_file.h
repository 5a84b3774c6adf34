#pragma once

#include "proximity_server/narrowphase/shape/eigen_alignment.h"

#include <Eigen/Geometry>

#include <string>
#include <vector>

// Clouds of points and octrees in files, in the frame of the file.
//
// Failure: throws std::invalid_argument naming the file, the line or the byte, and the reason.

namespace proximity_server::scene {

/// Reads the points [m] of a .pcd, or the vertices of a .ply, which come first in it; both as text or binary.
/// Points with a number that is not finite are no returns, and left out. The viewpoint of a .pcd is not used.
std::vector<Eigen::Vector3d> readCloudPoints(const std::string& path);

bool isCloudFile(const std::string& path);  ///< by the end of its name: .pcd, .ply, .bt or .ot

constexpr double kVoxelEdge = 0.02;  ///< [m] if nobody names another one

/// Reads what is occupied as boxes [m]: the voxels of points, with edges of `resolution` [m], or the leaves of an octree
/// of octomap (.bt, .ot).
/// Failure: as above, as VoxelGrid and occupiedBoxes() do, and if nothing is occupied.
std::vector<Eigen::AlignedBox3d> readCloudBoxes(const std::string& path, double resolution);

}  // namespace proximity_server::scene
