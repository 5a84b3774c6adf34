#include "proximity_server/scene/model/robot_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>

#include "scene/mesh/input_limits.h"
#include "scene/model/bounds.h"
#include "scene/model/collision_geometry.h"
#include "scene/model/names.h"
#include "scene/model/urdf_document.h"

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <typename Named>
std::vector<std::string> namesOf(const std::vector<Named>& things) {
  std::vector<std::string> names;
  names.reserve(things.size());
  for (const Named& thing : things) names.push_back(thing.name);
  return names;
}

template <typename Named>
int findNamed(const std::vector<Named>& things, const std::string& name) {
  const auto hit = std::find_if(things.begin(), things.end(), [&](const Named& thing) { return thing.name == name; });
  return hit == things.end() ? -1 : static_cast<int>(hit - things.begin());
}

template <typename Thing>
int append(std::vector<Thing>& things, Thing thing) {
  things.push_back(std::move(thing));
  return static_cast<int>(things.size()) - 1;
}

Joint::Type typeOf(const urdf::Joint& joint) {
  switch (joint.type) {
    case urdf::Joint::REVOLUTE:
      return Joint::Type::Revolute;
    case urdf::Joint::CONTINUOUS:
      return Joint::Type::Continuous;
    case urdf::Joint::PRISMATIC:
      return Joint::Type::Prismatic;
    case urdf::Joint::FLOATING:
      return Joint::Type::Floating;
    case urdf::Joint::PLANAR:
      return Joint::Type::Planar;
    default:
      throw std::invalid_argument("URDF: joint " + quoted(joint.name) + " is of no known type");
  }
}

Vector3d axisOf(const urdf::Joint& joint) {
  if (joint.type == urdf::Joint::FLOATING) return Vector3d::UnitZ();
  Vector3d axis = Vector3d(joint.axis.x, joint.axis.y, joint.axis.z).stableNormalized();
  if (!(axis.norm() > 0.5)) {
    throw std::invalid_argument("URDF: joint " + quoted(joint.name) + " has an axis of length zero");
  }
  return axis;
}

/// Of the joint in its parent link.
Isometry3d originOf(const urdf::Joint& joint) {
  const Isometry3d origin = toEigen(joint.parent_to_joint_origin_transform);
  // Written as !(norm <= farthest) so that NaN is refused too.
  if (!origin.matrix().allFinite() || !(origin.translation().norm() <= kFarthest)) {
    throw std::invalid_argument("URDF: joint " + quoted(joint.name) +
                                " has an <origin> that is not finite, or farther than 1e6 m from its parent");
  }
  return origin;
}

Joint readJoint(const urdf::Joint& joint, int parent_link, int child_link, std::vector<std::string>& warnings) {
  Joint result{joint.name,    typeOf(joint), parent_link, child_link, originOf(joint),
               axisOf(joint), -kInfinity,    kInfinity,   kInfinity,  std::nullopt};
  if (!joint.limits) return result;
  // Many URDFs write 0 for "unknown"; a joint that may not move would be a fixed one.
  if (joint.limits->velocity > 0) result.max_velocity = joint.limits->velocity;
  if (result.type != Joint::Type::Revolute && result.type != Joint::Type::Prismatic) return result;
  if (joint.limits->lower > joint.limits->upper) {
    warnings.push_back("joint " + quoted(joint.name) + ": its lower limit is above the upper one; taken as unlimited.");
    return result;
  }
  if (joint.limits->lower >= -kFarthest) result.lower = joint.limits->lower;
  if (joint.limits->upper <= kFarthest) result.upper = joint.limits->upper;
  if (std::isinf(result.lower) || std::isinf(result.upper)) {
    warnings.push_back("joint " + quoted(joint.name) + ": a limit beyond 1e6; taken as none.");
  }
  return result;
}

