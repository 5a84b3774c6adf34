#include "stress/scene_cells.h"

#include "oracle/shape_pairs.h"
#include "peers/robots.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "scene/random_objects.h"
#include "stress/random_geometry.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace proximity_server::scene {

using namespace narrowphase;
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// [decades of m] Nothing is known of lengths below 1e-30 m, and no link may be farther than 1e6 m from its parent.
constexpr double kSmallestMagnitude = -20, kLargestMagnitude = 5;

constexpr double kFarthestBeyondLimit = 3.1;  // [rad] half a turn is refused

// --- robots

std::string origin(Chance& chance, double reach) {
  std::ostringstream text;
  text << "<origin xyz='";
  for (int i = 0; i < 3; ++i) text << chance.between(-reach, reach) << " ";
  text << "' rpy='";
  for (int i = 0; i < 3; ++i) text << chance.between(-3, 3) << " ";
  text << "'/>";
  return text.str();
}

std::string someCollision(Chance& chance, double size) {
  std::ostringstream text;
  text << "<collision>" << origin(chance, 0.5 * size) << "<geometry>";
  const double x = size * chance.between(0.2, 1), y = size * chance.between(0.2, 1), z = size * chance.between(0.2, 1);
  switch (chance.below(3)) {
    case 0:
      text << "<sphere radius='" << 0.5 * x << "'/>";
      break;
    case 1:
      text << "<box size='" << x << " " << y << " " << z << "'/>";
      break;
    default:
      text << "<cylinder radius='" << 0.5 * x << "' length='" << z << "'/>";
  }
  text << "</geometry></collision>";
  return text.str();
}

/// A tree of two to five links, few without geometry, joined by any kind of joint, with limits of up to `limit`.
std::string someUrdf(Chance& chance, double size, double limit) {
  const int links = 2 + chance.below(4);
  const char* const types[] = {"revolute", "revolute", "revolute", "prismatic", "fixed", "floating"};
  std::ostringstream urdf;
  urdf << "<robot name='small'>";
  for (int link = 0; link < links; ++link) {
    urdf << "<link name='l" << link << "'>";
    const int count = chance.below(8);
    for (int i = count == 0 ? 0 : count < 6 ? 1 : 3; i > 0; --i) urdf << someCollision(chance, 0.3 * size);
    urdf << "</link>";
    if (link == 0) continue;
    urdf << "<joint name='j" << link << "' type='" << types[chance.below(6)] << "'><parent link='l"
         << chance.below(link) << "'/><child link='l" << link << "'/>" << origin(chance, 0.5 * size)
         << "<axis xyz='0 0.6 0.8'/><limit lower='" << -limit << "' upper='" << limit
         << "' effort='1' velocity='1'/></joint>";
  }
  urdf << "</robot>";
  return urdf.str();
}

std::shared_ptr<const SceneModel> someRobot(Chance& chance, double size, double limit) {
  auto model = std::make_shared<SceneModel>();
  model->robot = loadRobotModel(someUrdf(chance, size, limit), packageResolver({}));
  PairFilterOptions options;
  if (chance.below(4) == 0) options.pair_padding.push_back({{"l0", "l1"}, chance.between(-0.02, 0.02) * size});
  model->pairs = filterPairs(model->robot, "", options);
  return model;
}

/// Panda, UR5 and PR2, where they are found.
const std::vector<peers::NamedRobot>& examples() {
  static const std::vector<peers::NamedRobot> robots = peers::exampleRobots();
  return robots;
}

TriangleMesh meshOf(const ConvexHull& hull) {
  TriangleMesh mesh;
  mesh.vertices.assign(hull.vertices().begin(), hull.vertices().end());
  for (const auto& triangle : hull.triangles()) mesh.triangles.push_back({triangle[0], triangle[1], triangle[2]});
  return mesh;
}

}  // namespace

