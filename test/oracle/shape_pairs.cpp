#include "oracle/shape_pairs.h"

#include <iomanip>
#include <sstream>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

const Eigen::IOFormat kAllDigits(17, Eigen::DontAlignCols, ", ", "; ");

const char* nameOf(Shape::Kind kind) {
  switch (kind) {
    case Shape::Kind::Point:
      return "point";
    case Shape::Kind::Segment:
      return "segment";
    case Shape::Kind::Box:
      return "box";
    case Shape::Kind::Cylinder:
      return "cylinder";
    case Shape::Kind::Cone:
      return "cone";
    case Shape::Kind::Ellipsoid:
      return "ellipsoid";
    case Shape::Kind::Hull:
      return "hull";
    case Shape::Kind::Sweep:
      return "sweep";
  }
  return "?";
}

void print(std::ostream& out, const Shape& shape) {
  out << nameOf(shape.kind()) << " margin " << shape.margin();
  if (shape.kind() != Shape::Kind::Hull) {
    out << " half extents " << shape.halfExtents().transpose().format(kAllDigits);
    return;
  }
  out << " vertices";
  for (const Vector3d& vertex : shape.hull().vertices()) out << " (" << vertex.transpose().format(kAllDigits) << ")";
}

}  // namespace

Shape hullOf(const std::vector<Vector3d>& points) { return ConvexHull(points); }

std::vector<Vector3d> boxCorners(const Vector3d& size) {
  std::vector<Vector3d> corners;
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5})
      for (const double z : {-0.5, 0.5}) corners.push_back(size.cwiseProduct(Vector3d(x, y, z)));
  return corners;
}

Isometry3d at(double x, double y, double z) {
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() = Vector3d(x, y, z);
  return pose;
}

std::string describe(const PairCase& pair_case) {
  std::ostringstream out;
  out << std::setprecision(17) << pair_case.name << "\n  a: ";
  print(out, pair_case.a);
  out << "\n  b: ";
  print(out, pair_case.b);
  out << "\n  a_T_b [R | t]: " << pair_case.a_T_b.matrix().topRows<3>().format(kAllDigits) << "\n";
  return out.str();
}

std::vector<NamedShape> solidShapes() {
  std::mt19937 random(11);
  return {{"sphere", Sphere{0.31}},
          {"capsule", Capsule{0.17, 0.52}},
          {"box", Box{{0.61, 0.83, 0.47}}},
          {"cylinder", Cylinder{0.29, 0.67}},
          {"cone", Cone{0.37, 0.71}},
          {"ellipsoid", Ellipsoid{{0.43, 0.31, 0.23}}},
          {"hull", randomHull(random, 32, {0.45, 0.38, 0.33})}};
}

std::vector<NamedShape> allShapes() {
  std::mt19937 random(12);
  std::vector<NamedShape> shapes = solidShapes();
  shapes.push_back({"padded box", Shape(Box{{0.4, 0.5, 0.3}}).padded(0.06)});
  shapes.push_back({"padded hull", randomHull(random, 12, {0.3, 0.4, 0.2}).padded(0.04)});
  shapes.push_back({"plate", Box{{0.7, 0.6, 0.0007}}});
  shapes.push_back({"needle", Cylinder{0.0005, 0.9}});
  shapes.push_back({"polygon", hullOf({{0.4, 0.0, 0.0}, {0.1, 0.35, 0.0}, {-0.3, 0.2, 0.0}, {-0.2, -0.4, 0.0}})});
  shapes.push_back({"segment", hullOf({{-0.2, 0.1, 0.3}, {0.25, -0.3, -0.1}})});
  shapes.push_back({"point", hullOf({{0.05, -0.02, 0.03}})});
  return shapes;
}

Vector3d randomDirection(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Vector3d v;
  do v = Vector3d(normal(random), normal(random), normal(random));
  while (v.norm() < 0.1);
  return v.normalized();
}

Isometry3d randomPose(std::mt19937& random, double reach) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> part(0.0, 1.0);
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
                      .normalized()
                      .toRotationMatrix();
  pose.translation() = reach * part(random) * randomDirection(random);
  return pose;
}

Shape randomHull(std::mt19937& random, int points, const Vector3d& half_axes) {
  std::vector<Vector3d> cloud;
  for (int i = 0; i < points; ++i) cloud.push_back(half_axes.cwiseProduct(randomDirection(random)));
  return hullOf(cloud);
}

PairCase movedTo(double distance, PairCase pair_case) {
  const Truth truth = signedDistanceOracle(pair_case.pair());
  const Vector3l motion = (distance - truth.distance) * truth.normal;
  pair_case.a_T_b.pretranslate(motion.cast<double>());
  return pair_case;
}

std::vector<PairCase> pairsInEveryState(const std::vector<NamedShape>& shapes, int poses, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  std::vector<PairCase> cases;
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (std::size_t j = i; j < shapes.size(); ++j)
      for (int k = 0; k < poses; ++k) {
        const Shape &a = shapes[i].shape, &b = shapes[j].shape;
        const std::string name = shapes[i].name + "-" + shapes[j].name;
        const PairCase near{name, a, b, randomPose(random, a.coreRadius() + b.coreRadius())};
        const auto state = [&](const char* what, double distance) {
          cases.push_back(movedTo(distance, near));
          cases.back().name += what;
        };
        state(" apart", 0.01 + part(random));
        state(" nearly touching", std::pow(10.0, -2.0 - 14.0 * part(random)));
        state(" touching", 0.0);
        state(" barely overlapping", -std::pow(10.0, -2.0 - 14.0 * part(random)));
        state(" shallow", -0.05 * part(random) * std::min(a.coreRadius() + a.margin(), b.coreRadius() + b.margin()));
        cases.push_back({name + " deep", a, b, randomPose(random, 0.2 * (a.coreRadius() + b.coreRadius()))});
        cases.push_back({name + " concentric", a, b, randomPose(random, 0.0)});
        if (k == 0) cases.push_back({name + " aligned", a, b, Isometry3d::Identity()});
      }
  return cases;
}

}  // namespace proximity_server::narrowphase
