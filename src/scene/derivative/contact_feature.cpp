#include "scene/derivative/contact_feature.h"

#include "proximity_server/narrowphase/shape/support.h"
#include "scene/bounds/bounds.h"
#include "scene/objects/placed_object.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using narrowphase::Shape;
using Kind = narrowphase::Shape::Kind;

/// An upper bound of the number of vertices of a shape in one plane.
std::size_t mostCorners(const Shape& shape) {
  constexpr std::size_t kBox = 8, kPolygonOfDisc = 16;
  if (shape.kind() == Kind::Hull) return static_cast<std::size_t>(shape.hull().size());
  if (shape.kind() == Kind::Sweep) return 2 * mostCorners(shape.sweep().shape);
  return shape.kind() == Kind::Box ? kBox : kPolygonOfDisc;
}

std::size_t mostCorners(const std::vector<Piece>& pieces) {
  std::size_t most = 0;
  for (const Piece& piece : pieces) most = std::max(most, mostCorners(piece.shape));
  return most;
}

/// Adds the points of a core that are above a height over a plane to a figure. If these points are a disc, the figure
/// becomes the disc.
class Collector {
 public:
  Collector(const ContactPlane& plane, double lowest, double tolerance, PlaneFigure& figure)
      : plane_(plane), lowest_(lowest), tolerance_(tolerance), figure_(figure) {}

  void add(const Shape& shape, const Isometry3d& pose) {
    const Vector3d& half = shape.halfExtents();
    switch (shape.kind()) {
      case Kind::Point:
      case Kind::Segment:
      case Kind::Box:
        for (int i = 0; i < 8; ++i) addIfFar(pose * narrowphase::support::corner(half, i));
        return;
      case Kind::Hull:
        for (const Vector3d& vertex : shape.hull().vertices()) addIfFar(pose * vertex);
        return;
      case Kind::Cylinder:
      case Kind::Cone:
        return addSolidOfRevolution(shape, pose);
      case Kind::Ellipsoid:
        return addIfFar(pose * farthest(shape, pose));
      case Kind::Sweep:
        is_swept_ = true;
        add(shape.sweep().shape, pose);
        add(shape.sweep().shape, pose * shape.sweep().end);
        return;
    }
  }

 private:
  void addIfFar(const Vector3d& point) {
    if (plane_.heightOf(point) >= lowest_) figure_.add(plane_.inPlane(point));
  }

  Vector3d farthest(const Shape& shape, const Isometry3d& pose) const {
    int vertex = 0;
    return supportPoint(shape, pose.linear().transpose() * plane_.normal, vertex);
  }

  /// Adds an end, a line of the side, or a point of a rim.
  void addSolidOfRevolution(const Shape& shape, const Isometry3d& pose) {
    const Vector3d direction = pose.linear().transpose() * plane_.normal, half = shape.halfExtents();
    const double radial = narrowphase::support::radialPart(direction);
    const bool is_cone = shape.kind() == Kind::Cone;
    const bool ends_there = !is_cone || direction.z() < 0.0;
    if (ends_there && 2.0 * half.x() * radial <= tolerance_)
      return addDisc(pose, std::copysign(half.z(), direction.z()), half.x());
    for (const double z : {-half.z(), half.z()})
      addIfFar(pose * (is_cone && z > 0.0 ? Vector3d(0.0, 0.0, z)
                                          : narrowphase::support::rimPoint(half.x(), z, direction, radial)));
  }

  void addDisc(const Isometry3d& pose, double z, double radius) {
    const Vector3d centre = pose * Vector3d(0.0, 0.0, z);
    if (plane_.heightOf(centre) < lowest_) return;
    if (!is_swept_) return figure_.becomeDisc(plane_.inPlane(centre), radius);
    constexpr int kSides = 16;
    const double outer = radius / std::cos(M_PI / kSides);
    for (int i = 0; i < kSides; ++i) {
      const double angle = 2.0 * M_PI / kSides * i;
      figure_.add(plane_.inPlane(centre) + outer * Vector2d(std::cos(angle), std::sin(angle)));
    }
  }

  const ContactPlane& plane_;
  const double lowest_, tolerance_;
  PlaneFigure& figure_;
  bool is_swept_ = false;
};

/// Unit vectors that are perpendicular to a normal and to each other.
Eigen::Matrix<double, 3, 2> axesAcross(const Vector3d& normal) {
  Eigen::Matrix<double, 3, 2> axes;
  axes.col(0) = normal.unitOrthogonal();
  axes.col(1) = normal.cross(axes.col(0));
  return axes;
}

}  // namespace

std::optional<double> findSupportFigure(const Shape& shape, const Isometry3d& frame_T_shape, const ContactPlane& plane,
                                        double tolerance, double width, PlaneFigure& figure) {
  // Most pieces of a mesh are so far away that their support point is not needed.
  const double reach = shape.coreRadius() + shape.margin() + tolerance;
  if (plane.heightOf(frame_T_shape * shape.centre()) < -reach) return std::nullopt;
  int vertex = 0;
  const Vector3d direction = frame_T_shape.linear().transpose() * plane.normal;
  const double height = plane.heightOf(frame_T_shape * supportPoint(shape, direction, vertex));
  if (!(std::abs(height + shape.margin()) <= tolerance)) return std::nullopt;
  figure.begin();
  Collector(plane, height - tolerance, tolerance, figure).add(shape, frame_T_shape);
  if (!figure.isDisc()) figure.close();
  return sidewaysError(shape, direction, width);
}

