#pragma once

#include <optional>

#include "proximity_server/narrowphase/gjk_epa/simplex.h"

namespace proximity_server::narrowphase {

/// A support plane of the CSO through the origin, within rounding.
struct SurfacePlane {
  Eigen::Vector3d normal;  ///< unit, outward
  double depth;            ///< [m] of the origin
  bool two_sided;          ///< the CSO has no volume: the opposite plane is as good
};

/// Where the search for the depth begins: four vertices of the CSO that span a volume or, where there are none or the
/// origin lies on the surface, the plane that is the answer.
struct EpaStart {
  std::array<CsoVertex, 4> vertices;
  std::optional<SurfacePlane> plane;
};

/// Grows a simplex of any dimension that holds the origin within rounding (or the tolerance).
EpaStart epaStart(Cso& cso, const Simplex& simplex);

}  // namespace proximity_server::narrowphase