/// Adds a link, in the body of its parent or, below a movable joint, in one of its own. Returns its index.
int addLink(const urdf::Link& link, int parent_link, RobotModel& model) {
  const int index = append(model.links, Link{link.name, -1, Isometry3d::Identity(), {}, parent_link});
  Link& added = model.links[index];
  if (parent_link < 0) {
    added.body = append(model.bodies, Body{index, -1, -1, {}, {}});
  } else if (const urdf::Joint& joint = *link.parent_joint; joint.type == urdf::Joint::FIXED) {
    const Link& parent = model.links[parent_link];
    added.body = parent.body;
    added.body_T_link = parent.body_T_link * originOf(joint);
    model.fixed_joints.push_back(joint.name);
  } else {
    const int carrier = append(model.joints, readJoint(joint, parent_link, index, model.warnings));
    added.body = append(model.bodies, Body{index, carrier, model.links[parent_link].body, {}, {}});
  }
  model.bodies[added.body].links.push_back(index);
  return index;
}

/// Links, joints and bodies, depth first from the root, so parents first.
void addTree(const urdf::ModelInterface& urdf, RobotModel& model) {
  struct Pending {
    urdf::LinkConstSharedPtr link;
    int parent;
  };
  std::vector<Pending> pending{{urdf.getRoot(), -1}};
  while (!pending.empty()) {
    const Pending next = pending.back();
    pending.pop_back();
    const int index = addLink(*next.link, next.parent, model);
    const auto& children = next.link->child_links;
    for (auto child = children.rbegin(); child != children.rend(); ++child) pending.push_back({*child, index});
  }
}

/// What is wrong with the chain of joints that a joint mimics, or "".
std::string faultOfMimic(const RobotModel& model, int joint) {
  int follower = joint;
  for (std::size_t steps = 0; model.joints[follower].mimic; ++steps) {
    if (steps == model.joints.size()) return "mimics itself in a circle";
    follower = model.joints[follower].mimic->joint;
  }
  // Multipliers and offsets multiply along the chain. Written as !(x <= farthest) so that NaN is refused too.
  const Joint::Mimic leader = model.leaderOf(joint);
  const bool is_small = std::abs(leader.multiplier) <= kFarthest && std::abs(leader.offset) <= kFarthest;
  return is_small ? "" : "mimics with a multiplier or an offset beyond 1e6";
}

/// For each link, whether it or a link that hangs on it has a <collision>.
std::vector<bool> linksThatCarryGeometry(const urdf::ModelInterface& urdf, const RobotModel& model) {
  std::vector<bool> carries;
  for (const Link& link : model.links) carries.push_back(!urdf.getLink(link.name)->collision_array.empty());
  for (std::size_t i = model.links.size(); i-- > 1;) {  // parents come first
    if (carries[i]) carries[model.links[i].parent] = true;
  }
  return carries;
}

/// The joints that mimic another one. A mimic that makes no sense is an error where the joint moves geometry; else it
/// is a warning, and the joint has a position of its own.
class MimicReader {
 public:
  MimicReader(const urdf::ModelInterface& urdf, RobotModel& model)
      : urdf_(urdf), model_(model), carries_geometry_(linksThatCarryGeometry(urdf, model)) {}

  void readAll() {
    for (Joint& joint : model_.joints) read(joint);
    std::vector<std::pair<int, std::string>> faults;  // all of them first: without one, another would look right
    for (int i = 0; i < static_cast<int>(model_.joints.size()); ++i) {
      if (const std::string fault = faultOfMimic(model_, i); !fault.empty()) faults.emplace_back(i, fault);
    }
    for (const auto& [joint, fault] : faults) refuse(model_.joints[joint], fault);
  }

 private:
  void read(Joint& joint) {
    const auto& mimic = urdf_.getJoint(joint.name)->mimic;
    if (!mimic) return;
    if (!urdf_.getJoint(mimic->joint_name)) {
      return refuse(joint, "mimics the unknown joint " + unknownName(mimic->joint_name, namesOf(model_.joints)));
    }
    const int leader = findNamed(model_.joints, mimic->joint_name);
    if (leader < 0 || !hasOnePosition(model_.joints[leader]) || !hasOnePosition(joint)) {
      return warn(joint, "mimics joint " + quoted(mimic->joint_name) + ": not both of them have a position");
    }
    joint.mimic = Joint::Mimic{leader, mimic->multiplier, mimic->offset};
  }

  void refuse(Joint& joint, const std::string& fault) {
    if (carries_geometry_[joint.child_link]) {
      throw std::invalid_argument("URDF: joint " + quoted(joint.name) + " " + fault);
    }
    joint.mimic.reset();
    warn(joint, fault + ", but moves no geometry");
  }

