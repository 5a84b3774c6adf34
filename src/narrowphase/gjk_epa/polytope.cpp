#include "narrowphase/gjk_epa/polytope.h"

#include <limits>

#include "narrowphase/shape/triangle.h"

namespace proximity_server::narrowphase {

using Eigen::Vector3d;

Polytope::Polytope(const std::array<CsoVertex, 4>& corners, double rounding) : rounding_(rounding) {
  for (const CsoVertex& corner : corners) vertices_[vertex_count_++] = corner;
  const Vector3d& o = corners[3].point;
  const double volume = (corners[0].point - o).dot((corners[1].point - o).cross(corners[2].point - o));
  const int a = 0, b = volume > 0.0 ? 1 : 2, c = volume > 0.0 ? 2 : 1;
  // The faces are a b c, b a d, c b d, a c d (d is vertex 3), each counter-clockwise from outside.
  constexpr double kNoCeiling = std::numeric_limits<double>::infinity();
  const int abc = kStride * addFace(a, b, c, kNoCeiling), bad = kStride * addFace(b, a, 3, kNoCeiling),
            cbd = kStride * addFace(c, b, 3, kNoCeiling), acd = kStride * addFace(a, c, 3, kNoCeiling);
  join(abc, bad);
  join(abc + 1, cbd);
  join(abc + 2, acd);
  join(bad + 1, acd + 2);
  join(cbd + 1, bad + 2);
  join(acd + 1, cbd + 2);
}

int Polytope::addFace(int a, int b, int c, double ceiling) {
  const int index = free_count_ > 0 ? free_faces_[--free_count_] : face_end_++;
  Face& f = face(index);
  f.vertices = {a, b, c};
  f.serial = next_serial_++;
  const Vector3d &pa = vertex(a).point, &pb = vertex(b).point, &pc = vertex(c).point;
  const Vector3d ab = pb - pa, bc = pc - pb, ca = pa - pc;
  const double longest2 = std::max({ab.squaredNorm(), bc.squaredNorm(), ca.squaredNorm()});
  f.area = areaVector(ab, bc, ca);
  f.area2 = f.area.squaredNorm();
  f.height = std::min({f.area.dot(pa), f.area.dot(pb), f.area.dot(pc)});
  // A triangle that is less wide than the rounding of its vertices has no normal. Written as !(>) so that NaN has none.
  if (!(f.area2 > rounding_ * rounding_ * longest2)) {
    f.area.setZero();
    f.area2 = f.height = 0.0;
  } else if (f.isCloserThan(ceiling)) {
    heapPush({f.height * std::abs(f.height) / f.area2, index, f.serial});
  }
  return index;
}

void Polytope::join(int half_edge, int twin) {
  face(half_edge / kStride).twins[half_edge % kStride] = twin;
  face(twin / kStride).twins[twin % kStride] = half_edge;
}

void Polytope::removeFace(int index) {
  face(index).serial = 0;
  free_faces_[free_count_++] = index;
}

void Polytope::dropStale() {
  const auto stale = [this](const HeapEntry& e) { return face(e.face).serial != e.serial; };
  const auto farther = [](const HeapEntry& a, const HeapEntry& b) { return a.distance2 > b.distance2; };
  heap_size_ = static_cast<int>(std::remove_if(heap_.begin(), heap_.begin() + heap_size_, stale) - heap_.begin());
  std::make_heap(heap_.begin(), heap_.begin() + heap_size_, farther);
}

void Polytope::heapPush(const HeapEntry& entry) {
  if (heap_size_ == static_cast<int>(heap_.size())) dropStale();
  int hole = heap_size_++;
  for (; hole > 0; hole = (hole - 1) / 2) {
    const HeapEntry& parent = heap_[(hole - 1) / 2];
    if (!(entry.distance2 < parent.distance2)) break;
    heap_[hole] = parent;
  }
  heap_[hole] = entry;
}

/// The hole at the top sinks to a leaf, and the closer child moves up each time: this needs no branch. Then the last
/// entry is put into the hole, and rises from there.
void Polytope::heapPop() {
  const HeapEntry last = heap_[--heap_size_];
  int hole = 0;
  for (int child = 2; child <= heap_size_; child = 2 * hole + 2) {
    child -= static_cast<int>(heap_[child - 1].distance2 < heap_[child].distance2);
    heap_[hole] = heap_[child];
    hole = child;
  }
  for (; hole > 0; hole = (hole - 1) / 2) {
    const HeapEntry& parent = heap_[(hole - 1) / 2];
    if (!(last.distance2 < parent.distance2)) break;
    heap_[hole] = parent;
  }
  heap_[hole] = last;
}

const Polytope::Face* Polytope::closest() {
  for (; heap_size_ > 0; heapPop()) {
    const HeapEntry& top = heap_.front();
    if (face(top.face).serial == top.serial) return &face(top.face);
  }
  return nullptr;
}

/// Heights within rounding count as visible: a face in one plane with w is replaced by the cone, and so is a face
/// without a normal.
bool Polytope::sees(const Vector3d& w, const Face& candidate) const {
  const double height = candidate.area.dot(w - vertex(candidate.vertices[0]).point);
  return !(height < 0.0 && height * height > rounding_ * rounding_ * candidate.area2);
}

/// Visits the faces visible from w, depth first, each entered through `half_edge`, and removes them. The half-edges of
/// the faces that stay are found in the order of the horizon, counter-clockwise as seen from w.
void Polytope::findHorizon(int half_edge, const Vector3d& w) {
  const Face& f = face(half_edge / kStride);
  if (f.serial == 0) return;
  const auto entry = static_cast<std::size_t>(half_edge % kStride), second = (entry + 1) % 3, third = (entry + 2) % 3;
  if (!sees(w, f)) {
    horizon_[horizon_size_++] = {half_edge, f.vertices[second], f.vertices[entry]};
    return;
  }
  removeFace(half_edge / kStride);
  findHorizon(f.twins[second], w);
  findHorizon(f.twins[third], w);
}

bool Polytope::isLoop() const {
  if (horizon_size_ < 3) return false;
  int end = horizon_[horizon_size_ - 1].to;
  for (int i = 0; i < horizon_size_; ++i) {
    const HorizonEdge& edge = horizon_[i];
    if (edge.from != end) return false;
    end = edge.to;
  }
  return true;
}

bool Polytope::expand(const Face& seen, const CsoVertex& w, double ceiling) {
  horizon_size_ = 0;
  removeFace(static_cast<int>(&seen - faces_.data()));
  for (const int twin : seen.twins) findHorizon(twin, w.point);
  if (!isLoop()) return false;

  const int apex = vertex_count_++;
  vertices_[apex] = w;
  int first = -1, previous = -1;
  for (int i = 0; i < horizon_size_; ++i) {
    const HorizonEdge& edge = horizon_[i];
    const int added = kStride * addFace(edge.from, edge.to, apex, ceiling);
    join(added, edge.half_edge);
    if (previous >= 0)
      join(previous + 1, added + 2);
    else
      first = added;
    previous = added;
  }
  join(previous + 1, first + 2);
  return true;
}

std::array<double, 3> Polytope::rayWeights(const Face& f, const Vector3d& direction) const {
  const Vector3d &a = vertex(f.vertices[0]).point, &b = vertex(f.vertices[1]).point, &c = vertex(f.vertices[2]).point;
  const double of_a = direction.dot(b.cross(c - b)), of_b = direction.dot(c.cross(a - c)),
               of_c = direction.dot(a.cross(b - a));
  const double sum = of_a + of_b + of_c;
  return {of_a / sum, of_b / sum, of_c / sum};
}

std::string Polytope::checkTwins(int index) const {
  const Face& f = face(index);
  for (int edge = 0; edge < 3; ++edge) {
    const std::string name = "edge " + std::to_string(edge) + " of face " + std::to_string(index);
    const int twin = f.twins[edge], there = twin % kStride;
    if (twin < 0 || twin / kStride >= face_end_ || there > 2) return name + " has a twin that is no half-edge";
    const Face& next = face(twin / kStride);
    if (next.serial == 0) return name + " borders on a removed face";
    if (next.twins[there] != kStride * index + edge) return name + " is not the twin of its twin";
    const int from = f.vertices[edge], to = f.vertices[(edge + 1) % 3];
    const int from_there = next.vertices[there];
    const int to_there = next.vertices[(there + 1) % 3];
    if (from == to) return name + " begins and ends in one vertex";
    if (from != to_there || to != from_there) return name + " and its twin do not run along the same edge";
  }
  return "";
}

std::string Polytope::checkEuler() const {
  std::array<bool, kMaxVertices> is_used{};
  int vertices = 0, half_edges = 0, faces = 0;
  forEachFace([&](const Face& f) {
    ++faces;
    half_edges += 3;
    for (const int v : f.vertices) {
      vertices += is_used[v] ? 0 : 1;
      is_used[v] = true;
    }
  });
  const int characteristic = vertices - half_edges / 2 + faces;
  if (half_edges % 2 == 0 && characteristic == 2) return "";
  return "V - E + F is " + std::to_string(characteristic) + " and not 2";
}

std::string Polytope::checkConvexity() const {
  // expand() removes faces within one rounding of w, and the planes of both faces are rounded, too.
  constexpr double kRoundings = 4.0;
  std::string wrong;
  forEachFace([&](const Face& f) {
    if (!f.hasNormal()) return;
    const Vector3d normal = f.normal(), &on_face = vertex(f.vertices[0]).point;
    forEachFace([&](const Face& other) {
      for (const int v : other.vertices) {
        const double above = normal.dot(vertex(v).point - on_face);
        if (wrong.empty() && above > kRoundings * rounding_)
          wrong = "vertex " + std::to_string(v) + " lies " + std::to_string(above) + " m above a face";
      }
    });
  });
  return wrong;
}

std::string Polytope::checkTopology() const {
  for (int f = 0; f < face_end_; ++f) {
    if (face(f).serial == 0) continue;
    const std::string wrong = checkTwins(f);
    if (!wrong.empty()) return wrong;
  }
  const std::string wrong = checkEuler();
  return wrong.empty() ? checkConvexity() : wrong;
}

}  // namespace proximity_server::narrowphase
