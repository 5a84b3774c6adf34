#pragma once

#include "stress/motion_families.h"

#include <optional>
#include <string>

namespace proximity_server::narrowphase {

/// The result of one motion.
struct MotionObservation {
  TimeOfContact contact;
  MinimumOverMotion minimum;
  double gap = 0.0;  ///< [m] of the distance at t_free above the contact distance, where there is contact
  double contact_microseconds = 0.0;
  double minimum_microseconds = 0.0;
  std::optional<std::string> failure;  ///< a promise that was not kept
};

/// Asks for the first contact and for the smallest distance, then looks for a time that proves one of them wrong.
///
/// Method: signed distances with poses in long double and the bounds of signedDistance, at times of its own: spread
///         over the motion, at all times that an answer names and just before t_free, at local minima between them
///         (golden sections) and where the first of them enters the contact distance (bisection). The same question
///         with the shapes swapped, and seen from another frame, is held against the same distances.
MotionObservation observeMotion(const StressMotion& motion);

/// Returns the first promise that these answers break, and looks for it in the same way.
std::optional<std::string> brokenPromise(const StressMotion& motion, const TimeOfContact& contact,
                                         const MinimumOverMotion& minimum);

/// Does as observeMotion(), and compares with the first contact of the Lipschitz search (motion_oracle.h) and with the
/// distances at the times of the answers by branch and bound in long double.
MotionObservation observeMotionWithOracle(const StressMotion& motion);

}  // namespace proximity_server::narrowphase
