#include "narrowphase/cso/polytope.h"

#include "narrowphase/shape/triangle.h"
#include "proximity_server/narrowphase/assertion.h"

#include <cstring>
#include <limits>

namespace proximity_server::narrowphase {

using Eigen::Vector3d;

namespace {

constexpr std::array<std::size_t, 3> kNext{1, 2, 0};  // of the corners of a triangle
constexpr int kBlock = 8;                             // of the distances that closest() compares at a time
static_assert(Polytope::kMaxFaces % kBlock == 0, "the last block ends with the array");

/// Two numbers, with which all processors compute at once, and two vectors.
using Two = double __attribute__((vector_size(16)));
struct TwoVectors {
  Two x, y, z;
};

TwoVectors both(const Vector3d& first, const Vector3d& second) {
  return {Two{first.x(), second.x()}, Two{first.y(), second.y()}, Two{first.z(), second.z()}};
}
TwoVectors operator-(const TwoVectors& u, const TwoVectors& v) { return {u.x - v.x, u.y - v.y, u.z - v.z}; }
Two dot(const TwoVectors& u, const TwoVectors& v) { return u.x * v.x + u.y * v.y + u.z * v.z; }
TwoVectors cross(const TwoVectors& u, const TwoVectors& v) {
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}
Two lesser(const Two& u, const Two& v) { return u < v ? u : v; }
Two greater(const Two& u, const Two& v) { return u > v ? u : v; }

}  // namespace

/// The planes of two triangles. The area vector is the cross product of the two edges at the apex.
struct Polytope::TwoPlanes {
  TwoVectors area;
  Two area2, height;  // as in a face
  Two longer2;        // square of the longer edge at the apex

