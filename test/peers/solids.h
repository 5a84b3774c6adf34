#pragma once

#include "chance.h"
#include "proximity_server/narrowphase/shape/shape.h"

#include <btBulletCollisionCommon.h>
#include <fcl/geometry/collision_geometry.h>
#include <Eigen/Geometry>

#include <memory>
#include <optional>
#include <vector>

namespace proximity_server::peers {

using namespace narrowphase;

/// One convex solid, as each library wants it.
struct Solid {
  Shape ours;
  std::shared_ptr<fcl::CollisionGeometryd> fcl;
  std::shared_ptr<btConvexShape> bullet;  ///< in float, without collision margin
};

/// Returns a shape as the other libraries describe it, or nullopt if one of them has no such shape: cones, ellipsoids,
/// a margin about anything but a point or a segment, a hull that is no solid.
std::optional<Solid> solidOf(const Shape& shape);

using Random = proximity_server::Chance;

Eigen::Vector3d randomAxis(Random& random);
Eigen::Quaterniond randomTurn(Random& random);

/// Random solids with sizes about one metre.
Solid randomBox(Random& random);       ///< half extents 0.25 to 0.5
Solid randomSphere(Random& random);    ///< radius 0.25 to 0.5
Solid randomCapsule(Random& random);   ///< radius 0.1 to 0.25, segment 0.5 to 1
Solid randomCylinder(Random& random);  ///< radius 0.2 to 0.4, length 0.5 to 1
Solid randomPlate(Random& random);     ///< a box of half extents 0.25 to 0.5 that is 2 mm thick
/// `vertices` points on an ellipsoid with half axes 0.3 to 0.5.
Solid randomHull(Random& random, int vertices);

/// The placement of two solids: gap 0.05 to 1, gap within 1e-9 of nothing, depth up to a tenth of the size (1), or
/// centres within half of the distance at which they would touch.
enum class Placement { Apart, Touching, Shallow, Deep };

struct SolidPair {
  const Solid* a;
  const Solid* b;
  Placement placement;
  Eigen::Isometry3d a_T_b;
};

/// Places b in a random orientation and in a random direction from a, at the distance that `placement` asks for.
SolidPair place(const Solid& a, const Solid& b, Placement placement, Random& random);

}  // namespace proximity_server::peers
