#include "peers/solids.h"

#include "proximity_server/narrowphase/signed_distance.h"
#include "tools/second_opinion/fcl_shape.h"

#include <cmath>

namespace proximity_server::peers {

using namespace narrowphase;
namespace {

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

/// Returns nullptr if Bullet has no such shape.
std::shared_ptr<btConvexShape> bulletShape(const Shape& shape) {
  const Eigen::Vector3d& half = shape.halfExtents();
  switch (shape.kind()) {
    case Shape::Kind::Point:
      return std::make_shared<btSphereShape>(static_cast<btScalar>(shape.margin()));
    case Shape::Kind::Segment:
      return std::make_shared<btCapsuleShapeZ>(static_cast<btScalar>(shape.margin()),
                                               static_cast<btScalar>(2.0 * half.z()));
    case Shape::Kind::Box:
      return withoutMargin(std::make_shared<btBoxShape>(toBullet(half)));
    case Shape::Kind::Cylinder:
      return withoutMargin(std::make_shared<btCylinderShapeZ>(toBullet(half)));
    case Shape::Kind::Hull:
      return bulletHull(shape.hull());
    default:
      return nullptr;
  }
}

Solid boxOf(const Eigen::Vector3d& half) { return *solidOf(Box{2.0 * half}); }

/// The signed distance as a function of how far b's centre is along `axis`.
class Slide {
 public:
  Slide(const SolidPair& pair, const Eigen::Vector3d& axis) : pair_(pair), axis_(axis) {}

  SolidPair at(double centre) const {
    SolidPair pair = pair_;
    pair.a_T_b.translation() = centre * axis_;
    return pair;
  }

  /// Returns where the signed distance is `wanted`: it grows with the distance of the centres.
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

Eigen::Vector3d randomAxis(Random& random) {
  std::normal_distribution<double> normal;
  return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
}

Eigen::Quaterniond randomTurn(Random& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
}

std::optional<Solid> solidOf(const Shape& shape) {
  const bool is_round = shape.kind() == Shape::Kind::Point || shape.kind() == Shape::Kind::Segment;
  if (!is_round && shape.margin() != 0.0) return std::nullopt;
  if (shape.kind() == Shape::Kind::Hull && shape.hull().dimension() < 3) return std::nullopt;
  const std::shared_ptr<btConvexShape> bullet = bulletShape(shape);
  if (!bullet) return std::nullopt;
  return Solid{shape, tools::fclShape(shape), bullet};
}

Solid randomBox(Random& random) {
  return boxOf(Eigen::Vector3d(random.between(0.25, 0.5), random.between(0.25, 0.5), random.between(0.25, 0.5)));
}

Solid randomPlate(Random& random) { return boxOf({random.between(0.25, 0.5), random.between(0.25, 0.5), 0.001}); }

Solid randomSphere(Random& random) { return *solidOf(Sphere{random.between(0.25, 0.5)}); }

Solid randomCapsule(Random& random) {
  const double radius = random.between(0.1, 0.25), length = random.between(0.5, 1.0);
  return *solidOf(Capsule{radius, length});
}

Solid randomCylinder(Random& random) {
  const double radius = random.between(0.2, 0.4), length = random.between(0.5, 1.0);
  return *solidOf(Cylinder{radius, length});
}

Solid randomHull(Random& random, int vertices) {
  const Eigen::Vector3d axes(random.between(0.3, 0.5), random.between(0.3, 0.5), random.between(0.3, 0.5));
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < vertices; ++i) points.push_back(axes.cwiseProduct(randomAxis(random)));
  return *solidOf(ConvexHull(points));
}

SolidPair place(const Solid& a, const Solid& b, Placement placement, Random& random) {
  SolidPair pair{&a, &b, placement, Eigen::Isometry3d::Identity()};
  pair.a_T_b.linear() = randomTurn(random).toRotationMatrix();
  const Slide slide(pair, randomAxis(random));
  switch (placement) {
    case Placement::Apart:
      return slide.at(slide.centreAt(random.between(0.05, 1.0)));
    case Placement::Touching:
      return slide.at(slide.centreAt(random.between(-1e-9, 1e-9)));
    case Placement::Shallow:
      return slide.at(slide.centreAt(-random.between(0.0, 0.1)));
    case Placement::Deep:
      return slide.at(random.between(0.0, 0.5) * slide.centreAt(0.0));
  }
  return pair;
}

}  // namespace proximity_server::peers
