#include "scene/pieces/rooms.h"

#include "scene/mesh/stop_flag.h"
#include "scene/pieces/mesh_parts.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <queue>
#include <utility>

namespace proximity_server::scene {

using Eigen::Vector3d;
using narrowphase::ConvexHull;

namespace {

/// The planes of the faces of a hull, moved inwards by kMeshRounding, so that points on its surface count as outside.
class Planes {
 public:
  explicit Planes(const ConvexHull& hull) {
    for (const auto& [a, b, c] : trianglesOf(hull.vertices(), hull.triangles())) {
      const Vector3d normal = (b - a).cross(c - a).stableNormalized();
      normals_.push_back(normal);
      offsets_.push_back(normal.dot(a) - kMeshRounding);
    }
  }

  std::size_t size() const { return normals_.size(); }

  struct Depth {
    /// [m] the depth of a point below the nearest plane, negative outside
    double depth = std::numeric_limits<double>::infinity();
    std::size_t plane = 0;  ///< the nearest plane
  };
  Depth depthOf(const Vector3d& p) const {
    Depth smallest;
    for (std::size_t i = 0; i < size(); ++i)
      if (const double depth = offsets_[i] - normals_[i].dot(p); depth < smallest.depth) smallest = {depth, i};
    return smallest;
  }

  /// True if all of a box is outside of the plane that is the nearest to its centre.
  bool isOutside(const Eigen::AlignedBox3d& box, const Depth& of_centre) const {
    return of_centre.depth < 0.0 && of_centre.depth < -0.5 * normals_[of_centre.plane].cwiseAbs().dot(box.sizes());
  }

  /// Returns a point of the box that is inside of all planes. Tries the centre, and then the point below the plane that
  /// the centre is outside of. Returns nullopt if neither is such a point; the box may hold others.
  std::optional<Vector3d> pointIn(const Eigen::AlignedBox3d& box, const Depth& of_centre) const {
    const Vector3d centre = box.center();
    if (of_centre.depth >= 0.0) return centre;
    const Vector3d p = centre + (of_centre.depth - kMeshRounding) * normals_[of_centre.plane];
    return box.contains(p) && depthOf(p).depth >= 0.0 ? std::optional(p) : std::nullopt;
  }

  /// True if all of these points are outside of one of the planes.
  bool areOutside(const Triangle& points) const {
    const auto isOutsideOf = [&](std::size_t i) {
      return std::all_of(points.begin(), points.end(),
                         [&](const Vector3d& p) { return normals_[i].dot(p) >= offsets_[i]; });
    };
    // often separates the next triangle too, which is often a neighbour
    if (last_ < size() && isOutsideOf(last_)) return true;
    for (std::size_t i = 0; i < size(); ++i) {
      if (!isOutsideOf(i)) continue;
      last_ = i;
      return true;
    }
    return false;
  }

 private:
  std::vector<Vector3d> normals_;
  std::vector<double> offsets_;  // [m]
  mutable std::size_t last_ = 0;
};

/// [m] The largest distance of a point of the box from a triangle. The distance from a convex set is a convex function.
double farthestCorner(const Eigen::AlignedBox3d& box, const Triangle& triangle) {
  double farthest = 0.0;
  for (int i = 0; i < 8; ++i) {
    const Vector3d corner = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
    farthest = std::max(farthest, (nearestPoint(triangle, corner) - corner).norm());
  }
  return farthest;
}

/// The unit normal of a triangle. Zero if the triangle is so thin that rounding may turn its normal.
Vector3d reliableNormal(const Triangle& t) {
  // Rounding turns a normal by about eps of the coordinates divided by the height of the triangle.
  constexpr double kThin = 1e-8;
  const Vector3d ab = t[1] - t[0], ac = t[2] - t[0], normal = ab.cross(ac);
  const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (t[2] - t[1]).squaredNorm()});
  return normal.norm() > kThin * longest ? normal.stableNormalized() : Vector3d::Zero();
}

