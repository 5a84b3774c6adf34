#include "oracle/exact_oracle.h"

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

namespace proximity_server::narrowphase {
namespace {

template <typename Number>
using Vector = std::array<Number, 3>;
using Integers = Vector<mpz_class>;

template <typename Number>
Vector<Number> operator-(const Vector<Number>& x, const Vector<Number>& y) {
  return {x[0] - y[0], x[1] - y[1], x[2] - y[2]};
}

template <typename Number>
Number dot(const Vector<Number>& x, const Vector<Number>& y) {
  return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}

Integers cross(const Integers& x, const Integers& y) {
  return {x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]};
}

Integers negative(const Integers& x) { return {-x[0], -x[1], -x[2]}; }
bool isZero(const Integers& x) { return x[0] == 0 && x[1] == 0 && x[2] == 0; }

std::vector<Eigen::Vector3d> verticesOf(const Shape& shape) {
  if (shape.kind() == Shape::Kind::Hull) return shape.hull().vertices();
  // Some of the corners of a segment and of a point are equal, which does no harm.
  std::vector<Eigen::Vector3d> corners;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      for (const double z : {-1.0, 1.0}) corners.push_back(shape.halfExtents().cwiseProduct(Eigen::Vector3d(x, y, z)));
  return corners;
}

using Rationals = std::vector<Vector<mpq_class>>;

Rationals exactly(const std::vector<Eigen::Vector3d>& points) {
  Rationals result;
  for (const Eigen::Vector3d& p : points) result.push_back({mpq_class(p.x()), mpq_class(p.y()), mpq_class(p.z())});
  return result;
}

Rationals transformed(const Eigen::Isometry3d& pose, const Rationals& points) {
  Rationals rows;
  for (int row = 0; row < 3; ++row) rows.push_back(exactly({pose.linear().row(row).transpose()}).front());
  const Vector<mpq_class> translation = exactly({pose.translation()}).front();
  Rationals result;
  for (const Vector<mpq_class>& p : points) {
    Vector<mpq_class> moved;
    for (std::size_t i = 0; i < 3; ++i) moved[i] = dot(rows[i], p) + translation[i];
    result.push_back(moved);
  }
  return result;
}

/// The largest denominator: all are powers of two, so each divides it.
mpz_class largestDenominator(const Rationals& points) {
  mpz_class largest = 1;
  for (const Vector<mpq_class>& p : points)
    for (const mpq_class& coordinate : p) largest = std::max(largest, mpz_class(coordinate.get_den()));
  return largest;
}

std::vector<Integers> inUnits(const Rationals& points, const mpz_class& units_per_metre) {
  std::vector<Integers> result;
  for (const Vector<mpq_class>& p : points) {
    Integers scaled;
    for (std::size_t i = 0; i < 3; ++i) scaled[i] = p[i].get_num() * (units_per_metre / p[i].get_den());
    result.push_back(scaled);
  }
  return result;
}

const Integers& farthest(const std::vector<Integers>& points, const Integers& direction) {
  const Integers* best = &points.front();
  mpz_class largest = dot(*best, direction);
  for (const Integers& p : points) {
    const mpz_class along = dot(p, direction);
    if (along <= largest) continue;
    best = &p;
    largest = along;
  }
  return *best;
}

/// The CSO a - b of the cores, by its support mapping.
class ExactCso {
 public:
  explicit ExactCso(const ShapePair& pair) {
    const Rationals a = exactly(verticesOf(pair.a)), b = transformed(pair.a_T_b, exactly(verticesOf(pair.b)));
    units_per_metre_ = std::max(largestDenominator(a), largestDenominator(b));
    a_ = inUnits(a, units_per_metre_);
    b_ = inUnits(b, units_per_metre_);
  }

  Integers vertex(const Integers& direction) const {
    return farthest(a_, direction) - farthest(b_, negative(direction));
  }

  mpq_class inSquareMetres(const mpz_class& numerator, const mpz_class& denominator) const {
    mpq_class result(numerator, denominator * units_per_metre_ * units_per_metre_);
    result.canonicalize();
    return result;
  }

