#pragma once

#include "proximity_server/scene/proof/joint_box.h"

#include <cstddef>
#include <functional>

namespace proximity_server::tools {

/// Which end of an interval.
enum class End : unsigned char { Lower, Upper };

/// Moves one end of the interval `at` of a box as far towards the end in `limits` as `isProven(box)` holds, by
/// bisection. A proof of a box holds for each part of it. The first box must be proven; the result is the last box for
/// which isProven() was true.
/// Error: the end could lie up to 1/64 of the width of the limits farther out. Its digits are few, see
///        JointRange::typeable().
void extend(scene::JointBox& box, std::size_t at, End end, const scene::JointRange& limits,
            const std::function<bool(const scene::JointBox&)>& isProven);

/// True if the box has all intervals of the other one, and contains them.
bool contains(const scene::JointBox& box, const scene::JointBox& part);

/// The share of the volume of `whole` that a part of it takes: the product of the shares of all joints with a range.
double shareOf(const scene::JointBox& part, const scene::JointBox& whole);

}  // namespace proximity_server::tools