  void warn(const Joint& joint, const std::string& fault) {
    model_.warnings.push_back("joint " + quoted(joint.name) + " " + fault + "; taken as a joint of its own.");
  }

  const urdf::ModelInterface& urdf_;
  RobotModel& model_;
  const std::vector<bool> carries_geometry_;
};

/// What holds for a link: its own value, or the default.
double valueOf(const std::string& link, const std::map<std::string, double>& own_values, double default_value) {
  const auto own = own_values.find(link);
  return own == own_values.end() ? default_value : own->second;
}

double paddingOf(const std::string& link, const ModelOptions& options) {
  return valueOf(link, options.link_padding, options.default_padding);
}

MeshOptions meshOptionsOf(const std::string& link, const ModelOptions& options) {
  MeshOptions meshes;
  meshes.tolerance = valueOf(link, options.link_mesh_tolerance, options.mesh_tolerance);
  meshes.cache = options.mesh_cache;
  meshes.time_budget = options.mesh_time_budget;
  if (options.progress) {
    meshes.progress = [link, tell = options.progress](const std::string& what) {
      tell("link " + quoted(link) + ": " + what);
    };
  }
  return meshes;
}

void addOnce(const std::string& warning, std::vector<std::string>& warnings) {
  if (std::find(warnings.begin(), warnings.end(), warning) == warnings.end()) warnings.push_back(warning);
}

/// The geometry of one <collision>; none, with a warning, for a mesh that cannot be read where that is allowed.
CollisionGeometry readGeometry(const urdf::Geometry& geometry, const std::string& where, const std::string& link,
                               const ModelOptions& options, GeometryReader& reader,
                               std::vector<std::string>& warnings) {
  try {
    CollisionGeometry result = reader.read(geometry, meshOptionsOf(link, options));
    for (const std::string& warning : result.warnings) addOnce(warning + ".", warnings);
    if (!result.shortfall.empty()) warnings.push_back(where + ", " + result.shortfall + ".");
    return result;
  } catch (const std::invalid_argument& error) {
    const auto* mesh = dynamic_cast<const urdf::Mesh*>(&geometry);
    if (!mesh || !options.allow_missing_meshes) throw;
    warnings.push_back(where + " has no geometry: " + error.what() + ".");
    return {"mesh " + mesh->filename + ", missing", {}};
  }
}

void checkReach(const Piece& piece) {
  const double reach = reachFrom(Vector3d::Zero(), piece);
  if (reach <= kFarthest) return;
  std::ostringstream text;
  text << "it reaches " << reach << " m from the frame of its body, farther than 1e6 m";
  throw std::invalid_argument(text.str());
}

/// Across the box around a mesh [m]: no link of a robot is that large, but one of 2 cm in millimetres is.
constexpr double kOddlyLarge = 20.0;

void warnOfMillimetres(const urdf::Geometry& urdf, const CollisionGeometry& geometry, const std::string& where,
                       std::vector<std::string>& warnings) {
  if (!dynamic_cast<const urdf::Mesh*>(&urdf)) return;
  Eigen::AlignedBox3d box;
  for (const narrowphase::Shape& shape : geometry.shapes) {
    for (const Vector3d& vertex : shape.hull().vertices()) box.extend(vertex);
  }
  const double size = geometry.shapes.empty() ? 0.0 : box.diagonal().norm();
  if (size < kOddlyLarge) return;
  std::ostringstream text;
  text << where << ": " << geometry.description << " is " << size << " m across. If it is in millimetres, it needs "
       << "scale=\"0.001 0.001 0.001\".";
  warnings.push_back(text.str());
}