 private:
  mpz_class units_per_metre_;
  std::vector<Integers> a_, b_;
};

using Simplex = std::vector<Integers>;

/// The point numerator / denominator nearest to the origin, and the points that carry it with positive weights.
struct NearestPoint {
  Integers numerator;
  mpz_class denominator;  ///< positive
  Simplex simplex;
};

mpz_class determinant(const std::vector<std::vector<mpz_class>>& m) {
  if (m.empty()) return 1;
  if (m.size() == 1) return m[0][0];
  if (m.size() == 2) return m[0][0] * m[1][1] - m[0][1] * m[1][0];
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/// Foot of the perpendicular from the origin to the affine hull of the points; nothing where they are affinely
/// dependent, or where it does not lie strictly inside of their simplex.
///
/// With edges e_i = p_i - p_0 the weights w solve G w = r, G_ij = e_i . e_j, r_i = -e_i . p_0 (Cramer's rule).
std::optional<NearestPoint> footInside(const Simplex& points) {
  const std::size_t edges = points.size() - 1;
  std::vector<std::vector<mpz_class>> gram(edges, std::vector<mpz_class>(edges));
  std::vector<mpz_class> right(edges);
  for (std::size_t i = 0; i < edges; ++i) {
    const Integers edge = points[i + 1] - points[0];
    right[i] = -dot(edge, points[0]);
    for (std::size_t j = 0; j < edges; ++j) gram[i][j] = dot(edge, points[j + 1] - points[0]);
  }
  const mpz_class total = determinant(gram);
  if (total == 0) return std::nullopt;
  mpz_class of_first = total;
  Integers numerator{0, 0, 0};
  const auto add = [&](const mpz_class& weight, const Integers& point) {
    for (std::size_t k = 0; k < 3; ++k) numerator[k] += weight * point[k];
  };
  for (std::size_t j = 0; j < edges; ++j) {
    std::vector<std::vector<mpz_class>> replaced = gram;
    for (std::size_t i = 0; i < edges; ++i) replaced[i][j] = right[i];
    const mpz_class weight = determinant(replaced);
    if (weight <= 0) return std::nullopt;
    of_first -= weight;
    add(weight, points[j + 1]);
  }
  if (of_first <= 0) return std::nullopt;
  add(of_first, points[0]);
  return NearestPoint{numerator, total, points};
}

/// No point of the convex hull of `points` is nearer than v: all lie beyond the plane through v perpendicular to it.
bool isNearestOf(const NearestPoint& v, const Simplex& points) {
  const mpz_class norm2 = dot(v.numerator, v.numerator);
  return std::all_of(points.begin(), points.end(), [&](const Integers& p) {
    const mpz_class along = dot(v.numerator, p) * v.denominator;
    return along >= norm2;
  });
}

/// Tries every subset; exactly one point passes.
NearestPoint nearestToOrigin(const Simplex& points) {
  for (unsigned subset = 1; subset < 1u << points.size(); ++subset) {
    Simplex part;
    for (std::size_t i = 0; i < points.size(); ++i)
      if ((subset >> i & 1u) != 0) part.push_back(points[i]);
    const std::optional<NearestPoint> foot = footInside(part);
    if (foot && isNearestOf(*foot, points)) return *foot;
  }
  throw std::logic_error("a simplex without a nearest point");
}

NearestPoint nearestOfCso(const ExactCso& cso) {
  NearestPoint v = nearestToOrigin({cso.vertex({1, 0, 0})});
  while (!isZero(v.numerator)) {
    const Integers w = cso.vertex(negative(v.numerator));
    if (isNearestOf(v, {w})) break;
    v.simplex.push_back(w);
    v = nearestToOrigin(v.simplex);
  }
  return v;
}

struct Face {
  std::array<Integers, 3> corners;  ///< counter-clockwise from outside
  Integers normal;
  mpz_class height;  ///< of its plane over the origin, times the length of the normal
  mpz_class normal2;

  Face(const Integers& p, const Integers& q, const Integers& r)
      : corners{p, q, r}, normal(cross(q - p, r - p)), height(dot(normal, p)), normal2(dot(normal, normal)) {}

  bool sees(const Integers& point) const { return dot(normal, point) > height; }

  /// Compares height |height| / normal2: the signed square of the distance of the plane.
  bool operator<(const Face& other) const {
    return height * abs(height) * other.normal2 < other.height * abs(other.height) * normal2;
  }
};

/// A vertex of the CSO off the plane through `on_plane` perpendicular to `normal`, if there is one.
std::optional<Integers> vertexOffPlane(const ExactCso& cso, const Integers& normal, const Integers& on_plane) {
  for (const Integers& direction : {normal, negative(normal)}) {
    const Integers w = cso.vertex(direction);
    if (dot(w - on_plane, normal) != 0) return w;
  }
  return std::nullopt;
}

/// Two vectors that with `v` span all of space.
std::array<Integers, 2> acrossTo(const Integers& v) {
  const Integers x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  if (v[0] != 0) return {cross(v, y), cross(v, z)};
  if (v[1] != 0) return {cross(v, x), cross(v, z)};
  return {cross(v, x), cross(v, y)};
}

/// Four vertices of the CSO with volume between them; nothing where the CSO is flat.
std::optional<Simplex> tetrahedron(const ExactCso& cso) {
  Simplex points = {cso.vertex({1, 0, 0})};
  const auto addOffOneOf = [&](const std::vector<Integers>& normals) {
    for (const Integers& normal : normals) {
      const std::optional<Integers> w = vertexOffPlane(cso, normal, points.front());
      if (!w) continue;
      points.push_back(*w);
      return true;
    }
    return false;
  };
  if (!addOffOneOf({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}})) return std::nullopt;
  const std::array<Integers, 2> across = acrossTo(points[1] - points[0]);
  if (!addOffOneOf({across[0], across[1]})) return std::nullopt;
  if (!addOffOneOf({cross(points[1] - points[0], points[2] - points[0])})) return std::nullopt;
  return points;
}

/// Convex hull of CSO vertices, its faces triangles; neighbours may be coplanar.
class GrowingHull {
 public:
  explicit GrowingHull(const Simplex& p) {
    const bool turned = Face(p[0], p[1], p[2]).sees(p[3]);
    const Integers &q = p[turned ? 2 : 1], &r = p[turned ? 1 : 2];
    faces_ = {Face(p[0], q, r), Face(p[0], p[3], q), Face(q, p[3], r), Face(r, p[3], p[0])};
  }

