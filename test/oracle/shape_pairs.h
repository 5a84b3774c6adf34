#pragma once

#include "oracle/oracle.h"
#include "proximity_server/narrowphase/shape/shape.h"

#include <Eigen/Geometry>

#include <random>
#include <string>
#include <vector>

namespace proximity_server::narrowphase {

struct NamedShape {
  std::string name;
  Shape shape;
};

/// One pair of shapes at one pose, with a name for the failure message.
struct PairCase {
  std::string name;
  Shape a;
  Shape b;
  Eigen::Isometry3d a_T_b;

  ShapePair pair() const { return {a, b, a_T_b}; }
};

/// The case in full, every double with 17 digits: enough to repeat it.
std::string describe(const PairCase& pair_case);

/// Sphere, capsule, box, cylinder, cone, ellipsoid and hull, sizes about 1.
std::vector<NamedShape> solidShapes();

/// The solids, and what is easy to forget: padded box and hull, a plate, a needle, polygon, segment and point hulls.
std::vector<NamedShape> allShapes();

Shape hullOf(const std::vector<Eigen::Vector3d>& points);
std::vector<Eigen::Vector3d> boxCorners(const Eigen::Vector3d& size);

/// A pose without rotation.
Eigen::Isometry3d at(double x, double y, double z);

Shape randomHull(std::mt19937& random, int points, const Eigen::Vector3d& half_axes);
Eigen::Vector3d randomDirection(std::mt19937& random);
Eigen::Isometry3d randomPose(std::mt19937& random, double reach);

/// Moves b of a pair along the true normal until the signed distance is `distance`; in overlap the result is
/// no deeper than that.
PairCase movedTo(double distance, PairCase pair_case);

/// Every unordered pair of `shapes`, apart, touching, shallow, deep and concentric, `poses` random poses each; and with
/// one frame for both.
std::vector<PairCase> pairsInEveryState(const std::vector<NamedShape>& shapes, int poses, unsigned seed);

}  // namespace proximity_server::narrowphase
