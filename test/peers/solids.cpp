#include "peers/solids.h"

#include <cmath>

#include "peers/fcl_shape.h"
#include "proximity_server/narrowphase/signed_distance.h"

namespace proximity_server::peers {

using namespace narrowphase;
namespace {

double uniform(Random& random, double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(random);
}

Eigen::Vector3d direction(Random& random) {
  std::normal_distribution<double> normal;
  return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
}

Eigen::Quaterniond orientation(Random& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
}

btVector3 toBullet(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

std::shared_ptr<btConvexShape> withoutMargin(std::shared_ptr<btConvexShape> shape) {
  shape->setMargin(0);
  return shape;
}

std::shared_ptr<btConvexShape> bulletHull(const ConvexHull& hull) {
  const auto shape = std::make_shared<btConvexHullShape>();
  for (const Eigen::Vector3d& vertex : hull.vertices()) shape->addPoint(toBullet(vertex), false);
  shape->recalcLocalAabb();
  return withoutMargin(shape);
}

Solid boxOf(const Eigen::Vector3d& half) {
  const Box box{2.0 * half};
  return {box, fclShape(box), withoutMargin(std::make_shared<btBoxShape>(toBullet(half)))};
}

/// The signed distance as a function of how far b's centre is along `axis`.
class Slide {
 public:
  Slide(const SolidPair& pair, const Eigen::Vector3d& axis) : pair_(pair), axis_(axis) {}

  SolidPair at(double centre) const {
    SolidPair pair = pair_;
    pair.a_T_b.translation() = centre * axis_;
    return pair;
  }

  /// Where the signed distance is `wanted`: it grows with the distance of the centres.
  double centreAt(double wanted) const {
    double near = 0.0, far = 4.0;
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (near + far);
      const SolidPair pair = at(middle);
      (signedDistance(pair.a->ours, pair.b->ours, pair.a_T_b).distance < wanted ? near : far) = middle;
    }
    return far;
  }

 private:
  SolidPair pair_;
  Eigen::Vector3d axis_;
};

}  // namespace

Solid randomBox(Random& random) {
  return boxOf(Eigen::Vector3d(uniform(random, 0.25, 0.5), uniform(random, 0.25, 0.5), uniform(random, 0.25, 0.5)));
}

Solid randomPlate(Random& random) { return boxOf({uniform(random, 0.25, 0.5), uniform(random, 0.25, 0.5), 0.001}); }

Solid randomSphere(Random& random) {
  const double radius = uniform(random, 0.25, 0.5);
  const Sphere sphere{radius};
  return {sphere, fclShape(sphere), std::make_shared<btSphereShape>(static_cast<btScalar>(radius))};
}

Solid randomCapsule(Random& random) {
  const double radius = uniform(random, 0.1, 0.25), length = uniform(random, 0.5, 1.0);
  const Capsule capsule{radius, length};
  return {capsule, fclShape(capsule),
          std::make_shared<btCapsuleShapeZ>(static_cast<btScalar>(radius), static_cast<btScalar>(length))};
}

Solid randomCylinder(Random& random) {
  const double radius = uniform(random, 0.2, 0.4), length = uniform(random, 0.5, 1.0);
  const Cylinder cylinder{radius, length};
  return {cylinder, fclShape(cylinder),
          withoutMargin(std::make_shared<btCylinderShapeZ>(toBullet({radius, radius, 0.5 * length})))};
}

Solid randomHull(Random& random, int vertices) {
  const Eigen::Vector3d axes(uniform(random, 0.3, 0.5), uniform(random, 0.3, 0.5), uniform(random, 0.3, 0.5));
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < vertices; ++i) points.push_back(axes.cwiseProduct(direction(random)));
  const ConvexHull hull(points);
  return {hull, fclShape(hull), bulletHull(hull)};
}

SolidPair place(const Solid& a, const Solid& b, Placement placement, Random& random) {
  SolidPair pair{&a, &b, placement, Eigen::Isometry3d::Identity()};
  pair.a_T_b.linear() = orientation(random).toRotationMatrix();
  const Slide slide(pair, direction(random));
  switch (placement) {
    case Placement::Apart:
      return slide.at(slide.centreAt(uniform(random, 0.05, 1.0)));
    case Placement::Touching:
      return slide.at(slide.centreAt(uniform(random, -1e-9, 1e-9)));
    case Placement::Shallow:
      return slide.at(slide.centreAt(-uniform(random, 0.0, 0.1)));
    case Placement::Deep:
      return slide.at(uniform(random, 0.0, 0.5) * slide.centreAt(0.0));
  }
  return pair;
}

}  // namespace proximity_server::peers
