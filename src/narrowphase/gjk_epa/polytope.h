#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "proximity_server/narrowphase/gjk_epa/cso.h"

namespace proximity_server::narrowphase {

/// A closed convex polytope of CSO vertices in fixed storage: EPA's topology. It knows faces, neighbours and the
/// horizon, and which face is closest to the origin; when to stop is EPA's to decide.
class Polytope {
 public:
  static constexpr int kMaxVertices = 512;
  static constexpr int kMaxFaces = 2 * kMaxVertices;

  /// A triangle by its area vector and what follows from it without root or division: most faces are never asked for
  /// their normal or distance.
  struct Face {
    std::array<int, 3> vertices;  ///< counter-clockwise from outside
    std::array<int, 3> twins;     ///< of the edge from vertices[i] to the next: the half-edge of the neighbour
    Eigen::Vector3d area;         ///< outward, of twice the area; zero for a sliver without a normal: it is never the
                                  ///< closest, and every new vertex sees it
    double area2;                 ///< squared norm of the area vector
    double height;                ///< of its lowest corner over the origin along the area vector, times its length:
                                  ///< less than that of its plane, by the rounding of the area vector
    int serial;                   ///< tells a face from its successors in the same place; 0 where there is none

    bool hasNormal() const { return area2 > 0.0; }
    Eigen::Vector3d normal() const { return area / std::sqrt(area2); }  ///< unit
    double distance() const { return height / std::sqrt(area2); }       ///< [m] from the origin, along the normal
    /// Whether the distance is less than `limit` [m]; false for a sliver.
    bool isCloserThan(double limit) const { return height * std::abs(height) < limit * std::abs(limit) * area2; }
  };

  /// The tetrahedron of the first four vertices. `rounding` [m]: heights below it count as none.
  Polytope(const std::array<CsoVertex, 4>& corners, double rounding);

  const CsoVertex& vertex(int index) const { return vertices_[static_cast<std::size_t>(index)]; }
  bool hasCorner(const Face& face, const CsoVertex& w) const {
    return std::any_of(face.vertices.begin(), face.vertices.end(), [&](int v) { return vertex(v).point == w.point; });
  }
  bool full() const { return vertex_count_ == kMaxVertices; }

  /// The living face with the smallest distance, of those below every ceiling since they were made; nullptr where there
  /// is none.
  const Face* closest();

  /// What closest() named last will not be named again.
  void setClosestAside() { heapPop(); }

  const Face& neighbour(const Face& of, std::size_t edge) const { return face(of.twins[edge] / kStride); }

  /// Replaces all faces that `w` sees by the cone from w to their horizon; new faces as far as `ceiling` [m] will never
  /// be asked for as the closest. False where that is no single loop, or w sees nothing: rounding has the last word
  /// there and the polytope can no longer be used for more than looking.
  bool expand(const Face& seen, const CsoVertex& w, double ceiling);

  /// Weights of the point where the ray from the origin along `direction` meets the plane of a face; a negative one
  /// says that it passes beyond that edge.
  std::array<double, 3> rayWeights(const Face& face, const Eigen::Vector3d& direction) const;

  /// For tests: describes the first violation of what expand() promises to keep; "" where there is none. That is: each
  /// half-edge and its twin run along one edge in opposite directions, the living faces form one surface with
  /// V - E + F = 2, and no vertex of it lies above a face by more than a few roundings. Allocates.
  std::string checkTopology() const;

  template <typename Visit>
  void forEachFace(Visit visit) const {
    for (int f = 0; f < face_end_; ++f)
      if (face(f).serial != 0) visit(face(f));
  }

 private:
  static constexpr int kStride = 4;  // half-edge of a face: kStride * face + edge

  struct HorizonEdge {
    int half_edge;  // of the face that stays
    int from, to;   // its ends, counter-clockwise from the new vertex
  };
  struct HeapEntry {
    double distance2;  // squared, with the sign of the distance
    int face, serial;
  };

  Face& face(int index) { return faces_[static_cast<std::size_t>(index)]; }
  const Face& face(int index) const { return faces_[static_cast<std::size_t>(index)]; }
  int addFace(int a, int b, int c, double ceiling);
  void join(int half_edge, int twin);
  void removeFace(int index);
  bool sees(const Eigen::Vector3d& w, const Face& candidate) const;
  void findHorizon(int half_edge, const Eigen::Vector3d& w);
  bool isLoop() const;
  std::string checkTwins(int index) const;
  std::string checkEuler() const;
  std::string checkConvexity() const;
  void heapPush(const HeapEntry& entry);
  void heapPop();
  void dropStale();

  double rounding_;
  int vertex_count_ = 0;
  int face_end_ = 0;
  int free_count_ = 0;
  int heap_size_ = 0;
  int horizon_size_ = 0;
  int next_serial_ = 1;
  std::array<CsoVertex, kMaxVertices> vertices_;
  std::array<Face, kMaxFaces> faces_;
  std::array<int, kMaxFaces> free_faces_;
  std::array<HeapEntry, 2 * kMaxFaces> heap_;
  std::array<HorizonEdge, kMaxFaces> horizon_;
};

}  // namespace proximity_server::narrowphase