const std::vector<SceneFamily>& sceneFamilies() {
  static const std::vector<SceneFamily> families = [] {
    using Family = SceneFamily;
    std::vector<Family> all;
    const auto add = [&](const char* name, const auto& set) {
      Family family{name};
      set(family);
      all.push_back(family);
    };
    add("few objects", [](Family& f) { f.objects = 3; });
    add("held", [](Family& f) { f.attached = 0.7; });
    add("carried by frames", [](Family& f) { f.moving = 0.7; });
    add("half-spaces", [](Family& f) { f.planes = 0.5; });
    add("hardly moving", [](Family& f) { f.jumps = 0.03; });
    add("aligned", [](Family& f) { f.poses = Family::Poses::Aligned; });
    add("every size", [](Family& f) { f.smallest = -3, f.largest = 2; });
    add("far from the origin", [](Family& f) { f.farthest = 6; });
    add("beyond limits", [](Family& f) { f.beyond_limits = 0.5, f.objects = 3; });
    add("every magnitude", [](Family& f) { f.has_any_size = true, f.farthest_slide = 300, f.objects = 3; });
    add("boxes in bulk", [](Family& f) { f.bulk = 0.6, f.objects = 3, f.rarity = 4; });
    add("many objects", [](Family& f) { f.objects = 60, f.attached = f.moving = 0.05, f.jumps = 0.2, f.rarity = 8; });
    add("closed meshes", [](Family& f) { f.solids = 0.5, f.jumps = 0.2, f.rarity = 2; });
    if (!examples().empty())
      add("example robots", [](Family& f) { f.robot = Family::Robot::Example, f.objects = 8, f.rarity = 16; });
    return all;
  }();
  return families;
}

SceneCell::SceneCell(std::size_t family, unsigned seed, std::int64_t number)
    : family_(sceneFamilies().at(family)), chance_(seed, family, number) {
  if (family_.has_any_size) magnitude_ = chance_.decades(kSmallestMagnitude, kLargestMagnitude);
  size_ = magnitude_ * std::pow(10.0, family_.largest);
  const bool is_small = family_.robot == SceneFamily::Robot::Small;
  const double limit = family_.beyond_limits > 0.0 ? chance_.between(0.1, 4.0) : size_;
  model_ = is_small ? someRobot(chance_, size_, limit) : chance_.oneOf(examples()).model;
  if (family_.farthest >= 0)
    world_T_cell_ = Eigen::Translation3d(chance_.decades(0, family_.farthest) * 0.5 * randomDirection(chance_)) *
                    Isometry3d(randomPose(chance_, 0.0));
  objects_ = std::make_shared<const Objects>(model_);
  positions_.resize(model_->robot.joints.size());
  floating_.resize(model_->robot.bodies.size());
  jump();
  for (int i = 0; i < family_.objects; ++i) change();
  place();
}

void SceneCell::next() {
  // Sometimes many things change at once, so that the tree of fixed objects is built anew.
  if (chance_.happens(0.4)) change();
  if (chance_.happens(0.05))
    for (int i = 0; i < family_.objects; ++i) change();
  if (chance_.happens(family_.jumps))
    jump();
  else if (chance_.happens(0.8))
    step();
  place();
}

// --- what moves

void SceneCell::jump() {
  const RobotModel& robot = model_->robot;
  for (std::size_t joint = 0; joint < positions_.size(); ++joint) {
    const double low = std::max(-3.0, robot.joints[joint].lower), high = std::min(3.0, robot.joints[joint].upper);
    positions_[joint] = chance_.between(low, std::max(low, high));
    if (chance_.happens(family_.beyond_limits))
      positions_[joint] = chance_.happens(0.5) ? robot.joints[joint].upper + chance_.between(0.0, kFarthestBeyondLimit)
                                               : robot.joints[joint].lower - chance_.between(0.0, kFarthestBeyondLimit);
  }
  for (Isometry3d& pose : floating_) pose = somePose(size_);
  for (Isometry3d& frame : known_frames_) frame = somePose(1.5 * size_);
  missing_frame_ = chance_.below(8) - 5;
  missing_body_ = chance_.happens(0.05) ? chance_.below(static_cast<int>(robot.bodies.size())) : -1;
}