TriangleMesh hullOfAll(const std::vector<TriangleMesh>& meshes) {
  std::vector<Vector3d> points;
  for (const TriangleMesh& mesh : meshes) points.insert(points.end(), mesh.vertices.begin(), mesh.vertices.end());
  const ConvexHull hull(points);
  TriangleMesh mesh{hull.vertices(), hull.triangles()};
  if (hull.dimension() == 2)  // has one side only; with both it is closed, and encloses nothing
    for (const auto& [a, b, c] : hull.triangles()) mesh.triangles.push_back({a, c, b});
  return mesh;
}

/// True if isSuch holds for one of the at most two triangles that make up the part of a triangle beyond a plane.
template <typename IsSuch>
bool anyBeyond(const Vector3d& normal, double offset, const Triangle& triangle, const IsSuch& isSuch) {
  std::array<Vector3d, 4> corners;  // of the part beyond the plane, which is convex
  std::size_t count = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d &p = triangle[i], &q = triangle[(i + 1) % 3];
    const double beyond_p = normal.dot(p) - offset, beyond_q = normal.dot(q) - offset;
    if (beyond_p >= 0.0) corners[count++] = p;
    if ((beyond_p >= 0.0) != (beyond_q >= 0.0)) corners[count++] = p + beyond_p / (beyond_p - beyond_q) * (q - p);
  }
  for (std::size_t i = 2; i < count; ++i)
    if (isSuch({corners[0], corners[i - 1], corners[i]})) return true;
  return false;
}

}  // namespace

Rooms::Part::Part(const TriangleMesh& mesh)
    : surface(trianglesOf(mesh.vertices, mesh.triangles)),
      space(surface.boxes()),
      facing(enclosedVolume(mesh) < 0.0 ? -1 : 1) {}

Rooms::Rooms(const std::vector<TriangleMesh>& components, const std::atomic<bool>* stop) {
  std::vector<TriangleMesh> open;
  std::vector<Triangle> all;
  const auto add = [&](const TriangleMesh& mesh) {
    for (const Triangle& triangle : trianglesOf(mesh.vertices, mesh.triangles)) all.push_back(triangle);
  };
  for (const TriangleMesh& component : components) {
    requireNoStop(stop);
    add(component);
    if (isClosed(component))
      parts_.emplace_back(component);
    else
      open.push_back(component);
  }
  if (parts_.empty()) return;
  if (const TriangleMesh hull = open.empty() ? TriangleMesh() : hullOfAll(open); !hull.triangles.empty()) {
    parts_.emplace_back(hull);
    add(hull);
  }
  requireNoStop(stop);
  surface_.emplace(std::move(all));
}

class RoomSearch {
 public:
  RoomSearch(const Rooms& rooms, const ConvexHull& hull, const Rooms::Question& question, Effort& effort)
      : rooms_(rooms), planes_(hull), question_(question), radius_(question.known), effort_(effort) {
    Eigen::AlignedBox3d box;
    for (const Vector3d& vertex : hull.vertices()) {
      middle_ += vertex / static_cast<double>(hull.vertices().size());
      box.extend(vertex);
    }
    Cell whole{box, 0.0, nullptr, 0, {}};
    for (const Rooms::Part& part : rooms.parts_) {
      std::vector<Triangle> inside = trianglesInside(part, box);
      if (inside.empty()) {
        whole.winding += part.space.windingNumber(middle_, effort_);
      } else {
        whole.parts.push_back(parts_.size());
        parts_.push_back({TriangleTree(std::move(inside)), part.space, part.facing});
      }
    }
    look(std::move(whole));
  }

  Rooms::Largest search() {
    for (int looks = question_.looks; looks > 0 && !isDecided(); looks -= 2) {
      const Cell whole = cells_.top();
      cells_.pop();
      Cell lower{whole.box, 0.0, whole.near, whole.winding, whole.parts}, upper = lower;
      Eigen::Index axis;
      whole.box.sizes().maxCoeff(&axis);
      lower.box.max()[axis] = upper.box.min()[axis] = whole.box.center()[axis];
      look(std::move(lower));
      look(std::move(upper));
    }
    if (cells_.empty() || cells_.top().bound <= negligible()) return {radius_, negligible(), centre_};
    return {radius_, cells_.top().bound, radius_ > question_.too_large ? centre_ : nearestInside(cells_.top().box)};
  }

