#include "polytope.h"

#include <limits>

#include "triangle.h"

namespace proximity_server {
namespace {

using Eigen::Vector3d;

std::size_t next(std::size_t edge) { return edge == 2 ? 0 : edge + 1; }

}  // namespace

Polytope::Polytope(const std::array<CsoVertex, 4>& corners, double rounding) : rounding_(rounding) {
  for (const CsoVertex& corner : corners) vertices_[static_cast<std::size_t>(vertex_count_++)] = corner;
  const Vector3d& o = corners[3].point;
  const double volume = (corners[0].point - o).dot((corners[1].point - o).cross(corners[2].point - o));
  const int a = 0, b = volume > 0.0 ? 1 : 2, c = volume > 0.0 ? 2 : 1;
  // Faces a b c, b a d, c b d, a c d, each counter-clockwise from outside.
  constexpr double kNoCeiling = std::numeric_limits<double>::infinity();
  const int abc = addFace(a, b, c, kNoCeiling), bad = addFace(b, a, 3, kNoCeiling), cbd = addFace(c, b, 3, kNoCeiling),
            acd = addFace(a, c, 3, kNoCeiling);
  face(abc).neighbours = {bad, cbd, acd};
  face(bad).neighbours = {abc, acd, cbd};
  face(cbd).neighbours = {abc, bad, acd};
  face(acd).neighbours = {abc, cbd, bad};
}

int Polytope::addFace(int a, int b, int c, double ceiling) {
  const int index = free_count_ > 0 ? free_faces_[static_cast<std::size_t>(--free_count_)] : face_end_++;
  Face& f = face(index);
  f.vertices = {a, b, c};
  f.serial = next_serial_++;
  const Vector3d &pa = vertex(a).point, &pb = vertex(b).point, &pc = vertex(c).point;
  const Vector3d ab = pb - pa, bc = pc - pb, ca = pa - pc;
  const Vector3d area = areaVector(ab, bc, ca);
  const double longest2 = std::max({ab.squaredNorm(), bc.squaredNorm(), ca.squaredNorm()});
  const double area2 = area.squaredNorm();
  // A height below the rounding of the vertices gives no normal. Written as !(>) so that NaN is a sliver too.
  if (!(area2 > rounding_ * rounding_ * longest2)) {
    f.normal = Vector3d::Zero();
    f.distance = std::numeric_limits<double>::infinity();
    return index;
  }
  f.normal = area / std::sqrt(area2);
  f.distance = f.normal.dot(pa);
  if (f.distance < ceiling) heapPush(index);
  return index;
}

void Polytope::removeFace(int index) {
  face(index).serial = 0;
  free_faces_[static_cast<std::size_t>(free_count_++)] = index;
}

void Polytope::heapPush(int index) {
  const auto farther = [](const HeapEntry& a, const HeapEntry& b) { return a.distance > b.distance; };
  if (heap_size_ == static_cast<int>(heap_.size())) {
    const auto stale = [this](const HeapEntry& e) { return face(e.face).serial != e.serial; };
    heap_size_ = static_cast<int>(std::remove_if(heap_.begin(), heap_.end(), stale) - heap_.begin());
    std::make_heap(heap_.begin(), heap_.begin() + heap_size_, farther);
  }
  heap_[static_cast<std::size_t>(heap_size_++)] = {face(index).distance, index, face(index).serial};
  std::push_heap(heap_.begin(), heap_.begin() + heap_size_, farther);
}

void Polytope::heapPop() {
  const auto farther = [](const HeapEntry& a, const HeapEntry& b) { return a.distance > b.distance; };
  std::pop_heap(heap_.begin(), heap_.begin() + heap_size_, farther);
  --heap_size_;
}

const Polytope::Face* Polytope::closest() {
  for (; heap_size_ > 0; heapPop()) {
    const HeapEntry& top = heap_.front();
    if (face(top.face).serial == top.serial) return &face(top.face);
  }
  return nullptr;
}

/// Heights within rounding count as visible: a face coplanar with w merges into the cone, one without a normal goes.
bool Polytope::sees(const CsoVertex& w, const Face& candidate) const {
  return !(candidate.normal.dot(w.point - vertex(candidate.vertices[0]).point) < -rounding_);
}

/// Walks over the faces that w sees, depth first, entered through an edge each; the edges where it stops come out in
/// order, counter-clockwise from w.
void Polytope::findHorizon(int seen, int entry_edge, const CsoVertex& w) {
  const Face& f = face(seen);
  if (f.serial == 0) return;
  if (!sees(w, f)) {
    horizon_[static_cast<std::size_t>(horizon_size_++)] = {seen, entry_edge};
    return;
  }
  removeFace(seen);
  for (std::size_t edge = next(static_cast<std::size_t>(entry_edge)); edge != static_cast<std::size_t>(entry_edge);
       edge = next(edge))
    visitNeighbour(f, edge, w);
}

void Polytope::visitNeighbour(const Face& f, std::size_t edge, const CsoVertex& w) {
  const int neighbour = f.neighbours[edge];
  const int shared_end = f.vertices[next(edge)];  // where the neighbour begins the shared edge
  const auto& corners = face(neighbour).vertices;
  const auto entry = std::find(corners.begin(), corners.end(), shared_end) - corners.begin();
  findHorizon(neighbour, static_cast<int>(entry), w);
}

bool Polytope::isLoop() const {
  if (horizon_size_ < 3) return false;
  const auto edgeOf = [this](int i) {
    const HorizonEdge& h = horizon_[static_cast<std::size_t>(i)];
    const auto e = static_cast<std::size_t>(h.edge);
    return std::make_pair(face(h.face).vertices[next(e)], face(h.face).vertices[e]);
  };
  for (int i = 0; i < horizon_size_; ++i)
    if (edgeOf(i).second != edgeOf((i + 1) % horizon_size_).first) return false;
  return true;
}

bool Polytope::expand(const Face& seen, const CsoVertex& w, double ceiling) {
  const Face start = seen;
  horizon_size_ = 0;
  removeFace(static_cast<int>(&seen - faces_.data()));
  for (std::size_t edge = 0; edge < 3; ++edge) visitNeighbour(start, edge, w);
  if (!isLoop()) return false;

  const int apex = vertex_count_++;
  vertices_[static_cast<std::size_t>(apex)] = w;
  int first = -1, previous = -1;
  for (int i = 0; i < horizon_size_; ++i) {
    const HorizonEdge h = horizon_[static_cast<std::size_t>(i)];
    const auto edge = static_cast<std::size_t>(h.edge);
    const int from = face(h.face).vertices[next(edge)], to = face(h.face).vertices[edge];
    const int added = addFace(from, to, apex, ceiling);
    face(added).neighbours[0] = h.face;
    face(h.face).neighbours[edge] = added;
    if (previous >= 0) {
      face(previous).neighbours[1] = added;
      face(added).neighbours[2] = previous;
    } else {
      first = added;
    }
    previous = added;
  }
  face(previous).neighbours[1] = first;
  face(first).neighbours[2] = previous;
  return true;
}

std::array<double, 3> Polytope::rayWeights(const Face& f, const Vector3d& direction) const {
  const Vector3d &a = vertex(f.vertices[0]).point, &b = vertex(f.vertices[1]).point, &c = vertex(f.vertices[2]).point;
  const double of_a = direction.dot(b.cross(c - b)), of_b = direction.dot(c.cross(a - c)),
               of_c = direction.dot(a.cross(b - a));
  const double sum = of_a + of_b + of_c;
  return {of_a / sum, of_b / sum, of_c / sum};
}

}  // namespace proximity_server