/// Adds one <collision> and the pieces that stand for it alone.
void addCollision(int link, const urdf::Collision& urdf, const ModelOptions& options, GeometryReader& reader,
                  RobotModel& model) {
  Link& owner = model.links[link];
  const int number = static_cast<int>(owner.collisions.size()) + 1;
  const std::string where = "link " + quoted(owner.name) + ", <collision> " + std::to_string(number);
  try {
    CollisionGeometry geometry = readGeometry(*urdf.geometry, where, owner.name, options, reader, model.warnings);
    warnOfMillimetres(*urdf.geometry, geometry, where, model.warnings);
    const Isometry3d body_T_collision = owner.body_T_link * toEigen(urdf.origin);
    if (!body_T_collision.matrix().allFinite()) throw std::invalid_argument("its pose is not finite");
    if (model.collisions.size() == kMostCollisions || model.pieces.size() + geometry.shapes.size() > kMostPieces) {
      throw std::invalid_argument("the robot has more than 20000 <collision> elements, or a million convex pieces");
    }

    Collision collision{urdf.name, geometry.description,    link,
                        number,    geometry.representation, geometry.deviation,
                        {},        geometry.uncovered,      geometry.volume_ratio};
    const int index = static_cast<int>(model.collisions.size());
    for (const narrowphase::Shape& shape : geometry.shapes) {
      const narrowphase::Shape padded = shape.padded(paddingOf(owner.name, options));
      collision.pieces.push_back(append(model.pieces, Piece{padded, body_T_collision, index}));
      checkReach(model.pieces.back());
    }
    owner.collisions.push_back(append(model.collisions, std::move(collision)));
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("URDF: " + where + ": " + error.what());
  }
}

/// Gives the body the pieces of a link: those of its collisions, but a capsule instead of its three parts.
void addPiecesToBody(int link, const std::vector<CapsuleParts>& capsules, const ModelOptions& options,
                     RobotModel& model) {
  const Link& owner = model.links[link];
  std::vector<int>& body_pieces = model.bodies[owner.body].pieces;
  std::set<int> replaced;
  for (const CapsuleParts& parts : capsules) {
    const int index = owner.collisions[parts.cylinder];
    Collision& cylinder = model.collisions[index];
    const Isometry3d body_T_capsule = model.pieces[cylinder.pieces.front()].body_T_piece;
    const narrowphase::Shape padded = narrowphase::Shape(parts.capsule).padded(paddingOf(owner.name, options));
    body_pieces.push_back(append(model.pieces, Piece{padded, body_T_capsule, index}));
    cylinder.description += ", a capsule with <collision> " + std::to_string(parts.spheres[0] + 1) + " and " +
                            std::to_string(parts.spheres[1] + 1);
    replaced.insert({parts.cylinder, parts.spheres[0], parts.spheres[1]});
  }
  for (int i = 0; i < static_cast<int>(owner.collisions.size()); ++i) {
    if (replaced.count(i)) continue;
    const std::vector<int>& pieces = model.collisions[owner.collisions[i]].pieces;
    body_pieces.insert(body_pieces.end(), pieces.begin(), pieces.end());
  }
}

void readMeshesAhead(const urdf::ModelInterface& urdf, const ModelOptions& options, const RobotModel& model,
                     GeometryReader& reader) {
  std::vector<MeshRequest> requests;
  for (const Link& link : model.links) {
    for (const auto& collision : urdf.getLink(link.name)->collision_array) {
      if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(collision->geometry.get()))
        requests.push_back({mesh, meshOptionsOf(link.name, options)});
    }
  }
  using Failure = GeometryReader::Failure;
  reader.readAhead(requests, options.threads, options.allow_missing_meshes ? Failure::IsPassedOver : Failure::EndsIt);
}

void addGeometry(const urdf::ModelInterface& urdf, const MeshResolver& resolve, const ModelOptions& options,
                 RobotModel& model) {
  GeometryReader reader(resolve);
  readMeshesAhead(urdf, options, model, reader);
  for (int link = 0; link < static_cast<int>(model.links.size()); ++link) {
    const auto& collisions = urdf.getLink(model.links[link].name)->collision_array;
    for (const auto& collision : collisions) addCollision(link, *collision, options, reader, model);
    addPiecesToBody(link, findCapsules(collisions), options, model);
  }
  if (model.pieces.empty()) model.warnings.push_back("No link of the robot has collision geometry.");
}

void requireLinks(const std::string& what, const std::map<std::string, double>& by_link, const RobotModel& model) {
  for (const auto& [link, value] : by_link) {
    if (model.findLink(link) >= 0) continue;
    throw std::invalid_argument(what + ": no link " + unknownName(link, namesOf(model.links)));
  }
}

