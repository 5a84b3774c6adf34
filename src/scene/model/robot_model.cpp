#include "proximity_server/scene/model/robot_model.h"

#include "proximity_server/scene/model/names.h"

#include <algorithm>
#include <iterator>

namespace proximity_server::scene {

int RobotModel::findLink(const std::string& link_name) const { return findNamed(links, link_name); }

std::vector<int> RobotModel::piecesOf(int link) const {
  const std::vector<int>& all = bodies[links[link].body].pieces;
  std::vector<int> own;
  std::copy_if(all.begin(), all.end(), std::back_inserter(own),
               [&](int piece) { return collisionOf(pieces[piece]).link == link; });
  return own;
}

bool RobotModel::hasGeometry(int link) const {
  const std::vector<int>& own = links[link].collisions;
  return std::any_of(own.begin(), own.end(), [&](int i) { return !collisions[i].pieces.empty(); });
}

std::vector<int> RobotModel::roots() const {
  std::vector<int> result;
  for (std::size_t body = 0; body < bodies.size(); ++body)
    if (bodies[body].parent < 0) result.push_back(static_cast<int>(body));
  return result;
}

std::optional<RobotModel::Connection> RobotModel::connection(int link_a, int link_b) const {
  if (bodies[links[link_a].body].robot != bodies[links[link_b].body].robot) return std::nullopt;
  Connection path;
  const auto is_decided = [&] { return path.passes_geometry && path.movable_joints > 1; };
  for (int a = link_a, b = link_b; a != b && !is_decided();) {
    int& lower = a > b ? a : b;  // parents come first, so the later link is the one that is lower on the path
    if (bodies[links[lower].body].link == lower) ++path.movable_joints;
    lower = links[lower].parent;
    const bool is_end = lower == link_a || lower == link_b;
    path.passes_geometry = path.passes_geometry || (!is_end && hasGeometry(lower));
  }
  return path;
}

bool RobotModel::areNeighbours(int link_a, int link_b) const {
  const std::optional<Connection> path = connection(link_a, link_b);
  return path && path->movable_joints == 1 && !path->passes_geometry;
}

Joint::Mimic RobotModel::leaderOf(int joint) const {
  Joint::Mimic leader{joint, 1.0, 0.0};
  while (const auto& mimic = joints[leader.joint].mimic) {
    leader.offset += leader.multiplier * mimic->offset;
    leader.multiplier *= mimic->multiplier;
    leader.joint = mimic->joint;
  }
  return leader;
}

const char* toString(Joint::Type type) {
  switch (type) {
    case Joint::Type::Revolute:
      return "revolute";
    case Joint::Type::Continuous:
      return "continuous";
    case Joint::Type::Prismatic:
      return "prismatic";
    case Joint::Type::Floating:
      return "floating";
    case Joint::Type::Planar:
      return "planar";
  }
  return "unknown";
}

bool hasOnePosition(const Joint& joint) {
  return joint.type != Joint::Type::Floating && joint.type != Joint::Type::Planar;
}

}  // namespace proximity_server::scene