 private:
  struct Cell {
    Eigen::AlignedBox3d box;
    double bound;          ///< [m] an upper bound of the radius of a ball with its centre in the cell
    const Triangle* near;  ///< a triangle of the mesh that is near; nullptr: none is known
    /// The sum of the winding numbers of the settled parts. A part is settled if its winding number is constant where
    /// the cell is inside of the hull.
    int winding;
    std::vector<std::size_t> parts;  ///< the parts that are not settled
    bool operator<(const Cell& other) const { return bound < other.bound; }
  };

  // Few triangles decide quickly; among many the boxes become small enough by themselves.
  static constexpr std::size_t kMany = 100;

  double negligible() const { return std::max(radius_ + kMeshRounding, question_.enough); }
  bool isDecided() const {
    return radius_ > question_.too_large || cells_.empty() || cells_.top().bound <= negligible();
  }

  Vector3d nearestInside(const Eigen::AlignedBox3d& box) const {
    return planes_.pointIn(box, planes_.depthOf(box.center())).value_or(middle_);
  }

  /// The triangles of a part that may be inside of the hull.
  std::vector<Triangle> trianglesInside(const Rooms::Part& part, const Eigen::AlignedBox3d& box) {
    std::vector<Triangle> inside;
    part.surface.anyIn(box, effort_, [&](const Triangle& triangle) {
      effort_.spend(planes_.size() / 4);
      if (!planes_.areOutside(triangle)) inside.push_back(triangle);
      return false;
    });
    return inside;
  }

  void look(Cell cell) {
    const Vector3d centre = cell.box.center();
    const double reach = 0.5 * cell.box.diagonal().norm();
    effort_.spend(planes_.size() / 2);
    const Planes::Depth depth = planes_.depthOf(centre);
    if (planes_.isOutside(cell.box, depth)) return;
    const double harmless = negligible() - reach;
    const TriangleTree::Nearest nearest = rooms_.surface_->nearest(centre, effort_, cell.near, {harmless});
    const double distance = nearest.distance;
    if (distance <= harmless) return;
    constexpr std::size_t kStepsPerBox = 8 * 20;  // as many as TriangleTree spends on eight triangles
    effort_.spend(kStepsPerBox);
    if (farthestCorner(cell.box, *nearest.triangle) <= negligible()) return;
    cell.near = nearest.triangle;
    if (const auto inside = planes_.pointIn(cell.box, depth)) {
      const auto isSettled = [&](std::size_t i) {
        if (parts_[i].inside.nearest(centre, effort_, nullptr, {reach, 1.01 * reach}).distance <= reach) return false;
        cell.winding += parts_[i].space.windingNumber(*inside, effort_);
        return true;
      };
      cell.parts.erase(std::remove_if(cell.parts.begin(), cell.parts.end(), isSettled), cell.parts.end());
    }
    // If the settled parts fill the cell, only a part that faces the other way can make a hole in it.
    const auto facesTheSameWay = [&](std::size_t i) { return parts_[i].facing * cell.winding > 0; };
    if (cell.winding != 0 && std::all_of(cell.parts.begin(), cell.parts.end(), facesTheSameWay)) return;

    cell.bound = distance + reach;
    if (depth.depth >= 0.0) {
      int winding = cell.winding;
      for (const std::size_t i : cell.parts) winding += parts_[i].space.windingNumber(centre, effort_);
      if (winding != 0) {
        cell.bound = reach - distance;
      } else if (distance > radius_) {
        radius_ = distance;
        centre_ = centre;
      }
    }
    if (cell.bound <= negligible()) return;
    // No plane separates the points within reach from a triangle that is nearer.
    const bool can_grow =
        distance < reach ? canGrowAlongNormals(centre, reach + cell.bound) : liesOnOneSide(centre, reach, cell.bound);
    if (!can_grow) cells_.push(std::move(cell));
  }