/// Where a joint stands: mimic joints follow their leader.
double jointPosition(const RobotModel& model, int joint, const std::vector<double>& positions) {
  const Joint::Mimic leader = model.leaderOf(joint);
  return leader.offset + leader.multiplier * positions[leader.joint];
}

}  // namespace

int RobotModel::findLink(const std::string& link_name) const { return findNamed(links, link_name); }

bool RobotModel::hasGeometry(int link) const {
  const std::vector<int>& own = links[link].collisions;
  return std::any_of(own.begin(), own.end(), [&](int i) { return !collisions[i].pieces.empty(); });
}

RobotModel::Connection RobotModel::connection(int link_a, int link_b) const {
  Connection way;
  const auto is_decided = [&] { return way.passes_geometry && way.movable_joints > 1; };
  for (int a = link_a, b = link_b; a != b && !is_decided();) {
    int& lower = a > b ? a : b;  // links come parents first, so the later one hangs below the way
    if (bodies[links[lower].body].link == lower) ++way.movable_joints;
    lower = links[lower].parent;
    const bool is_end = lower == link_a || lower == link_b;
    way.passes_geometry = way.passes_geometry || (!is_end && hasGeometry(lower));
  }
  return way;
}

bool RobotModel::areNeighbours(int link_a, int link_b) const {
  const Connection way = connection(link_a, link_b);
  return way.movable_joints == 1 && !way.passes_geometry;
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

double RobotModel::reachOf(int link, const Vector3d& point) const {
  double reach = 0.0;
  for (const int collision : links[link].collisions) {
    for (const int piece : collisions[collision].pieces) reach = std::max(reach, reachFrom(point, pieces[piece]));
  }
  return reach;
}

RobotModel loadRobotModel(const std::string& urdf_xml, const MeshResolver& resolve, const ModelOptions& options) {
  RobotModel model;
  const urdf::ModelInterfaceSharedPtr urdf = readUrdf(urdf_xml, model.warnings);
  model.name = urdf->getName();
  addTree(*urdf, model);
  MimicReader(*urdf, model).readAll();
  requireLinks("padding", options.link_padding, model);
  requireLinks("mesh tolerance", options.link_mesh_tolerance, model);
  addGeometry(*urdf, resolve, options, model);
  return model;
}

bool hasOnePosition(const Joint& joint) {
  return joint.type != Joint::Type::Floating && joint.type != Joint::Type::Planar;
}

Isometry3d jointMotion(const Joint& joint, double position) {
  switch (joint.type) {
    case Joint::Type::Revolute:
    case Joint::Type::Continuous:
      return Isometry3d(Eigen::AngleAxisd(position, joint.axis));
    case Joint::Type::Prismatic:
      return Isometry3d(Eigen::Translation3d(position * joint.axis));
    case Joint::Type::Floating:
    case Joint::Type::Planar:
      break;
  }
  return Isometry3d::Identity();
}

BodyPoses forwardKinematics(const RobotModel& model, const std::vector<double>& positions) {
  if (positions.size() != model.joints.size()) {
    throw std::invalid_argument("the robot has " + std::to_string(model.joints.size()) +
                                " movable joints, but there are " + std::to_string(positions.size()) + " positions");
  }
  BodyPoses poses(model.bodies.size());
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    if (body.joint < 0) {
      poses[i] = Isometry3d::Identity();
      continue;
    }
    const Joint& joint = model.joints[body.joint];
    poses[i] = *poses[body.parent] * model.links[joint.parent_link].body_T_link * joint.parent_T_joint *
               jointMotion(joint, jointPosition(model, body.joint, positions));
  }
  return poses;
}

BodyPoses forwardKinematics(const RobotModel& model, const std::map<std::string, double>& positions) {
  std::vector<double> by_joint(model.joints.size(), 0.0);
  for (const auto& [name, position] : positions) {
    const int joint = findNamed(model.joints, name);
    if (joint < 0) throw std::invalid_argument("no movable joint " + unknownName(name, namesOf(model.joints)));
    by_joint[joint] = position;
  }
  return forwardKinematics(model, by_joint);
}

}  // namespace proximity_server::scene
