#pragma once

#include <optional>

#include "proximity_server/narrowphase/signed_distance.h"

namespace proximity_server {

/// Signed distance of two cores where a closed form exists: points and segments among themselves, a point and a box.
///
/// Frame, sign and invariant as signedDistance, margins left out. Error: a few eps of the sizes and the offset.
/// Source: Ericson, Real-Time Collision Detection, 2005, 5.1.
std::optional<SignedDistance> closedForm(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b);

}  // namespace proximity_server