  /// True if a plane separates all points within `reach` [m] of the centre from all points of the mesh that can be
  /// nearest to one of them, at a distance of up to `bound` [m].
  bool liesOnOneSide(const Vector3d& centre, double reach, double bound) {
    const double radius = reach + bound;
    near_.clear();
    const auto isNear = [&](const Triangle& triangle) {
      return (nearestPoint(triangle, centre) - centre).norm() <= radius;
    };
    Vector3d away = Vector3d::Zero();
    const auto isOneTooMany = [&](const Triangle& triangle) {
      const Vector3d way = centre - nearestPoint(triangle, centre);
      if (way.norm() > radius) return false;
      near_.push_back(triangle);
      away += way.stableNormalized();
      return near_.size() > kMany;
    };
    if (rooms_.surface_->anyIn({centre.array() - radius, centre.array() + radius}, effort_, isOneTooMany)) return false;
    away.stableNormalize();
    return std::none_of(near_.begin(), near_.end(), [&](const Triangle& triangle) {
      return anyBeyond(away, away.dot(centre) - reach, triangle, isNear);
    });
  }

  /// True if a ball of empty space with its centre within `radius` [m] of a point can grow, provided that all triangles
  /// that it touches are within `radius` of that point, too.
  ///
  /// Let each normal of a triangle within kFarther * radius be at an angle below acos(1 / kFarther) to one direction u.
  /// Every straight way from within `radius` to the point at kFarther * radius along u then passes triangles from their
  /// backs to their fronts only, and each makes the winding number smaller by 1. So if the number is not negative at
  /// that point, it is negative nowhere within `radius`, and empty space, where it is 0, is in front of each triangle that
  /// it touches. The way from a touched point to the centre of the ball is a combination of normals of triangles that
  /// meet there, so it leads along u, and so does the ball that grows.
  bool canGrowAlongNormals(const Vector3d& point, double radius) {
    constexpr double kFarther = 1.5, kRounding = 0.01;
    const double far = kFarther * radius;
    normals_.clear();
    // Two normals along one u are at an angle below twice acos(1 / kFarther), the cosine of which this is.
    constexpr double kSmallestCosine = 2.0 / (kFarther * kFarther) - 1.0;
    const auto endsIt = [&](const Triangle& t) {
      if ((nearestPoint(t, point) - point).norm() > far) return false;
      normals_.push_back(reliableNormal(t));
      return normals_.size() > kMany || !(normals_.back().dot(normals_.front()) > kSmallestCosine) ||
             normals_.back().isZero(0.0);
    };
    if (rooms_.surface_->anyIn({point.array() - far, point.array() + far}, effort_, endsIt)) return false;
    Vector3d u = Vector3d::Zero();
    for (const Vector3d& normal : normals_) u += normal;
    u.stableNormalize();
    const auto isAlongU = [&](const Vector3d& normal) { return kFarther * normal.dot(u) > 1.0 + kRounding; };
    if (!std::all_of(normals_.begin(), normals_.end(), isAlongU)) return false;
    int winding = 0;
    for (const Rooms::Part& part : rooms_.parts_) winding += part.space.windingNumber(point + far * u, effort_);
    return winding >= 0;
  }

  /// A part of the mesh that reaches into the hull.
  struct PartInside {
    TriangleTree inside;  ///< its triangles inside of the hull
    const EnclosedSpace& space;
    int facing;
  };

  Vector3d middle_ = Vector3d::Zero();  // of the hull
  std::vector<PartInside> parts_;
  const Rooms& rooms_;
  const Planes planes_;
  const Rooms::Question question_;
  double radius_;                       // [m] the radius of the largest ball found
  Vector3d centre_ = Vector3d::Zero();  // its centre
  Effort& effort_;
  std::priority_queue<Cell> cells_;
  std::vector<Triangle> near_;
  std::vector<Vector3d> normals_;
};

Rooms::Largest Rooms::largestIn(const ConvexHull& hull, const Question& question, Effort& effort) const {
  if (parts_.empty() || hull.dimension() < 3) return {question.known, question.known};
  try {
    return RoomSearch(*this, hull, question, effort).search();
  } catch (const Effort::Exceeded&) {
    // No point of the hull is farther from its surface than half of the smallest edge of its box.
    Eigen::AlignedBox3d box;
    for (const Vector3d& vertex : hull.vertices()) box.extend(vertex);
    const double on_surface = std::max(question.known, question.enough);
    return {question.known, on_surface + 0.5 * box.sizes().minCoeff(), hull.vertices().front()};
  }
}

}  // namespace proximity_server::scene
