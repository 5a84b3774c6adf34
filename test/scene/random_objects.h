#pragma once

#include "proximity_server/narrowphase/shape/shape.h"
#include "proximity_server/scene/objects/object.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "scene/small_robots.h"
#include "scene/solids.h"

#include <Eigen/Geometry>

#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace proximity_server::scene {

/// An arm of five links, some of several pieces, and a camera without geometry behind its last joint.
inline std::shared_ptr<const SceneModel> arm() {
  const auto turning = [](const std::string& parent, const std::string& child, const std::string& xyz,
                          const std::string& xyz_of_axis) {
    return joint("to_" + child, "revolute", parent, child, origin(xyz) + axis(xyz_of_axis) + limits("-3", "3"));
  };
  return modelOf(urdfOf(link("base", cylinder("0.12", "0.3") + box("0.3 0.3 0.05", "0 0 -0.15")) +
                        link("upper", box("0.1 0.08 0.3", "0 0 0.15", "0.1 0.2 0.3") + ball("0.07", "0 0 0.3")) +
                        link("fore", cylinder("0.05", "0.3", "0 0 0.2")) + link("wrist", ball("0.07", "0 0 0.05")) +
                        link("hand", box("0.05 0.08 0.1", "0.06 0 0.2") + box("0.05 0.08 0.1", "-0.06 0 0.2") +
                                         cylinder("0.03", "0.1", "0 0 0.05")) +
                        link("camera") + turning("base", "upper", "0 0 0.2", "0 0 1") +
                        turning("upper", "fore", "0 0 0.35", "0 1 0") + turning("fore", "wrist", "0 0 0.45", "1 0 0") +
                        turning("wrist", "hand", "0 0 0.15", "0 1 0") +
                        turning("hand", "camera", "0.1 0 0.1", "0 0 1")));
}

inline narrowphase::Shape someShape(Chance& chance) {
  using namespace narrowphase;
  const double size = chance.between(0.03, 0.15);
  switch (chance.below(6)) {
    case 0:
      return Sphere{size};
    case 1:
      return Capsule{size, 2 * size};
    case 2:
      return Cylinder{size, 2 * size};
    case 3:
      return Cone{size, 2 * size};
    case 4: {
      std::vector<Eigen::Vector3d> points;
      for (int i = 0; i < 10; ++i) points.push_back(size * chance.direction());
      return ConvexHull(points);
    }
    default:
      return Box{{size, 2 * size, 0.7 * size}};
  }
}

/// A mesh as its triangles, with room for whole links inside, and perhaps a cavity.
inline Object someSolid(const std::string& id, const Placement& placement, Chance& chance) {
  ObjectOptions options;
  options.meshes.tolerance = 0.0;
  options.padding = chance.below(3) == 0 ? 0.01 : 0.0;
  const TriangleMesh mesh = chance.below(2) == 0 ? bracket() : thickShell();
  return makeObject(id, {{scaled(mesh, chance.between(0.1, 0.6)), chance.pose(0.1)}}, placement, options);
}

/// An object of up to two shapes, of boxes in bulk or, if it is not attached, of half-spaces. Some have a padding.
inline Object someObject(const std::string& id, const Placement& placement, Chance& chance) {
  std::vector<ObjectShape> shapes;
  const int kind = std::holds_alternative<Attached>(placement) ? 1 + chance.below(11) : chance.below(12);
  if (kind == 0) {
    shapes.push_back({HalfSpace{chance.direction(), -chance.between(0.2, 1.0)}});
    if (chance.below(3) == 0) shapes.push_back({someShape(chance), chance.pose(0.3)});
    if (chance.below(3) == 0) shapes.push_back({HalfSpace{chance.direction(), -0.8}, chance.pose(0.1)});
  } else if (kind == 1) {
    Boxes boxes;
    for (int i = 0; i < 12; ++i) {
      const Eigen::Vector3d corner(chance.between(-0.3, 0.3), chance.between(-0.3, 0.3), chance.between(-0.3, 0.3));
      boxes.boxes.emplace_back(corner, corner + Eigen::Vector3d::Constant(0.05));
    }
    shapes.push_back({boxes, chance.pose(0.1)});
  } else {
    for (int i = chance.below(4) / 2; i >= 0; --i) shapes.push_back({someShape(chance), chance.pose(0.1)});
  }
  ObjectOptions options;
  options.padding = chance.below(3) == 0 ? 0.01 : 0.0;
  return makeObject(id, shapes, placement, options);
}

}  // namespace proximity_server::scene