void SceneCell::step() {
  for (std::size_t joint = 0; joint < positions_.size(); ++joint)
    positions_[joint] += chance_.eitherSign(chance_.decades(-17, -1)) * unitOf(model_->robot.joints[joint]);
  const double turn = chance_.decades(-17, -1), way = size_ * chance_.decades(-17, -1);
  const auto moveALittle = [&](Isometry3d& pose) {
    pose =
        pose * Eigen::Translation3d(way * randomDirection(chance_)) * Eigen::AngleAxisd(turn, randomDirection(chance_));
  };
  std::for_each(floating_.begin(), floating_.end(), moveALittle);
  std::for_each(known_frames_.begin(), known_frames_.end(), moveALittle);
}

/// Bodies that a floating one carries move with it.
BodyPoses SceneCell::posesOf(const std::vector<double>& positions) const {
  const RobotModel& robot = model_->robot;
  const BodyPoses unfloated = forwardKinematics(robot, positions);
  BodyPoses poses = unfloated;
  for (std::size_t body = 0; body < poses.size(); ++body) {
    if (robot.bodies[body].parent < 0) continue;
    const auto parent = static_cast<std::size_t>(robot.bodies[body].parent);
    const bool floats = !hasOnePosition(robot.joints[robot.bodies[body].joint]);
    if (floats)
      poses[body] = *poses[parent] * floating_[body];
    else if (poses[parent]->matrix() != unfloated[parent]->matrix())
      poses[body] = *poses[parent] * (unfloated[parent]->inverse() * *unfloated[body]);
  }
  for (std::optional<Isometry3d>& pose : poses) pose = world_T_cell_ * *pose;
  return poses;
}

void SceneCell::place() {
  poses_ = posesOf(positions_);
  if (missing_body_ >= 0) poses_[missing_body_].reset();
  frame_poses_.clear();
  for (const std::string& name : objects_->frames()) {
    const int frame = name.back() - '0';
    frame_poses_.push_back(frame == missing_frame_ ? std::nullopt
                                                   : std::optional<Isometry3d>(world_T_cell_ * known_frames_[frame]));
  }
}

// --- how it moves

const Motion& SceneCell::startMotion() {
  const std::vector<Joint>& joints = model_->robot.joints;
  const bool all_move = chance_.happens(0.5);
  travel_.assign(joints.size(), 0.0);
  for (std::size_t joint = 0; joint < joints.size(); ++joint) {
    const double beyond = std::max(joints[joint].lower - positions_[joint], positions_[joint] - joints[joint].upper);
    if (beyond > kFarthestBeyondLimit * unitOf(joints[joint]) || (!all_move && chance_.happens(0.5))) continue;
    const bool slides = joints[joint].type == Joint::Type::Prismatic;
    const double most = slides ? family_.farthest_slide : 1;
    travel_[joint] = chance_.eitherSign(chance_.decades(-3, most)) * unitOf(joints[joint]);
    if (!std::isfinite(travel_[joint])) travel_[joint] = 0.0;
  }
  const std::vector<std::optional<double>> stated(positions_.begin(), positions_.end());
  motion_ = motionWithinLimits(model_->robot, poses_, travel_, stated).motion;
  RobotMotion::ObjectFrames frames;
  for (const std::optional<Isometry3d>& frame : frame_poses_) {
    const Vector3d way = size_ * chance_.decades(-3, 0.5) * randomDirection(chance_);
    frames.moving.push_back(RobotMotion::withTwist(frame, {way, chance_.decades(-3, 1) * randomDirection(chance_)}));
  }
  motion_->carryObjects(frames);
  return *motion_;
}