  static TwoPlanes of(const TwoVectors& from, const TwoVectors& to, const TwoVectors& apex) {
    const TwoVectors from_edge = from - apex, to_edge = to - apex;
    const TwoVectors area = cross(from_edge, to_edge);
    const Two height = lesser(lesser(dot(area, from), dot(area, to)), dot(area, apex));
    return {area, dot(area, area), height, greater(dot(from_edge, from_edge), dot(to_edge, to_edge))};
  }
};

Polytope::Polytope(const std::array<CsoVertex, 4>& corners, double rounding, Coplanar coplanar)
    : rounding_(rounding), coplanar_(coplanar) {
  for (const CsoVertex& corner : corners) vertices_[vertex_count_++] = corner;
  const Vector3d& o = corners[3].point;
  const double volume = (corners[0].point - o).dot((corners[1].point - o).cross(corners[2].point - o));
  const int a = 0, b = volume > 0.0 ? 1 : 2, c = volume > 0.0 ? 2 : 1;
  // Each counter-clockwise from outside; d is vertex 3.
  constexpr int abc = 0, bad = kStride, cbd = 2 * kStride, acd = 3 * kStride;
  std::fill_n(distances_.begin(), kBlock, kNotAsked);
  addFace(a, b, c);
  addFace(b, a, 3);
  addFace(c, b, 3);
  addFace(a, c, 3);
  join(abc, bad);
  join(abc + 1, cbd);
  join(abc + 2, acd);
  join(bad + 1, acd + 2);
  join(cbd + 1, bad + 2);
  join(acd + 1, cbd + 2);
}

void Polytope::addFace(int a, int b, int c) {
  PROXIMITY_ASSERT(a != b && b != c && c != a,
                   "A face has a corner twice: the horizon is not a loop of different vertices, see findHorizon().");
  const int index = face_end_++;
  Face& f = face(index);
  f.vertices = {a, b, c};
  setPlane(f);
  setDistance(index, std::numeric_limits<double>::infinity());
}

/// Sets the area vector and the height of a face.
void Polytope::setPlane(Face& f) {
  const Vector3d &a = vertex(f.vertices[0]).point, &b = vertex(f.vertices[1]).point, &c = vertex(f.vertices[2]).point;
  const Vector3d ab = b - a, bc = c - b, ca = a - c;
  const double longest2 = std::max({ab.squaredNorm(), bc.squaredNorm(), ca.squaredNorm()});
  f.area = areaVector(ab, bc, ca);
  f.area2 = f.area.squaredNorm();
  f.height = std::min({f.area.dot(a), f.area.dot(b), f.area.dot(c)});
  // A triangle that is less wide than the rounding of its vertices has no normal. Written as !(>) so that NaN has none.
  if (!(f.area2 > rounding_ * rounding_ * longest2)) {
    f.area.setZero();
    f.area2 = f.height = 0.0;
    has_sliver_ = true;
  }
}

void Polytope::setDistance(int index, double ceiling) {
  const Face& f = face(index);
  distances_[index] = f.isCloserThan(ceiling) ? f.height * std::abs(f.height) / f.area2 : kNotAsked;
}

void Polytope::join(int half_edge, int twin) {
  twinOf(half_edge) = twin;
  twinOf(twin) = half_edge;
}

void Polytope::removeFace(int index) {
  face(index).vertices[0] = kRemoved;
  distances_[index] = kNotAsked;
  free_faces_[free_count_++] = index;
}

const Polytope::Face* Polytope::closest() const {
  // Two distances in a vector, and four minima that do not wait for each other.
  const auto load = [this](int from) {
    Two two;
    std::memcpy(&two, &distances_[from], sizeof two);
    return two;
  };
  std::array<Two, 4> smallest{load(0), load(2), load(4), load(6)};
  for (int from = kBlock; from < face_end_; from += kBlock)
    for (int i = 0; i < 4; ++i) smallest[i] = lesser(load(from + 2 * i), smallest[i]);
  const Two smallest_two = lesser(lesser(smallest[0], smallest[1]), lesser(smallest[2], smallest[3]));
  const double distance = std::min(smallest_two[0], smallest_two[1]);
  if (distance == kNotAsked) return nullptr;
  return &faces_[std::find(distances_.begin(), distances_.begin() + face_end_, distance) - distances_.begin()];
}

/// A face without a normal counts as visible, so that the cone replaces it.
bool Polytope::sees(const Vector3d& w, const Face& candidate) const {
  const double height = candidate.area.dot(w) - candidate.height;
  const bool is_beside = height * height > rounding_ * rounding_ * candidate.area2;
  if (is_beside) return height > 0.0;
  return coplanar_ == Coplanar::Replaced || !candidate.hasNormal();
}

/// Removes the faces visible from w, beginning with `seen`, and visits their neighbours depth first. The half-edges of
/// the faces that stay are found in the order of the horizon, counter-clockwise as seen from w. Returns whether they
/// are one closed loop: as many of them begin as end at each vertex, so a chain of all of them is closed.
bool Polytope::findHorizon(const Face& seen, const Vector3d& w) {
  horizon_size_ = 0;
  removeFace(indexOf(seen));
  pending_[0] = seen.twins[2];
  pending_[1] = seen.twins[1];
  pending_[2] = seen.twins[0];
  bool is_chain = true;
  for (int count = 3; count > 0;) {
    const int half_edge = pending_[--count], index = indexOf(half_edge);
    const Face& f = face(index);
    if (f.isRemoved()) continue;
    const std::size_t entry = edgeOf(half_edge), second = kNext[entry], third = kNext[second];
    if (!sees(w, f)) {
      const HorizonEdge edge{half_edge, f.vertices[second], f.vertices[entry]};
      is_chain &= horizon_size_ == 0 || edge.from == horizon_[horizon_size_ - 1].to;
      horizon_[horizon_size_++] = edge;
      continue;
    }
    removeFace(index);
    pending_[count++] = f.twins[third];
    pending_[count++] = f.twins[second];
  }
  return is_chain && horizon_size_ >= 3;
}

/// Takes a free place for each face of the cone. Behind the last place there is room for two more.
int* Polytope::placesForCone() {
  while (free_count_ < horizon_size_) {
    // closest() compares the distances in blocks.
    if (face_end_ % kBlock == 0) std::fill_n(distances_.begin() + face_end_, kBlock, kNotAsked);
    free_faces_[free_count_++] = face_end_++;
  }
  free_count_ -= horizon_size_;
  return &free_faces_[free_count_];
}

/// Sets the planes and distances of two faces. It is inlined explicitly: as a call from recall() it takes 7 % of a query
/// that begins with the last polytope.
[[gnu::always_inline]] inline void Polytope::setPlanes(const std::array<int, 2>& faces, const TwoPlanes& planes,
                                                       double ceiling) {
  const Two ceiling2 = Two{} + ceiling * std::abs(ceiling), not_asked = Two{} + kNotAsked;
  const Two height2 = planes.height * greater(planes.height, -planes.height);  // with the sign of the height
  const Two distance2 = height2 < ceiling2 * planes.area2 ? height2 / planes.area2 : not_asked;
  // For a triangle that is not narrow at the apex this is as accurate as its shortest edges; see areaVector(). The
  // third edge is at most twice as long as the longer of the other two.
  constexpr double kNarrow = 1e-4;
  const Two narrow2 = greater(kNarrow * planes.longer2, Two{} + 4.0 * rounding_ * rounding_);
  const auto is_wide = planes.area2 > planes.longer2 * narrow2;
  for (int lane = 0; lane < 2; ++lane) {
    Face& f = face(faces[lane]);
    f.area = Vector3d(planes.area.x[lane], planes.area.y[lane], planes.area.z[lane]);
    f.area2 = planes.area2[lane];
    f.height = planes.height[lane];
    distances_[faces[lane]] = distance2[lane];
    if (is_wide[lane]) continue;
    setPlane(f);
    setDistance(faces[lane], ceiling);
  }
}

/// Adds a triangle from each edge of the horizon to the apex, two at a time. If their number is odd, the first is made
/// twice.
void Polytope::addCone(int apex, double ceiling) {
  int* const places = placesForCone();
  places[horizon_size_] = places[0];
  places[horizon_size_ + 1] = places[1];
  horizon_[horizon_size_] = horizon_[0];
  int previous = places[horizon_size_ - 1];
  const TwoVectors w = both(vertex(apex).point, vertex(apex).point);
  for (int i = 0; i < horizon_size_; i += 2) {
    for (int j = i; j < i + 2; ++j) {
      const HorizonEdge& edge = horizon_[j];
      Face& f = face(places[j]);
      f.vertices = {edge.from, edge.to, apex};
      f.twins = {edge.half_edge, kStride * places[j + 1] + 2, kStride * previous + 1};
      twinOf(edge.half_edge) = kStride * places[j];
      previous = places[j];
    }
    const Vector3d& middle = vertex(horizon_[i].to).point;
    const TwoVectors from = both(vertex(horizon_[i].from).point, middle);
    const TwoVectors to = both(middle, vertex(horizon_[i + 1].to).point);
    setPlanes({places[i], places[i + 1]}, TwoPlanes::of(from, to, w), ceiling);
  }
}

bool Polytope::expand(const Face& seen, const CsoVertex& w, double ceiling) {
  PROXIMITY_ASSERT(!full(), "There is no room for another vertex: look at full() before each expansion.");
  PROXIMITY_ASSERT(!seen.isRemoved(),
                   "The face was removed by an earlier vertex: ask closest() again after each expansion.");
  is_open_ = !findHorizon(seen, w.point);
  if (is_open_) return false;
  const int apex = vertex_count_++;
  vertices_[apex] = w;
  addCone(apex, ceiling);
  return true;
}

bool Polytope::recall(const WarmPolytope& last, const Cso& cso, double ceiling) {
  if (last.face_count_ == 0) return false;
  vertex_count_ = last.vertex_count_;
  for (int v = 0; v < vertex_count_; ++v) vertices_[v] = cso.recalled(last.vertices_[v]);
  face_end_ = last.face_count_;
  std::fill_n(distances_.begin() + face_end_ / kBlock * kBlock, kBlock, kNotAsked);
  for (int f = 0; f < face_end_; f += 2) {
    for (int i = f; i < f + 2; ++i) {
      std::copy_n(last.faces_[i].vertices.begin(), 3, face(i).vertices.begin());
      std::copy_n(last.faces_[i].twins.begin(), 3, face(i).twins.begin());
    }
    const auto corners = [&](int i) {
      return both(vertex(face(f).vertices[i]).point, vertex(face(f + 1).vertices[i]).point);
    };
    const TwoPlanes planes = TwoPlanes::of(corners(0), corners(1), corners(2));
    setPlanes({f, f + 1}, planes, ceiling);
    // With R the length of a corner and l the longest edge, the area vector has an error of 7 eps l^2 at most, and its
    // product with a corner has one of 1.5 eps R l^2 more: 8.5 eps R l^2 for the determinant of the corners. The
    // rounding is at least 8 eps R, and l at most twice the longer edge at the apex.
    for (int lane = 0; lane < 2; ++lane)
      if (!(face(f + lane).height > 8.0 * rounding_ * planes.longer2[lane])) return false;
  }
  return true;
}

void Polytope::keep(WarmPolytope& last) const {
  last.forget();
  if (is_open_) return;
  std::array<int, kMaxFaces> places;
  std::array<int, kMaxVertices> numbers;
  std::fill_n(numbers.begin(), vertex_count_, -1);
  int faces = 0, vertices = 0;
  for (int f = 0; f < face_end_; ++f)
    if (!face(f).isRemoved()) places[f] = faces++;
  if (faces > WarmPolytope::kMaxFaces) return;
  for (int f = 0; f < face_end_; ++f) {
    if (face(f).isRemoved()) continue;
    WarmPolytope::Triangle& triangle = last.faces_[places[f]];
    for (int i = 0; i < 3; ++i) {
      const int v = face(f).vertices[i], twin = face(f).twins[i];
      if (numbers[v] < 0) {
        if (vertices == WarmPolytope::kMaxVertices) return;
        last.vertices_[vertices] = vertex(v).numbers;
        numbers[v] = vertices++;
      }
      triangle.vertices[i] = static_cast<std::uint16_t>(numbers[v]);
      triangle.twins[i] = static_cast<std::uint16_t>(kStride * places[indexOf(twin)] + twin % kStride);
    }
  }
  if (!is_recalled_) last.cold_vertices_ = vertices;
  // expand() has room for the faces of kMaxVertices vertices on a sphere, 2 V - 4.
  if (vertices > 1.5 * last.cold_vertices_ + 4.0 || faces > 2 * vertices - 4) return;
  last.vertex_count_ = vertices;
  last.face_count_ = faces;
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
    if (twin < 0 || indexOf(twin) >= face_end_ || there > 2) return name + " has a twin that is no half-edge";
    const Face& next = faceOf(twin);
    if (next.isRemoved()) return name + " borders on a removed face";
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
    if (face(f).isRemoved()) continue;
    const std::string wrong = checkTwins(f);
    if (!wrong.empty()) return wrong;
  }
  const std::string wrong = checkEuler();
  return wrong.empty() && coplanar_ == Coplanar::Replaced ? checkConvexity() : wrong;
}

}  // namespace proximity_server::narrowphase
