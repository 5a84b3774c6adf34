#pragma once

#include "chance.h"
#include "proximity_server/narrowphase/shape/shape.h"

#include <Eigen/Geometry>

#include <vector>

namespace proximity_server::narrowphase {

// The shapes and poses of which the families of random pairs and motions are made.

struct TwoShapes {
  Shape a;
  Shape b;
};

/// Returns edges [m] between `size` and a fifth of it.
Eigen::Vector3d randomSizes(Chance& chance, double size);

/// Returns the radius [m] of a ball about the centre of the shape that holds it.
double radiusOf(const Shape& shape);

/// Returns the radius [m] of a ball about the origin of a that holds both.
double scaleOf(const TwoShapes& shapes, const Eigen::Isometry3d& a_T_b);

// Shapes, centred, of about `size` [m].

/// Turned by a random rotation, so that what was exactly flat is flat within rounding only.
std::vector<Eigen::Vector3d> turned(Chance& chance, std::vector<Eigen::Vector3d> points);

Shape primitive(Chance& chance, const Eigen::Vector3d& size);
Shape solid(Chance& chance, double size);
Shape boxOrItsHull(Chance& chance, const Eigen::Vector3d& size);

/// A point, a segment or a polygon; in a coordinate plane or turned out of it.
Shape flat(Chance& chance, double size);

/// A plate or a needle of aspect 1e4 to 1e6.
Shape sliver(Chance& chance, double size);

// Poses a_T_b. Those of the centres first: a hull may lie far from the origin of its frame.

/// `rotation`, with the centre of b at `offset` from that of a.
Eigen::Isometry3d withCentres(const TwoShapes& shapes, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& offset);

/// The centres are at most as far from each other as `part` of the sum of the radii.
Eigen::Isometry3d anywhereWithin(const TwoShapes& shapes, Chance& chance, double part);

/// 0 or +-1e-16 to +-1e-3 of the smaller size.
double touchingGap(const TwoShapes& shapes, Chance& chance);

/// b moved along the normal until the distance is `gap`; in overlap the result is no deeper than that.
Eigen::Isometry3d movedToGap(const TwoShapes& shapes, Eigen::Isometry3d a_T_b, double gap);

Eigen::Matrix3d quarterTurns(Chance& chance);

/// Faces parallel but for a tilt, in some; touchingGap apart.
Eigen::Isometry3d parallelFaces(const TwoShapes& shapes, Chance& chance);

}  // namespace proximity_server::narrowphase