void SceneCell::placeAt(double time) {
  std::vector<double> positions = positions_;
  for (std::size_t joint = 0; joint < positions.size(); ++joint) {
    const Joint& moved = model_->robot.joints[joint];
    const double start = positions[joint], end = start + time * travel_[joint];
    positions[joint] = travel_[joint] > 0.0 ? std::max(start, std::min(end, moved.upper))
                                            : std::min(start, std::max(end, moved.lower));
  }
  const RobotMotion::State state = motion_->inWorld(time);
  poses_ = posesOf(positions);
  for (std::size_t body = 0; body < poses_.size(); ++body)
    if (!state.bodies[body]) poses_[body].reset();
  frame_poses_ = state.frames;
}

// --- what there is

double SceneCell::shapeSize() { return magnitude_ * chance_.decades(family_.smallest - 0.5, family_.largest - 0.6); }

Isometry3d SceneCell::somePose(double reach) {
  if (family_.poses == SceneFamily::Poses::Anywhere || chance_.happens(0.3)) return randomPose(chance_, reach);
  Isometry3d pose = Isometry3d::Identity();
  if (chance_.happens(0.5)) pose.linear() = quarterTurns(chance_);
  for (int i = 0; i < 3; ++i) pose.translation()[i] = 0.25 * reach * (chance_.below(9) - 4);
  return pose;
}

Shape SceneCell::someShape() {
  Vector3d size = randomSizes(chance_, shapeSize());
  if (family_.poses == SceneFamily::Poses::Aligned)
    size = 0.25 * size_ * Vector3d(1 + chance_.below(2), 1 + chance_.below(2), 1 + chance_.below(2));
  switch (chance_.below(4)) {
    case 0:
      return boxOrItsHull(chance_, size);
    case 1:
      return solid(chance_, size.maxCoeff());
    case 2:
      return randomHull(chance_, 4 + chance_.below(20), 0.5 * size);
    default:
      return primitive(chance_, size);
  }
}

ObjectShape SceneCell::someObjectShape(std::vector<Part>& parts, bool with_planes, double padding) {
  ObjectShape shape{Shape(Sphere{1.0}), chance_.happens(0.3) ? Isometry3d::Identity() : somePose(0.3 * size_)};
  const LongPose object_T_shape = longPose(shape.object_T_shape);
  const int number = parts.empty() ? 1 : parts.back().number + 1;
  if (with_planes && chance_.happens(family_.planes)) {
    const HalfSpace plane{randomDirection(chance_) * chance_.between(0.5, 2.0), -chance_.between(0.2, 2.0) * size_};
    shape.geometry = plane;
    parts.push_back({std::nullopt, plane, object_T_shape, padding, number});
  } else if (chance_.happens(family_.bulk)) {
    Boxes boxes;
    for (int i = 2 + chance_.below(60); i > 0; --i) {
      const Vector3d corner = 0.5 * size_ * randomDirection(chance_), size = 0.1 * size_ * randomSizes(chance_, 1.0);
      boxes.boxes.emplace_back(corner, corner + size);
      const Eigen::AlignedBox3d& box = boxes.boxes.back();
      const LongPose centre{Matrix3l::Identity(), box.center().cast<long double>()};
      parts.push_back({Shape(Box{box.sizes()}), {}, object_T_shape * centre, padding, number});
    }
    shape.geometry = boxes;
  } else {
    const Shape some = someShape();
    const bool as_mesh = some.kind() == Shape::Kind::Hull && some.margin() == 0.0 && some.hull().dimension() == 3 &&
                         chance_.happens(0.5);
    shape.geometry = some;
    if (as_mesh) shape.geometry = meshOf(some.hull());
    parts.push_back({some, {}, object_T_shape, padding, number});
  }
  return shape;
}

/// Its pieces are those of the library: the triangles, and an Interior, which has its own tests.
Object SceneCell::someClosedMesh(const std::string& id, const Placement& placement) {
  Object solid = someSolid(id, placement, chance_);
  std::vector<Part>& parts = described_[id];
  parts.clear();
  for (const Piece& piece : piecesOf(solid))
    parts.push_back({piece.shape,
                     {},
                     longPose(piece.body_T_piece),
                     /*padding=*/0.0,
                     piece.collision + 1,
                     piece.interior,
                     piece.is_representative});
  return solid;
}

