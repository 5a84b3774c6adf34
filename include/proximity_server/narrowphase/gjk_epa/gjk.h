#pragma once

#include "proximity_server/narrowphase/gjk_epa/simplex.h"

namespace proximity_server::narrowphase {

struct GjkResult {
  enum class Outcome : unsigned char {
    Apart,     ///< the simplex holds the witness points; status tells how good they are
    Overlap,   ///< the simplex holds the origin, within rounding or the tolerance: the depth is EPA's to find
    Threshold  ///< options.stop_above was decided by `normal` alone
  };
  Outcome outcome;
  Status status;           ///< of the distance, where the outcome is Apart
  double distance;         ///< [m] of the nearest point of the simplex
  double lower_bound;      ///< [m] of the signed distance; proven by `normal`
  Eigen::Vector3d normal;  ///< unit, a towards b
  Simplex simplex;
  WitnessPoints points;  ///< of the distance, where the outcome is Apart
  int iterations;
};

/// Distance of two cores: the point of their CSO nearest to the origin.
///
/// Begins with a unit normal and the vertex farthest along it. Ends by the duality gap: the nearest point of the
/// simplex bounds the distance from above, the support plane perpendicular to it from below. On curved cores Newton's
/// method ends it, see refinement.h. Error:   outcome Apart with Status::Converged: distance - lower_bound <=
/// options.distance_tolerance. Failure: none; a simplex that brings no progress ends the search, and the bounds say how
/// good the answer is. Source:  Gilbert, Johnson, Keerthi 1988; the stop is van den Bergen's (1999) without his
/// relative tolerance.
GjkResult gjk(Cso& cso, const Eigen::Vector3d& normal_guess, const CsoVertex& first, const Options& options);

}  // namespace proximity_server::narrowphase
