#include "stress/random_geometry.h"

#include "oracle/oracle.h"
#include "oracle/shape_pairs.h"
#include "proximity_server/narrowphase/signed_distance.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::narrowphase {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

Vector3d randomSizes(Chance& chance, double size) {
  return size * Vector3d(chance.between(0.2, 1), chance.between(0.2, 1), chance.between(0.2, 1));
}

double radiusOf(const Shape& shape) { return shape.coreRadius() + shape.margin(); }

double scaleOf(const TwoShapes& shapes, const Isometry3d& a_T_b) {
  return ShapePair{shapes.a, shapes.b, a_T_b}.scale();
}

Points turned(Chance& chance, Points points) {
  const Matrix3d rotation = randomPose(chance, 0.0).linear();
  for (Vector3d& point : points) point = rotation * point;
  return points;
}

Shape primitive(Chance& chance, const Vector3d& size) {
  const double radius = 0.5 * size.x(), length = size.z();
  const Shape shapes[] = {Sphere{radius},           Capsule{radius, length}, Box{size},
                          Cylinder{radius, length}, Cone{radius, length},    Ellipsoid{0.5 * size}};
  return chance.oneOf(shapes);
}

Shape solid(Chance& chance, double size) {
  const Vector3d sizes = randomSizes(chance, size);
  const Shape shape =
      chance.below(3) == 0 ? randomHull(chance, 5 + chance.below(36), 0.5 * sizes) : primitive(chance, sizes);
  return chance.below(4) == 0 ? shape.padded(size * chance.between(0.0, 0.2)) : shape;
}

Shape boxOrItsHull(Chance& chance, const Vector3d& size) {
  const Shape box = chance.below(3) == 0 ? hullOf(boxCorners(size)) : Shape(Box{size});
  return chance.below(6) == 0 ? box.padded(0.1 * size.maxCoeff()) : box;
}

Shape flat(Chance& chance, double size) {
  const int points = 1 + chance.below(8);
  Points cloud;
  for (int i = 0; i < points; ++i) {
    const double angle = chance.between(0.0, 2.0 * M_PI);
    cloud.push_back(0.5 * size * Vector3d(std::cos(angle), std::sin(angle), 0.0));
  }
  if (chance.below(4) == 0)
    for (Vector3d& point : cloud) point.y() = 0.0;
  return hullOf(chance.below(2) == 0 ? cloud : turned(chance, cloud));
}

Shape sliver(Chance& chance, double size) {
  const double thin = size * chance.decades(-6, -4);
  Vector3d sizes = randomSizes(chance, size);
  if (chance.below(2) == 0)
    sizes.z() = thin;
  else
    sizes.x() = sizes.y() = thin;
  if (chance.below(3) == 0) return hullOf(turned(chance, boxCorners(sizes)));
  return primitive(chance, sizes);
}

Isometry3d withCentres(const TwoShapes& shapes, const Matrix3d& rotation, const Vector3d& offset) {
  Isometry3d a_T_b = Isometry3d::Identity();
  a_T_b.linear() = rotation;
  a_T_b.translation() = shapes.a.centre() + offset - rotation * shapes.b.centre();
  return a_T_b;
}

Isometry3d anywhereWithin(const TwoShapes& shapes, Chance& chance, double part) {
  const Isometry3d pose = randomPose(chance, part * (radiusOf(shapes.a) + radiusOf(shapes.b)));
  return withCentres(shapes, pose.linear(), pose.translation());
}

double touchingGap(const TwoShapes& shapes, Chance& chance) {
  if (chance.below(6) == 0) return 0.0;
  const double size = std::max(std::min(radiusOf(shapes.a), radiusOf(shapes.b)), 1e-3 * radiusOf(shapes.a));
  return chance.eitherSign(size * chance.decades(-16, -3));
}

Isometry3d movedToGap(const TwoShapes& shapes, Isometry3d a_T_b, double gap) {
  Options exact;
  exact.distance_tolerance = 1e-14 * scaleOf(shapes, a_T_b);
  const SignedDistance now = signedDistance(shapes.a, shapes.b, a_T_b, exact);
  if (now.normal.allFinite() && std::isfinite(now.distance)) a_T_b.pretranslate((gap - now.distance) * now.normal);
  return a_T_b;
}

Matrix3d quarterTurns(Chance& chance) {
  const auto turn = [&] {
    return Eigen::AngleAxisd(M_PI / 2 * chance.below(4), Vector3d::Unit(chance.below(3))).toRotationMatrix();
  };
  return turn() * turn();
}

Isometry3d parallelFaces(const TwoShapes& shapes, Chance& chance) {
  const int axis = chance.below(3);
  const double angle = chance.below(2) == 0 ? M_PI / 12 * chance.below(24) : chance.between(0.0, 2.0 * M_PI);
  Matrix3d rotation = Eigen::AngleAxisd(angle, Vector3d::Unit(axis)).toRotationMatrix() * quarterTurns(chance);
  if (chance.below(3) == 0)
    rotation = Eigen::AngleAxisd(chance.decades(-17, -2), randomDirection(chance)).toRotationMatrix() * rotation;
  const double reach = radiusOf(shapes.a) + radiusOf(shapes.b);
  Vector3d offset = 0.3 * reach * chance.between(0.0, 1.0) * randomDirection(chance);
  if (chance.below(3) == 0) offset.setZero();
  offset[axis] = chance.eitherSign(1.5 * reach);
  return movedToGap(shapes, withCentres(shapes, rotation, offset), touchingGap(shapes, chance));
}

}  // namespace proximity_server::narrowphase