Object SceneCell::someObject(const std::string& id, const Placement& placement) {
  if (family_.solids > 0.0 && chance_.happens(family_.solids)) return someClosedMesh(id, placement);
  std::vector<Part> parts;
  std::vector<ObjectShape> shapes;
  ObjectOptions options;
  options.padding = chance_.happens(0.3) ? chance_.decades(-4, -1) * size_ : 0.0;
  const bool with_planes = !std::holds_alternative<Attached>(placement);
  for (int i = std::max(1, chance_.below(5) - 1); i > 0; --i)
    shapes.push_back(someObjectShape(parts, with_planes, options.padding));
  described_[id] = parts;
  return makeObject(id, shapes, placement, options);
}

Placement SceneCell::freePlacement() {
  if (chance_.happens(family_.moving / std::max(1e-3, 1.0 - family_.attached)))
    return Moving{"frame " + std::to_string(chance_.below(3)),
                  chance_.happens(0.3) ? Isometry3d::Identity() : somePose(0.2 * size_)};
  return Fixed{world_T_cell_ * somePose(1.5 * size_)};
}

Attached SceneCell::attachment() {
  const auto some = [&] { return chance_.oneOf(model_->robot.links).name; };
  Attached attached{some()};
  if (chance_.happens(0.7)) attached.link_T_object = somePose(0.2 * size_);
  for (int i = chance_.below(3); i > 0; --i) attached.touch_links.push_back(some());
  return attached;
}

Placement SceneCell::anyPlacement() {
  if (chance_.happens(family_.attached)) return attachment();
  return freePlacement();
}

ObjectRules SceneCell::someRules() {
  ObjectRules rules;
  if (chance_.happens(0.5)) rules.free_objects = ObjectRules::FreeObjects::Checked;
  if (chance_.happens(0.3)) rules.base = ObjectRules::Base::StandsStill;
  for (int i = chance_.below(3); i > 0 && !objects_->empty(); --i) {
    const std::string other = chance_.happens(0.3)   ? "*"
                              : chance_.happens(0.5) ? someId()
                                                     : model_->robot.links.back().name;
    rules.allowed.set(someId(), other,
                      chance_.happens(0.8) ? AllowedPairs::Rule::Allowed : AllowedPairs::Rule::Checked);
  }
  return rules;
}

ObjectChange SceneCell::someChange() {
  const bool too_few = chance_.below(2 * family_.objects) >= objects_->size();
  if (objects_->empty() || too_few) {
    const std::string id = "object " + std::to_string(added_++);
    return AddObject{someObject(id, anyPlacement())};
  }
  const std::string id = someId();
  const Object& object = *objects_->object(objects_->find(id));
  const std::vector<Part>& parts = described_.at(id);
  const bool can_be_attached =
      std::all_of(parts.begin(), parts.end(), [](const Part& part) { return part.shape.has_value(); });
  switch (chance_.below(4)) {
    case 0:
      described_.erase(id);
      return RemoveObject{id};
    case 1:
      return ReplaceObject{someObject(id, anyPlacement())};
    case 2:
      if (can_be_attached && chance_.happens(2.0 * family_.attached))
        return ReplaceObject{{id, object.geometry, attachment()}};
      [[fallthrough]];
    default:
      return ReplaceObject{{id, object.geometry, freePlacement()}};
  }
}

void SceneCell::change() {
  if (chance_.happens(0.1)) objects_ = std::make_shared<const Objects>(objects_->withRules(someRules()));
  objects_ = std::make_shared<const Objects>(objects_->changed({someChange()}));
}

// --- what is true

