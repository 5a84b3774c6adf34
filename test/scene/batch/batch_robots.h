#pragma once

#include "peers/robots.h"
#include "proximity_server/scene/loading/joined_robots.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "sanitized.h"
#include "scene/files.h"
#include "scene/small_robots.h"
#include "scene/solids.h"
#include "scene/two_arms.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

// Robots for the tests of many states.

namespace proximity_server::scene {

inline std::string jointOf(const std::string& parent, const std::string& child, const std::string& type,
                           const std::string& xyz, const std::string& xyz_of_axis, const std::string& more = "") {
  return joint("to_" + child, type, parent, child,
               origin(xyz, "0.2 -0.1 0.3") + axis(xyz_of_axis) + limits("-1.5", "1.5") + more);
}

/// Balls on joints of every kind, one of them large and far away: a bound by balls is as near to the distance as
/// rounding allows. Some pairs have a padding.
inline std::shared_ptr<const SceneModel> beads() {
  std::string parts =
      link("base", ball("0.2")) + link("planet", ball("40")) + weld("to_planet", "base", "planet", "3 5 -42.5");
  const auto bead = [&](const std::string& parent, const std::string& name, const std::string& type,
                        const std::string& axis, const std::string& more = "") {
    parts += link(name, ball("0.1", "0.05 0.02 0")) + jointOf(parent, name, type, "0.1 0 0.3", axis, more);
  };
  bead("base", "slide", "prismatic", "0 0 1");
  bead("base", "follower", "prismatic", "1 1 0", "<mimic joint='to_slide' multiplier='-0.5' offset='0.2'/>");
  for (const std::string arm : {"slide", "follower", "base"}) {
    const std::string name = "arm_" + arm + "_";
    bead(arm, name + "1", "revolute", "0 1 0");
    bead(name + "1", name + "2", "continuous", "1 0 0");
    bead(name + "2", name + "3", "revolute", "0.6 0 0.8");
    bead(name + "3", name + "4", "prismatic", "0 1 0");
  }
  PairFilterOptions options;
  options.pair_padding = {{{"arm_slide_4", "arm_follower_4"}, 0.05}, {{"slide", "planet"}, -0.02}};
  return modelOf(urdfOf(parts), options);
}

/// Two robots with two arms, one of them 1.2 m beside its root.
inline std::shared_ptr<const SceneModel> joinedArms() {
  const std::string aside = link("stand") + weld("stands", "stand", "torso", "1.2 0.1 0.2");
  return modelOf(joined({{"left", robotOf(urdfOf(twoArms()))}, {"right", robotOf(urdfOf(aside + twoArms()))}}));
}

/// Closed meshes with empty space inside, and small things that slide through them. `mesh_tolerance` [m]: how far
/// pieces may lie from their mesh; 0: triangles.
inline std::shared_ptr<const SceneModel> solids(double mesh_tolerance) {
  const TemporaryFiles files;
  const auto solid = [&](const TriangleMesh& triangles, const std::string& name) {
    return link(name, mesh(files.write(name + ".stl", stlOf(triangles))));
  };
  std::string parts = link("world") + solid(bracket(), "bracket") + solid(scaled(thickShell(), 0.5), "shell") +
                      solid(dentedBall(), "dented");
  parts += jointOf("world", "bracket", "revolute", "-0.5 0 0", "0 0 1") +
           jointOf("world", "shell", "revolute", "0.8 0 0", "0 1 0") +
           jointOf("world", "dented", "prismatic", "0 0.6 0.2", "1 0 0");
  for (const std::string name : {"pea", "rod"}) {
    parts += link(name + "x") + link(name + "y") + link(name, name == "pea" ? ball("0.05") : cylinder("0.04", "0.2"));
    parts += jointOf("world", name + "x", "prismatic", "0 0 0", "1 0 0") +
             jointOf(name + "x", name + "y", "prismatic", "0 0 0", "0 1 0") +
             jointOf(name + "y", name, "prismatic", "0 0 0", "0 0 1");
  }
  ModelOptions options;
  options.mesh_tolerance = mesh_tolerance;
  return modelOf(robotOf(urdfOf(parts), options));
}

/// Links without any candidate pair.
inline std::shared_ptr<const SceneModel> nothingToCheck() {
  return modelOf(
      urdfOf(link("a", ball("0.1")) + link("b", ball("0.1")) + jointOf("a", "b", "revolute", "0 0 1", "0 1 0")));
}

/// A robot by its name, loaded once; nullptr for an example robot that is not found, and under a sanitizer for those
/// whose meshes take minutes there.
inline std::shared_ptr<const SceneModel> robotNamed(const std::string& name) {
  static std::map<std::string, std::shared_ptr<const SceneModel>> known;
  if (const auto found = known.find(name); found != known.end()) return found->second;
  if (name == "TwoArms") return known[name] = modelOf(urdfOf(twoArms()));
  if (name == "Beads") return known[name] = beads();
  if (name == "JoinedArms") return known[name] = joinedArms();
  if (name == "Solids") return known[name] = solids(0.0);
  if (name == "SolidsInParts") return known[name] = solids(0.02);
  if (kIsSanitized) return nullptr;
  if (name == "Demo") return known[name] = peers::demoRobot().model;
  for (const peers::NamedRobot& robot : peers::exampleRobots()) known[robot.name] = robot.model;
  return known[name];
}

}  // namespace proximity_server::scene