/// One of the two shapes of a pair, in its pose.
struct ContactFeatures::Side {
  const std::vector<Piece>* pieces;
  const std::vector<int>* numbers;                  ///< the numbers of its pieces; nullptr: all pieces
  const std::vector<PlacedHalfSpace>* half_spaces;  ///< nullptr: none
  Isometry3d pose;

  /// True if the plane is the boundary of a half-space. Directions count as equal if they move points that are 1 m away
  /// by at most 1e-6 m. More common points can only make the smallest value smaller.
  bool fills(const ContactPlane& plane, double tolerance) const {
    constexpr double kSameDirection = 1e-6;
    if (!half_spaces) return false;
    return std::any_of(half_spaces->begin(), half_spaces->end(), [&](const PlacedHalfSpace& half_space) {
      const Vector3d normal = pose.linear() * half_space.normal;
      const double height = normal.dot(plane.origin - pose.translation()) - half_space.offset;
      return std::abs(height) <= tolerance && (normal - plane.normal).norm() <= kSameDirection;
    });
  }

  /// Calls `visit(error)` for each figure in the plane: how far [m] it may lie beside its true place.
  template <class Visit>
  void forEachFigure(const ContactPlane& plane, double tolerance, double width, PlaneFigure& figure,
                     const Visit& visit) const {
    const std::size_t count = numbers ? numbers->size() : pieces->size();
    for (std::size_t i = 0; i < count; ++i) {
      const Piece& piece = (*pieces)[numbers ? (*numbers)[i] : i];
      if (const auto error = findSupportFigure(piece.shape, pose * piece.body_T_piece, plane, tolerance, width, figure))
        visit(*error);
    }
  }
};

ContactFeatures::ContactFeatures(const SceneModel& model) : robot_(model.robot), paddings_(paddingsOf(model.pairs)) {
  const std::size_t most = mostCorners(robot_.pieces);
  figure_a_.reserve(most);
  figure_b_.reserve(most);
  for (int link = 0; link < static_cast<int>(robot_.links.size()); ++link)
    pieces_of_link_.push_back(robot_.piecesOf(link));
}

void ContactFeatures::makeRoomFor(const Objects& objects) {
  for (const int number : objects.numbers()) {
    const std::size_t most = mostCorners(objects.placed(number)->geometry->pieces());
    figure_a_.reserve(most);
    figure_b_.reserve(most);
  }
}

std::optional<ContactFeatures::Side> ContactFeatures::sideOf(const ShapeRef& ref, const State& state) const {
  const std::optional<Isometry3d> pose = state.poseOf(ref);
  if (!pose) return std::nullopt;
  if (ref.isObject()) {
    const ObjectGeometry& geometry = *state.objects()->placed(ref.object())->geometry;
    return Side{&geometry.pieces(), nullptr, &geometry.halfSpaces(), *pose};
  }
  const std::vector<int>& collisions = robot_.links[ref.link()].collisions;
  const std::vector<int>& numbers =
      ref.collision() > 0 ? robot_.collisions[collisions[ref.collision() - 1]].pieces : pieces_of_link_[ref.link()];
  return Side{&robot_.pieces, &numbers, nullptr, *pose};
}

double ContactFeatures::minimum(const State& state, const PairProximity& pair, const Vector3d& slope) {
  if (state.objects() != objects_) makeRoomFor(*(objects_ = state.objects()));
  const narrowphase::SignedDistance& result = pair.result;
  const std::optional<Side> a = sideOf(pair.asked.a, state), b = sideOf(pair.asked.b, state);
  if (!a || !b) return std::numeric_limits<double>::quiet_NaN();

  const Vector3d from_surface = 0.5 * paddings_.of(pair.asked) * result.normal;
  const Eigen::Matrix<double, 3, 2> axes = axesAcross(result.normal);
  const ContactPlane plane_a{result.point_a - from_surface, result.normal, axes};
  const ContactPlane plane_b{result.point_b + from_surface, -result.normal, axes};
  const double rounding = kPoseRounding * (result.point_a.norm() + result.point_b.norm() +
                                           a->pose.translation().norm() + b->pose.translation().norm());
  const double width = result.upper_bound - result.lower_bound;
  const double tolerance = std::max(width, Question().tolerance) + rounding;

  const Vector2d in_plane = axes.transpose() * slope;
  double minimum = 0.0;
  const auto lower = [&](double value) { minimum = std::min(minimum, value); };
  if (a->fills(plane_a, tolerance)) {
    b->forEachFigure(plane_b, tolerance, width, figure_b_, [&](double) { lower(minimumOn(figure_b_, in_plane)); });
    return minimum;
  }
  const bool b_fills_plane = b->fills(plane_b, tolerance);
  a->forEachFigure(plane_a, tolerance, width, figure_a_, [&](double error_a) {
    if (b_fills_plane) return lower(minimumOn(figure_a_, in_plane));
    b->forEachFigure(plane_b, tolerance, width, figure_b_, [&](double error_b) {
      lower(minimumInCommon(figure_a_, figure_b_, in_plane, tolerance + error_a + error_b));
    });
  });
  return minimum;
}

}  // namespace proximity_server::scene
