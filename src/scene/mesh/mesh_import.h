#pragma once

#include "scene/mesh/mesh_file.h"

#include <string>

namespace proximity_server::scene {

/// Reads the triangles of a mesh file with assimp, and scales them. It must run in a child process, because the time
/// and memory that assimp needs for a malformed file are not bounded. It opens no other file, even if the file names
/// one (materials of an OBJ). A text that is not empty is read in place of what the file has.
/// Throws std::runtime_error with the message of assimp, for more than kMaxTriangles triangles, and for more than three
/// vertices for each of that many triangles.
MeshWithUnit importMesh(const std::string& path, const std::string& text, const Eigen::Vector3d& scale);

// --- a mesh as bytes, for the pipe between the processes

std::string toBytes(const MeshWithUnit& read);

/// Throws std::runtime_error if the bytes are not a mesh: a wrong size, or a corner that is not a vertex.
MeshWithUnit meshFromBytes(const std::string& bytes);

/// The number of bytes of the largest legal mesh.
std::size_t maxBytesOfMesh();

}  // namespace proximity_server::scene
