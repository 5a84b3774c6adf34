#include "peers/cells.h"

#include "chance.h"
#include "oracle/shape_pairs.h"
#include "scene/example_robots.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::peers {

using namespace narrowphase;
namespace {

using Eigen::AlignedBox3d;
using Eigen::Isometry3d;
using Eigen::Vector3d;

const Vector3d kShoulder(0.0, 0.0, 0.333);  // [m] of Panda
constexpr double kNear = 0.75, kFar = 2.5;  // [m] Panda's hand reaches 0.96

Vector3d placeAround(Chance& random) { return kShoulder + random.between(kNear, kFar) * randomDirection(random); }

Isometry3d poseAround(Chance& random) {
  Isometry3d pose = randomPose(random, 0.0);
  pose.translation() = placeAround(random);
  return pose;
}

Object randomBox(int number, Chance& random) {
  const auto edge = [&] { return random.between(0.02, 0.2); };
  const Vector3d size(edge(), edge(), edge());
  return makeObject("box " + std::to_string(number), {{Shape(Box{size})}}, Fixed{poseAround(random)});
}

/// Returns cubes of a lattice on four walls and the boards of two shelves, the nearest to the shoulder first.
std::vector<AlignedBox3d> map(std::size_t count) {
  constexpr double kEdge = 0.04;
  constexpr int kHalf = 50;
  std::vector<AlignedBox3d> boxes;
  for (int x = -kHalf; x <= kHalf; ++x)
    for (int y = -kHalf; y <= kHalf; ++y)
      for (int z = -10; z <= kHalf; ++z) {
        const bool is_wall = std::abs(x) == 35 || std::abs(y) == 35;
        const bool is_board = std::abs(x) >= 18 && std::abs(x) < 35 && std::abs(y) < 30 && z % 12 == 0;
        const Vector3d corner = kEdge * Vector3d(x, y, z);
        const bool is_near = (corner - kShoulder).norm() < kNear;
        if ((is_wall || is_board) && !is_near) boxes.emplace_back(corner, corner + Vector3d::Constant(kEdge));
      }
  const auto isNearer = [](const AlignedBox3d& a, const AlignedBox3d& b) {
    return (a.center() - kShoulder).squaredNorm() < (b.center() - kShoulder).squaredNorm();
  };
  std::stable_sort(boxes.begin(), boxes.end(), isNearer);
  boxes.resize(std::min(count, boxes.size()));
  return boxes;
}

std::vector<ObjectChange> meshes(const MeshResolver& resolve) {
  Chance random(1);
  ObjectOptions options;
  options.resolve = resolve;
  const std::string folder = "package://example-robot-data/robots/panda_description/meshes/collision/";
  const std::vector<std::string> files{"hand", "link0", "link1", "link2", "link3", "link4", "link5", "link6", "link7"};
  std::vector<Object> models;
  for (const std::string& file : files)
    models.push_back(makeObject(file, {{MeshFile{folder + file + ".stl"}}}, Fixed{}, options));
  std::vector<ObjectChange> changes;
  for (int i = 0; i < 100; ++i) {
    Object object = models[static_cast<std::size_t>(i) % models.size()];
    object.id = "mesh " + std::to_string(i);
    object.placement = Fixed{poseAround(random)};
    changes.emplace_back(AddObject{object});
  }
  return changes;
}

std::vector<ObjectChange> boxes(int count) {
  Chance random(2);
  std::vector<ObjectChange> changes;
  for (int i = 0; i < count; ++i) changes.emplace_back(AddObject{randomBox(i, random)});
  return changes;
}

std::vector<ObjectChange> mapOfOneObject() { return {AddObject{makeObject("map", {{Boxes{map(10000)}}}, Fixed{})}}; }

std::vector<ObjectChange> mapOfManyObjects() {
  std::vector<ObjectChange> changes;
  for (const AlignedBox3d& box : map(10000)) {
    const Isometry3d place(Eigen::Translation3d(box.center()));
    const std::string id = "cell " + std::to_string(changes.size());
    changes.emplace_back(AddObject{makeObject(id, {{Shape(Box{box.sizes()})}}, Fixed{place})});
  }
  return changes;
}

}  // namespace

Object boxOfCell(int number) {
  Chance random(static_cast<unsigned>(1000 + number));
  return makeObject("new " + std::to_string(number), {{Shape(Box{{0.1, 0.1, 0.1}})}}, Fixed{poseAround(random)});
}

std::vector<NamedCell> pandaCells(const NamedRobot& panda) {
  ObjectRules rules;
  rules.base = ObjectRules::Base::StandsStill;
  const Objects none = Objects(panda.model).withRules(rules);
  const auto cell = [&](const std::string& name, const std::vector<ObjectChange>& changes) {
    return NamedCell{"Panda + " + name, panda.model, std::make_shared<const Objects>(none.changed(changes))};
  };
  return {cell("100 meshes", meshes(exampleRobotsResolver())), cell("1000 boxes", boxes(1000)),
          cell("10,000 boxes, one object", mapOfOneObject()), cell("10,000 boxes, an object each", mapOfManyObjects())};
}

}  // namespace proximity_server::peers
