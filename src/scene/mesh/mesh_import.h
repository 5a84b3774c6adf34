#pragma once

#include <string>

#include "proximity_server/scene/mesh/mesh.h"

namespace proximity_server::scene {

/// The triangles of a mesh file as assimp reads them, scaled; the work of a child process, since what assimp does to a
/// malformed file is not bounded. No other file is opened, also where one is named in it (materials of an OBJ).
/// Throws std::runtime_error: what assimp says; more triangles than kMaxTriangles, or vertices than three for each.
TriangleMesh importMesh(const std::string& path, const Eigen::Vector3d& scale);

// --- the same as bytes

std::string toBytes(const TriangleMesh& mesh);

/// Throws std::runtime_error for anything that is not a mesh: a size that is wrong, a corner that is no vertex.
TriangleMesh meshFromBytes(const std::string& bytes);

/// The most bytes that a mesh has.
std::size_t maxBytesOfMesh();

}  // namespace proximity_server::scene