  const Face& nearestFace() const { return *std::min_element(faces_.begin(), faces_.end()); }

  /// Replaces what sees w by the faces from the horizon to w. None of them is without area: w would have to lie on the
  /// line of a horizon edge, hence in the plane of a face that sees it.
  void add(const Integers& w) {
    const auto first_seeing = std::partition(faces_.begin(), faces_.end(), [&](const Face& f) { return !f.sees(w); });
    const std::vector<Face> seeing(first_seeing, faces_.end());
    faces_.erase(first_seeing, faces_.end());
    for (const auto& [from, to] : horizon(seeing)) faces_.emplace_back(from, to, w);
  }

 private:
  using Edge = std::pair<Integers, Integers>;

  /// The edges that only one of the faces has.
  static std::vector<Edge> horizon(const std::vector<Face>& faces) {
    std::vector<Edge> edges;
    for (const Face& face : faces)
      for (std::size_t i = 0; i < 3; ++i) {
        const Edge edge(face.corners[i], face.corners[(i + 1) % 3]);
        const auto opposite = std::find(edges.begin(), edges.end(), Edge(edge.second, edge.first));
        if (opposite == edges.end()) {
          edges.push_back(edge);
        } else {
          edges.erase(opposite);
        }
      }
    return edges;
  }

  std::vector<Face> faces_;
};

/// Squared penetration depth where the origin lies in the CSO. A flat CSO is left across its plane, at no cost.
mpq_class squaredDepth(const ExactCso& cso) {
  const std::optional<Simplex> start = tetrahedron(cso);
  if (!start) return 0;
  GrowingHull hull(*start);
  while (true) {
    const Face nearest = hull.nearestFace();
    const Integers w = cso.vertex(nearest.normal);
    if (!nearest.sees(w)) return cso.inSquareMetres(nearest.height * nearest.height, nearest.normal2);
    hull.add(w);
  }
}

long double squareRoot(const mpq_class& squared) {
  // 256 bits hold the root to far below the last bit of two doubles, and those to below that of a long double.
  const mpf_class root = sqrt(mpf_class(squared, 256));
  const double high = root.get_d();
  const mpf_class rest = root - high;
  return static_cast<long double>(high) + rest.get_d();
}

}  // namespace

bool hasPolytopeCore(const Shape& shape) {
  return shape.kind() == Shape::Kind::Point || shape.kind() == Shape::Kind::Segment ||
         shape.kind() == Shape::Kind::Box || shape.kind() == Shape::Kind::Hull;
}

long double ExactDistance::withMargins(const ShapePair& pair) const {
  const long double cores = squareRoot(squared);
  return (overlap ? -cores : cores) - (static_cast<long double>(pair.a.margin()) + pair.b.margin());
}

ExactDistance exactDistance(const ShapePair& pair) {
  if (!hasPolytopeCore(pair.a) || !hasPolytopeCore(pair.b)) throw std::invalid_argument("a core is not a polytope");
  const ExactCso cso(pair);
  const NearestPoint v = nearestOfCso(cso);
  if (isZero(v.numerator)) return {true, squaredDepth(cso)};
  return {false, cso.inSquareMetres(dot(v.numerator, v.numerator), v.denominator * v.denominator)};
}

long double exactDistanceToOrigin(const std::vector<Eigen::Vector3d>& points) {
  const Rationals in_metres = exactly(points);
  const mpz_class units_per_metre = largestDenominator(in_metres);
  const NearestPoint v = nearestToOrigin(inUnits(in_metres, units_per_metre));
  const mpz_class denominator = v.denominator * units_per_metre;
  mpq_class squared(dot(v.numerator, v.numerator), denominator * denominator);
  squared.canonicalize();
  return squareRoot(squared);
}

}  // namespace proximity_server::narrowphase
