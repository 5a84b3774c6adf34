#pragma once

#include "proximity_server/narrowphase/shape/shape.h"
#include "system/numbers.h"
#include "tools/second_opinion/placed_pieces.h"

#include <Eigen/Geometry>

#include <limits>
#include <optional>
#include <vector>

namespace proximity_server::tools {

/// The answers of any library about two pieces, as far as they can be put to the proof. In the frame of the pieces.
struct Hints {
  std::vector<Eigen::Vector3d> axes;                                ///< directions from a to b, of any length
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> points;  ///< a point of a and one of b
};

/// Proven bounds of a signed distance [m].
struct ProvenBounds {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
};

/// Proves bounds of the signed distance of two links or objects (by their closest or deepest pieces), from the
/// definition of their shapes alone:
///
/// 1. A lower bound of two pieces is their gap along an axis: how far all of b lies beyond all of a, by the extents of
///    both shapes along it. Any axis proves one, in overlap too. The best of several is taken.
/// 2. That of the whole is the least of all its pairs of pieces.
/// 3. An upper bound is the distance of a point of a from a point of b; a point of both proves an overlap.
/// 4. A depth is proven by a polytope of points of the Minkowski difference: the ball about the origin that it holds.
///
/// The axes and points come from the hints, from the narrowphase, and from the centres. They are not trusted, and
/// nothing of the narrowphase's bounds is used: extents are evaluated in long double, and points are moved into the
/// shapes first.
/// Error: both bounds are widened by what rounding may have cost.
ProvenBounds provenBounds(const PlacedPieces& a, const PlacedPieces& b, const Hints& hints);

// The parts of the proof, of one shape in its frame.

/// [m] The largest coordinate of the shape along a direction: its support function.
long double extentAlong(const narrowphase::Shape& shape, const Eigen::Matrix<long double, 3, 1>& direction);

/// A point of the shape near to `point`, and the point itself if it lies inside. Not for sweeps, which neither links
/// nor objects have.
Eigen::Vector3d pointInside(const narrowphase::Shape& shape, const Eigen::Vector3d& point);

}  // namespace proximity_server::tools
