// A program of somebody who uses the library. It is compiled for any processor and for one with AVX and fused
// multiplication; each time it prints what it sees: the layout of the public types, what the library left in them, and
// the bits of results.
#include "proximity_server/narrowphase/motion/motion.h"
#include "proximity_server/narrowphase/shape/support.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"

#include <cstdio>
#include <random>
#include <string>
#include <vector>

namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using namespace proximity_server::narrowphase;
using namespace proximity_server::scene;

constexpr int kExitSkipped = 77;

template <class Type>
void printLayout(const char* name) {
  std::printf("%s: %zu bytes, aligned to %zu\n", name, sizeof(Type), alignof(Type));
}

void printBits(const char* what, const Vector3d& vector) {
  std::printf("%s %a %a %a\n", what, vector.x(), vector.y(), vector.z());
}

void printLayouts() {
  printLayout<Isometry3d>("Isometry3d");
  printLayout<Shape>("Shape");
  printLayout<Shape::Sweep>("Shape::Sweep");
  printLayout<SignedDistance>("SignedDistance");
  printLayout<ScrewMotion>("ScrewMotion");
  printLayout<Piece>("Piece");
  printLayout<Link>("Link");
  printLayout<Joint>("Joint");
  printLayout<BodyPoses::value_type>("BodyPoses::value_type");
}

/// Prints the members of public structs that the library has written, as this unit reads them.
void printRobot() {
  const RobotModel robot = loadRobotModel(R"(<robot name="r">
    <link name="base"><collision><origin xyz="1 2 3"/><geometry><box size="0.1 0.2 0.3"/></geometry></collision></link>
    <link name="flange"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
    <link name="tool"><collision><geometry><sphere radius="0.2"/></geometry></collision></link>
    <joint name="lift" type="prismatic"><parent link="base"/><child link="flange"/><origin xyz="4 5 6"/>
      <axis xyz="0 0 1"/><limit lower="-7" upper="8" effort="1" velocity="9"/></joint>
    <joint name="fixed" type="fixed"><parent link="flange"/><child link="tool"/><origin xyz="10 11 12"/></joint>
    </robot>)",
                                          [](const std::string& uri) { return uri; });
  for (const Piece& piece : robot.pieces) printBits("piece", piece.body_T_piece.translation());
  for (const Link& link : robot.links) printBits(link.name.c_str(), link.body_T_link.translation());
  for (const Joint& joint : robot.joints) {
    printBits(joint.name.c_str(), joint.parent_T_joint.translation());
    std::printf("limits %a %a\n", joint.lower, joint.upper);
  }
  for (const auto& pose : forwardKinematics(robot, std::vector<double>{0.5})) printBits("body", pose->translation());
}

Vector3d randomVector(std::mt19937& random) {
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  const double x = coordinate(random), y = coordinate(random), z = coordinate(random);
  return {x, y, z};
}

void printResults() {
  std::mt19937 random(5);  // the standard says which numbers it gives
  std::vector<Vector3d> cloud;
  for (int i = 0; i < 40; ++i) cloud.push_back(randomVector(random));
  const std::vector<Shape> shapes = {Capsule{0.1, 0.7}, Box{{0.3, 0.4, 0.5}},        Cylinder{0.3, 0.7},
                                     Cone{0.3, 0.7},    Ellipsoid{{0.3, 0.7, 0.43}}, ConvexHull(cloud)};
  for (const Shape& a : shapes) {
    int vertex = 0;
    for (int i = 0; i < 50; ++i) printBits("support point", supportPoint(a, randomVector(random), vertex));
    for (const Shape& b : shapes) {
      Isometry3d a_T_b = Isometry3d::Identity();
      a_T_b.linear().diagonal() = Vector3d(-1.0, -1.0, 1.0);  // half a turn, made without rounding
      a_T_b.translation() = randomVector(random);
      const SignedDistance answer = signedDistance(a, b, a_T_b);
      std::printf("distance %a\n", answer.distance);
      printBits("point", answer.point_a);
    }
  }
}

}  // namespace

int main() {
#ifdef __FMA__
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return kExitSkipped;
#endif
  printLayouts();
  printRobot();
  printResults();
}
