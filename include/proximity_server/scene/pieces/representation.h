#pragma once

namespace proximity_server::scene {

/// The geometry that the queries use for a <collision> element.
enum class Representation : unsigned char {
  Exact = 0,       ///< a primitive, or a mesh that is its hull (or hulls) within rounding
  ConvexHull = 1,  ///< the convex hull of a mesh that is not convex
  Decomposed = 2,  ///< several convex pieces that are not exactly the mesh
  Triangles = 3,   ///< the triangles themselves
};
const char* toString(Representation representation);

}  // namespace proximity_server::scene
