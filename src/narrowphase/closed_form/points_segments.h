#pragma once

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/narrowphase/shape/shape.h"

namespace proximity_server::narrowphase {

/// Whether closedForm() answers this pair: points and segments in any combination, and a point with a box.
inline bool hasClosedForm(Shape::Kind a, Shape::Kind b) {
  const auto is_line = [](Shape::Kind kind) { return kind == Shape::Kind::Point || kind == Shape::Kind::Segment; };
  return (is_line(a) && is_line(b)) || (a == Shape::Kind::Box && b == Shape::Kind::Point) ||
         (a == Shape::Kind::Point && b == Shape::Kind::Box);
}

/// Signed distance of two cores that have a closed form, without margins.
///
/// Frame, sign, invariant: as signedDistance().
/// Error:   a few eps of the sizes and the offset.
/// Source:  Ericson, Real-Time Collision Detection, 2005, 5.1.
SignedDistance closedForm(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b);

}  // namespace proximity_server::narrowphase
