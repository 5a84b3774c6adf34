#pragma once

#include "proximity_server/narrowphase/cso/cso.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

namespace proximity_server::narrowphase {

/// The polytope of EPA: a closed convex surface of triangles between CSO vertices, in fixed storage.
///
/// It keeps the topology and the distances of the faces from the origin; EPA decides when to stop. A vertex w is added
/// by expand():
///
/// 1. Remove the face that w was found from.
/// 2. Visit its neighbours depth first: a face that w sees is removed, too, and so may be one whose plane contains w
///    within rounding, see Coplanar.
///    The half-edges across which the visit meets a face that stays are the horizon.
/// 3. If the horizon is not one closed loop, rounding has spoilt the topology, and the polytope cannot grow further.
/// 4. Add the cone: a triangle from each edge of the horizon to w, which are computed two at a time. Neighbours share
///    their edge to w, so that each triangle needs one cross product only. Connect its three half-edges with their
///    twins.
/// 5. Store the squared distances of the new faces that are closer than the best known depth. They stand in one array,
///    so that the closest face is found by comparing them all: with the 20 to 150 faces of a query this is cheaper than
///    to keep them in order.
///
/// Source:  van den Bergen, Proximity Queries and Penetration Depth Computation on 3D Game Objects, GDC 2001; Barber,
///          Dobkin, Huhdanpaa, The Quickhull Algorithm for Convex Hulls, ACM TOMS 1996 (visible faces and horizon).
/// Differs: faces without area are kept, without a normal; the next visible vertex removes them.
class Polytope {
 public:
  static constexpr int kMaxVertices = 512;
  static constexpr int kMaxFaces = 2 * kMaxVertices;

  /// A triangle, stored by its area vector. Normal and distance need a root and a division, and are computed on demand
  /// only: most faces are removed before they are needed. A face takes one cache line.
  struct alignas(64) Face {
    Eigen::Vector3d area;         ///< outward, twice the area long. Zero for a sliver without a normal: such a face is
                                  ///< never the closest, and is visible from every new vertex
    double area2;                 ///< squared norm of the area vector
    double height;                ///< smallest dot product of the area vector with a corner: the distance of the face
                                  ///< from the origin times |area|. The smallest is safe against rounding of the area
    std::array<int, 3> vertices;  ///< counter-clockwise from outside
    std::array<int, 3> twins;     ///< twins[i]: half-edge of the neighbour across the edge from vertices[i] to the next

    bool isRemoved() const { return vertices[0] == kRemoved; }
    bool hasNormal() const { return area2 > 0.0; }
    Eigen::Vector3d normal() const { return area / std::sqrt(area2); }  ///< unit
    double distance() const { return height / std::sqrt(area2); }       ///< [m] from the origin, along the normal
    /// True if the distance is less than `limit` [m]; false for a sliver.
    bool isCloserThan(double limit) const { return height * std::abs(height) < limit * std::abs(limit) * area2; }
  };

  /// The treatment of a face that lies in one plane with a new vertex. If it is replaced by the cone, the faces are
  /// fewer and wider. The flat end of a curved core gets new vertices again and again, and its faces would be made anew
  /// with each; there they are kept.
  ///
  /// Kept: a vertex may lie up to `rounding` above a face that stays, and a narrow triangle beside it may be tilted, so
  /// that the polytope is convex only as a surface, within rounding, and not by the planes of its faces. The smallest
  /// distance of the faces still is a lower bound of the depth: the triangles lie in the CSO, their surface surrounds
  /// the origin, and none of them is nearer to the origin than its plane.
  enum class Coplanar : unsigned char { Replaced, Kept };

  /// Begins with a tetrahedron. `rounding` [m]: a vertex that lies less than this above a face counts as in its plane.
  Polytope(const std::array<CsoVertex, 4>& corners, double rounding, Coplanar coplanar = Coplanar::Replaced);

  /// Begins without faces, for recall().
  explicit Polytope(double rounding) : rounding_(rounding), coplanar_(Coplanar::Replaced), is_recalled_(true) {}

  /// Begins with the polytope of an earlier query, its vertices in the present pose. Returns whether every ray from the
  /// origin is proven to meet a face; otherwise the polytope must not be used. Faces at or beyond the distance
  /// `ceiling` [m] will not be returned by closest().
  ///
  /// The polytope need not be convex. Proof: keep() has kept a closed surface, and moved vertices do not open it. So the
  /// number of faces that a ray meets, those whose outer side looks to the origin counted negatively, is the same for
  /// all rays that meet no edge. No face is counted negatively: its height exceeds the rounding error of the
  /// determinant of its corners. So this number counts the faces met by a ray through the inside of one of them, at
  /// least one.
  bool recall(const WarmPolytope& last, const Cso& cso, double ceiling);

  /// True if every ray from the origin still meets a face after expand(), if `smallest` [m] is the distance of the
  /// closest.
  ///
  /// For a polytope that began with a tetrahedron this is said by its convexity. For one that was recalled: to replace
  /// a face by the cone from w changes the number of recall() only if the tetrahedron of both contains the origin. It
  /// does not: its corners lie no more than rounding below the plane of the face, and this plane is farther than twice
  /// the rounding from the origin. A face without a normal has no such plane.
  bool surroundsOrigin(double smallest) const { return !is_recalled_ || (!has_sliver_ && smallest > 2.0 * rounding_); }

