#pragma once

#include "peers/solids.h"
#include "proximity_server/narrowphase/motion/motion.h"

#include <fcl/math/motion/motion_base.h>

#include <memory>

namespace proximity_server::peers {

using namespace narrowphase;

/// The motions that both ours and FCL have. In all of them FCL turns by less than half a turn.
enum class MotionKind {
  Translation,  ///< FCL's TranslationMotion
  Linear,       ///< the origin on a straight line, a constant turn about it: FCL's InterpMotion, two screws of ours
  Screw         ///< FCL's ScrewMotion
};

enum class Outcome {
  Hit,     ///< a point of b goes through a point of a
  Miss,    ///< the smallest distance is 0.02 to 0.3 m
  Grazing  ///< the smallest signed distance is within 1e-3 m of nothing, not at an end of the motion
};

/// One motion over the time [0, 1] in the common frame, as each library describes it.
struct RigidMotion {
  MotionKind kind;
  Eigen::Isometry3d start;
  Eigen::Vector3d linear, angular;  ///< of the origin at time 0 [m], and of the turn [rad], per unit of time
};
MotionChain chainOf(const RigidMotion& motion);
std::shared_ptr<const fcl::MotionBased> fclMotionOf(const RigidMotion& motion);

struct MovingSolid {
  MovingSolid(const Solid& solid, const RigidMotion& motion);

  const Solid* solid;
  RigidMotion motion;
  MotionChain ours;
  std::shared_ptr<const fcl::MotionBased> fcl;

  /// Returns a speed [m] per unit of time that no point of the solid exceeds.
  double speedBound() const;
};

struct MovingSolidPair {
  MovingSolid a, b;

  /// Returns a speed [m] per unit of time that no change of the signed distance exceeds.
  double speedBound() const { return a.speedBound() + b.speedBound(); }

  Eigen::Isometry3d poseOfBInA(double time) const;
};

SignedDistance signedDistanceAt(const MovingSolidPair& pair, double time, const Options& options = {});

/// Solids in random orientations, b at 2 to 4 m and a at up to 0.5 m per unit of time, turning by up to 2.5 and 1 rad;
/// at least 5 cm apart at the beginning.
MovingSolidPair randomMotion(const Solid& a, const Solid& b, MotionKind kind, Outcome outcome, Random& random);

/// The answers of the libraries are compared with this one.
struct FirstContact {
  bool contact;
  double from, to;  ///< the first contact is in between; no wider than 1e-13
};

/// Bisects the time down to 1e-13, the earlier half first. An interval is left out if the distances at its ends
/// (certified, to 1e-13) add up to more than any motion within it can use up.
FirstContact firstContactOf(const MovingSolidPair& pair);

struct Lowest {
  double distance, time;
};
/// Returns the lowest of some samples, improved by golden-section search in the valleys about the three lowest.
Lowest lowestOf(const MovingSolidPair& pair, int samples);

}  // namespace proximity_server::peers
