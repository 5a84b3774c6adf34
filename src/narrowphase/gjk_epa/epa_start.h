#pragma once

#include "narrowphase/cso/simplex.h"

#include <optional>

namespace proximity_server::narrowphase {

/// A support plane of the CSO that contains the origin, within rounding.
struct SurfacePlane {
  Eigen::Vector3d normal;  ///< unit, outward
  double depth;            ///< [m] of the origin below the plane
  bool two_sided;          ///< true: the CSO has no volume, and the opposite plane has the same depth
};

/// Start of EPA: four vertices of the CSO that span a volume. If there are none, or if the origin lies on the surface
/// of the CSO, `plane` is set instead; it already is the answer.
struct EpaStart {
  std::array<CsoVertex, 4> vertices;
  std::optional<SurfacePlane> plane;
};

/// Extends a simplex of any dimension to a tetrahedron, vertex by vertex.
///
/// The simplex contains the origin, within rounding or the tolerance. A point grows along the coordinate axes, a
/// segment across itself, a triangle along its normal; a vertex counts if it lies more than rounding outside of the
/// span.
EpaStart epaStart(Cso& cso, const Simplex& simplex);

}  // namespace proximity_server::narrowphase
