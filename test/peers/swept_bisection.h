#pragma once

#include "proximity_server/narrowphase/motion/motion.h"

namespace proximity_server::peers {

using namespace narrowphase;

/// Returns the motion of b as seen from a: a's screws backwards and in reverse order, then b's.
MotionChain relativeMotion(const MotionChain& a_motion, const MotionChain& b_motion);

/// Time of first contact by bisection of swept volumes. timeOfContact() is compared with it.
///
/// 1. Cover what b sweeps in the frame of a during an interval of time by one convex shape.
/// 2. If that shape stays farther from a than the contact distance, the interval is free.
/// 3. Else go on with its halves, the earlier one first, until the motion within one is below the tolerance.
/// Frame, error, failure: as timeOfContact(), with the same certificates.
/// Source: van den Bergen, Ray Casting against General Convex Objects with Application to Continuous Collision
///         Detection, 2004 (the swept volume by its support mapping).
TimeOfContact timeOfContactBySweeping(const Shape& a, const MotionChain& a_motion, const Shape& b,
                                      const MotionChain& b_motion, const ContactOptions& options = {});

}  // namespace proximity_server::peers
