#include "stress/random_geometry.h"

#include <algorithm>
#include <cmath>

#include "oracle/oracle.h"
#include "oracle/shape_pairs.h"
#include "proximity_server/narrowphase/signed_distance.h"

namespace proximity_server::narrowphase {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Points = std::vector<Vector3d>;
using Random = std::mt19937;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

double decades(Random& random, double low, double high) { return std::pow(10.0, uniform(random, low, high)); }

int below(Random& random, int count) { return std::uniform_int_distribution<int>(0, count - 1)(random); }

double eitherSign(Random& random, double value) { return below(random, 2) == 0 ? value : -value; }

Vector3d randomSizes(Random& random, double size) {
  return size * Vector3d(uniform(random, 0.2, 1), uniform(random, 0.2, 1), uniform(random, 0.2, 1));
}

double radiusOf(const Shape& shape) { return shape.coreRadius() + shape.margin(); }

double scaleOf(const TwoShapes& shapes, const Isometry3d& a_T_b) {
  return ShapePair{shapes.a, shapes.b, a_T_b}.scale();
}

Points turned(Random& random, Points points) {
  const Matrix3d rotation = randomPose(random, 0.0).linear();
  for (Vector3d& point : points) point = rotation * point;
  return points;
}

Shape primitive(Random& random, const Vector3d& size) {
  switch (below(random, 6)) {
    case 0:
      return Sphere{0.5 * size.x()};
    case 1:
      return Capsule{0.5 * size.x(), size.z()};
    case 2:
      return Box{size};
    case 3:
      return Cylinder{0.5 * size.x(), size.z()};
    case 4:
      return Cone{0.5 * size.x(), size.z()};
    default:
      return Ellipsoid{0.5 * size};
  }
}

Shape solid(Random& random, double size) {
  const Vector3d sizes = randomSizes(random, size);
  const Shape shape =
      below(random, 3) == 0 ? randomHull(random, 5 + below(random, 36), 0.5 * sizes) : primitive(random, sizes);
  return below(random, 4) == 0 ? shape.padded(size * uniform(random, 0.0, 0.2)) : shape;
}

Shape boxOrItsHull(Random& random, const Vector3d& size) {
  const Shape box = below(random, 3) == 0 ? hullOf(boxCorners(size)) : Shape(Box{size});
  return below(random, 6) == 0 ? box.padded(0.1 * size.maxCoeff()) : box;
}

Shape flat(Random& random, double size) {
  const int points = 1 + below(random, 8);
  Points cloud;
  for (int i = 0; i < points; ++i) {
    const double angle = uniform(random, 0.0, 2.0 * M_PI);
    cloud.push_back(0.5 * size * Vector3d(std::cos(angle), std::sin(angle), 0.0));
  }
  if (below(random, 4) == 0)
    for (Vector3d& point : cloud) point.y() = 0.0;
  return hullOf(below(random, 2) == 0 ? cloud : turned(random, cloud));
}

Shape sliver(Random& random, double size) {
  const double thin = size * decades(random, -6, -4);
  Vector3d sizes = randomSizes(random, size);
  if (below(random, 2) == 0)
    sizes.z() = thin;
  else
    sizes.x() = sizes.y() = thin;
  if (below(random, 3) == 0) return hullOf(turned(random, boxCorners(sizes)));
  return primitive(random, sizes);
}

Isometry3d withCentres(const TwoShapes& shapes, const Matrix3d& rotation, const Vector3d& offset) {
  Isometry3d a_T_b = Isometry3d::Identity();
  a_T_b.linear() = rotation;
  a_T_b.translation() = shapes.a.centre() + offset - rotation * shapes.b.centre();
  return a_T_b;
}

Isometry3d anywhereWithin(const TwoShapes& shapes, Random& random, double part) {
  const Isometry3d pose = randomPose(random, part * (radiusOf(shapes.a) + radiusOf(shapes.b)));
  return withCentres(shapes, pose.linear(), pose.translation());
}

double touchingGap(const TwoShapes& shapes, Random& random) {
  if (below(random, 6) == 0) return 0.0;
  const double size = std::max(std::min(radiusOf(shapes.a), radiusOf(shapes.b)), 1e-3 * radiusOf(shapes.a));
  return eitherSign(random, size * decades(random, -16, -3));
}

Isometry3d movedToGap(const TwoShapes& shapes, Isometry3d a_T_b, double gap) {
  Options exact;
  exact.distance_tolerance = 1e-14 * scaleOf(shapes, a_T_b);
  const SignedDistance now = signedDistance(shapes.a, shapes.b, a_T_b, exact);
  if (now.normal.allFinite() && std::isfinite(now.distance)) a_T_b.pretranslate((gap - now.distance) * now.normal);
  return a_T_b;
}

Matrix3d quarterTurns(Random& random) {
  const auto turn = [&] {
    return Eigen::AngleAxisd(M_PI / 2 * below(random, 4), Vector3d::Unit(below(random, 3))).toRotationMatrix();
  };
  return turn() * turn();
}

Isometry3d parallelFaces(const TwoShapes& shapes, Random& random) {
  const int axis = below(random, 3);
  const double angle = below(random, 2) == 0 ? M_PI / 12 * below(random, 24) : uniform(random, 0.0, 2.0 * M_PI);
  Matrix3d rotation = Eigen::AngleAxisd(angle, Vector3d::Unit(axis)).toRotationMatrix() * quarterTurns(random);
  if (below(random, 3) == 0)
    rotation = Eigen::AngleAxisd(decades(random, -17, -2), randomDirection(random)).toRotationMatrix() * rotation;
  const double reach = radiusOf(shapes.a) + radiusOf(shapes.b);
  Vector3d offset = 0.3 * reach * uniform(random, 0.0, 1.0) * randomDirection(random);
  if (below(random, 3) == 0) offset.setZero();
  offset[axis] = eitherSign(random, 1.5 * reach);
  return movedToGap(shapes, withCentres(shapes, rotation, offset), touchingGap(shapes, random));
}

}  // namespace proximity_server::narrowphase
