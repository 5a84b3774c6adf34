#pragma once

#include <Eigen/Geometry>
#include <random>
#include <vector>

#include "proximity_server/narrowphase/shape/shape.h"

namespace proximity_server::narrowphase {

// What the families of random pairs and of random motions are made of.

struct TwoShapes {
  Shape a;
  Shape b;
};

double uniform(std::mt19937& random, double low, double high);

/// Every decade between the exponents is as likely.
double decades(std::mt19937& random, double low, double high);

/// 0 to count - 1.
int below(std::mt19937& random, int count);

double eitherSign(std::mt19937& random, double value);

/// `size` along the longest edge, down to a fifth of it.
Eigen::Vector3d randomSizes(std::mt19937& random, double size);

/// Of a ball about its centre that holds the shape [m].
double radiusOf(const Shape& shape);

/// Radius of a ball about the origin of a that holds both [m].
double scaleOf(const TwoShapes& shapes, const Eigen::Isometry3d& a_T_b);

// Shapes, centred, of about `size` [m].

/// Turned by a random rotation, so that what was exactly flat is flat within rounding only.
std::vector<Eigen::Vector3d> turned(std::mt19937& random, std::vector<Eigen::Vector3d> points);

Shape primitive(std::mt19937& random, const Eigen::Vector3d& size);
Shape solid(std::mt19937& random, double size);
Shape boxOrItsHull(std::mt19937& random, const Eigen::Vector3d& size);

/// A point, a segment or a polygon; in a coordinate plane or turned out of it.
Shape flat(std::mt19937& random, double size);

/// A plate or a needle of aspect 1e4 to 1e6.
Shape sliver(std::mt19937& random, double size);

// Poses a_T_b. Those of the centres first: a hull may lie far from the origin of its frame.

/// `rotation`, with the centre of b at `offset` from that of a.
Eigen::Isometry3d withCentres(const TwoShapes& shapes, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& offset);

/// The centres as far from each other as `part` of the sum of the radii, at most.
Eigen::Isometry3d anywhereWithin(const TwoShapes& shapes, std::mt19937& random, double part);

/// 0 or +-1e-16 to +-1e-3 of the smaller size.
double touchingGap(const TwoShapes& shapes, std::mt19937& random);

/// b moved along the normal until the distance is `gap`; in overlap the result is no deeper than that.
Eigen::Isometry3d movedToGap(const TwoShapes& shapes, Eigen::Isometry3d a_T_b, double gap);

Eigen::Matrix3d quarterTurns(std::mt19937& random);

/// Faces parallel but for a tilt, in some; touchingGap apart.
Eigen::Isometry3d parallelFaces(const TwoShapes& shapes, std::mt19937& random);

}  // namespace proximity_server::narrowphase
