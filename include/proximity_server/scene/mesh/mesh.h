#pragma once

#include "proximity_server/scene/mesh/triangle_mesh.h"

#include <string>

namespace proximity_server::scene {

/// Reads all triangles of a mesh file (.stl and .ply, binary or ASCII, .dae, .obj). Instances and node transforms are
/// applied, then the scale.
///
/// Lengths are metres, and axes are not turned. The unit of a Collada file counts, and its up axis is ignored, as in
/// RViz; MoveIt ignores both.
/// A mirrored scale (one or three negative factors) turns the triangles so that they still face outwards.
/// A child process reads the file, so that a malformed file cannot harm this process.
/// Limit:   at most 256 MiB, 200,000 triangles, and 1e6 m from the origin; 1 GiB of memory, 10 s of processor time and
///          60 s to read it.
/// Failure: throws std::invalid_argument, naming the file: missing, unreadable, malformed, cut off (if its format shows
///          it), without a triangle, with a number that is not finite, or beyond a limit.
TriangleMesh loadMesh(const std::string& path, const Eigen::Vector3d& scale);

}  // namespace proximity_server::scene