  /// Keeps the polytope for recall(). Keeps nothing if it is too large, not closed, or has grown to more than 1.5 times
  /// the vertices, plus four, that it had when it was last begun with a tetrahedron: the next one is begun anew then.
  void keep(WarmPolytope& last) const;

  const CsoVertex& vertex(int index) const { return vertices_[index]; }
  bool hasCorner(const Face& face, const CsoVertex& w) const {
    const auto isAt = [&](int v) { return vertex(v).point == w.point; };
    return isAt(face.vertices[0]) || isAt(face.vertices[1]) || isAt(face.vertices[2]);
  }
  bool full() const { return vertex_count_ == kMaxVertices; }

  /// The face with the smallest distance from the origin, of those closer than the ceiling they were made with and not
  /// set aside. Returns nullptr if there is none.
  const Face* closest() const;

  /// closest() will not return this face again; it stays in the polytope.
  void setAside(const Face& face) { distances_[indexOf(face)] = kNotAsked; }

  const Face& neighbour(const Face& of, std::size_t edge) const { return faceOf(of.twins[edge]); }

  /// Replaces all faces visible from `w`, of which `seen` is one, by the cone from w to their horizon. New faces at or
  /// beyond the distance `ceiling` [m] will not be returned by closest(). Returns false if the horizon is not a single
  /// loop, because of rounding; the polytope must not be expanded again then.
  bool expand(const Face& seen, const CsoVertex& w, double ceiling);

  /// Barycentric weights of the point where the ray from the origin along `direction` meets the plane of a face. A
  /// negative weight says that the ray passes beyond the edge opposite to this vertex.
  std::array<double, 3> rayWeights(const Face& face, const Eigen::Vector3d& direction) const;

  /// For tests: describes the first violation of the invariants that expand() keeps, or returns "". The invariants are:
  /// each half-edge and its twin run along one edge in opposite directions; the faces form one surface with
  /// V - E + F = 2; with Coplanar::Replaced no vertex lies above a face by more than a few roundings. Allocates.
  std::string checkTopology() const;

  template <typename Visit>
  void forEachFace(Visit visit) const {
    for (int f = 0; f < face_end_; ++f)
      if (!face(f).isRemoved()) visit(face(f));
  }

 private:
  static constexpr int kStride = 4;  // a half-edge has the number kStride * face + edge
  static constexpr int kRemoved = -1;

  struct TwoPlanes;
  struct HorizonEdge {
    int half_edge;  // of the face that stays
    int from, to;   // vertices at its ends, counter-clockwise as seen from the new vertex
  };
  Face& face(int index) { return faces_[index]; }
  const Face& face(int index) const { return faces_[index]; }
  int indexOf(const Face& face) const { return static_cast<int>(&face - faces_.data()); }
  // Computed by shifts, because a half-edge is never negative.
  static int indexOf(int half_edge) { return static_cast<int>(static_cast<unsigned>(half_edge) / kStride); }
  static std::size_t edgeOf(int half_edge) { return static_cast<unsigned>(half_edge) % kStride; }
  const Face& faceOf(int half_edge) const { return face(indexOf(half_edge)); }
  int& twinOf(int half_edge) { return face(indexOf(half_edge)).twins[edgeOf(half_edge)]; }
  void addFace(int a, int b, int c);
  int* placesForCone();
  void addCone(int apex, double ceiling);
  void setPlanes(const std::array<int, 2>& faces, const TwoPlanes& planes, double ceiling);
  void setPlane(Face& face);
  void setDistance(int index, double ceiling);
  void join(int half_edge, int twin);
  void removeFace(int index);
  bool sees(const Eigen::Vector3d& w, const Face& candidate) const;
  bool findHorizon(const Face& seen, const Eigen::Vector3d& w);
  std::string checkTwins(int index) const;
  std::string checkEuler() const;
  std::string checkConvexity() const;

  static constexpr double kNotAsked = std::numeric_limits<double>::infinity();

  double rounding_;
  Coplanar coplanar_;
  bool is_recalled_ = false;
  bool has_sliver_ = false;  // there has been a face without a normal
  bool is_open_ = false;     // expand() has found no closed loop
  int vertex_count_ = 0;
  int face_end_ = 0;
  int free_count_ = 0;
  int horizon_size_ = 0;
  std::array<CsoVertex, kMaxVertices> vertices_;
  std::array<Face, kMaxFaces> faces_;
  /// Squares of the distances, with the sign of the distance; kNotAsked where there is no face that closest() may
  /// return.
  alignas(16) std::array<double, kMaxFaces> distances_;
  std::array<int, kMaxFaces + 2> free_faces_;  // two more, as the places of a cone are continued in a circle
  // Each of k removed faces but the first is reached across an edge, so at most k + 2 edges are on the horizon, and no
  // more half-edges wait. A vertex adds two faces at most: there are fewer than 2 kMaxVertices.
  std::array<HorizonEdge, kMaxFaces + 1> horizon_;  // one more, as it is continued in a circle
  std::array<int, kMaxFaces> pending_;              // half-edges through which the horizon is still to be looked for
};

}  // namespace proximity_server::narrowphase