std::vector<ShapeRefPair> SceneCell::checkedPairs() const {
  std::vector<ShapeRefPair> pairs;
  for (const LinkPair& pair : model_->pairs.pairs)
    if (pair.reason == PairReason::Checked) pairs.push_back({{pair.link_a}, {pair.link_b}});
  for (int number = 0; number < objects_->numberLimit(); ++number) {
    if (!objects_->object(number)) continue;
    for (int link = 0; link < static_cast<int>(model_->robot.links.size()); ++link)
      if (objects_->isChecked(link, ShapeRef::ofObject(number))) pairs.push_back({link, ShapeRef::ofObject(number)});
    for (int other = 0; other < number; ++other)
      if (objects_->object(other) && objects_->isChecked(ShapeRef::ofObject(other), ShapeRef::ofObject(number)))
        pairs.push_back({ShapeRef::ofObject(other), ShapeRef::ofObject(number)});
  }
  return pairs;
}

/// The difference of two doubles is exact in long double, unless one is tiny beside the other.
LongPose SceneCell::inCell(const Isometry3d& world_T_x) const {
  LongPose pose = longPose(world_T_x);
  pose.translation -= origin().cast<long double>();
  return pose;
}

std::optional<LongPose> SceneCell::worldOf(const Placement& placement) const {
  if (const auto* fixed = std::get_if<Fixed>(&placement)) return inCell(fixed->world_T_object);
  if (const auto* moving = std::get_if<Moving>(&placement)) {
    const std::vector<std::string>& names = objects_->frames();
    const auto frame = static_cast<std::size_t>(std::find(names.begin(), names.end(), moving->frame) - names.begin());
    if (!frame_poses_[frame]) return std::nullopt;
    return inCell(*frame_poses_[frame]) * longPose(moving->frame_T_object);
  }
  const auto& attached = std::get<Attached>(placement);
  const Link& link = model_->robot.links[model_->robot.findLink(attached.link)];
  const auto& pose = poses_[link.body];
  if (!pose) return std::nullopt;
  return inCell(*pose) * longPose(link.body_T_link) * longPose(attached.link_T_object);
}

std::optional<WorldSolid> SceneCell::solidOf(const ShapeRef& ref) const {
  WorldSolid solid;
  if (ref.isLink()) {
    const RobotModel& robot = model_->robot;
    const auto& pose = poses_[robot.links[ref.link()].body];
    if (!pose) return std::nullopt;
    for (const Piece* piece : peers::piecesOfLink(robot, ref.link()))
      solid.parts.push_back({piece->shape, inCell(*pose) * longPose(piece->body_T_piece),
                             robot.collisions[piece->collision].number, piece->interior, piece->is_representative});
    return solid.parts.empty() ? std::nullopt : std::optional(solid);
  }
  const Object& object = *objects_->object(ref.object());
  const std::optional<LongPose> world_T_object = worldOf(object.placement);
  if (!world_T_object) return std::nullopt;
  for (const Part& part : described_.at(object.id)) {
    const LongPose world_T_part = *world_T_object * part.object_T_part;
    if (part.shape) {
      solid.parts.push_back(
          {part.shape->padded(part.padding), world_T_part, part.number, part.interior, part.is_representative});
      continue;
    }
    const Vector3l normal = world_T_part.rotation * part.half_space.normal.cast<long double>().normalized();
    solid.planes.push_back(
        {normal, part.half_space.offset + part.padding + normal.dot(world_T_part.translation), part.number});
  }
  return solid;
}

double SceneCell::paddingOf(const ShapeRefPair& pair) const {
  if (!pair.areLinks()) return 0.0;
  const int index = model_->pairs.find(pair.a.link(), pair.b.link());
  return index < 0 ? 0.0 : model_->pairs.pairs[index].padding;
}

std::optional<PairDistances> SceneCell::someThresholds() const {
  Chance chance = chance_;
  if (chance.below(3) != 0) return std::nullopt;
  const auto some = [&] { return chance.decades(-3, 0) * size(); };
  PairDistances thresholds(some(), some());
  const int links = static_cast<int>(model_->robot.links.size());
  for (int a = 0; a < links; ++a) {
    if (chance.below(2) == 0) thresholds.setWithObjects(a, some());
    for (int b = a + 1; b < links; ++b)
      if (chance.below(2) == 0) thresholds.setPair(a, b, some());
  }
  return thresholds;
}

}  // namespace proximity_server::scene
