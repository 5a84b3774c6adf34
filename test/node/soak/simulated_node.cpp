#include "node/soak/simulated_node.h"

#include "node/load/programs.h"
#include "proximity_server/scene/model/kinematics.h"
#include "scene/posed_scene.h"
#include "scene/solids.h"

#include <ros/param.h>
#include <ros/service.h>
#include <rosgraph_msgs/Clock.h>

#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

namespace proximity_server::node {

using namespace narrowphase;
using namespace scene;
namespace {

using Lock = std::unique_lock<std::mutex>;

const std::string kName = "/simulated";
const std::string kTopic = "clearance in simulated time";
const std::string kScale = "velocity scale";

constexpr double kTfRate = 100.0;      // [Hz] of wall time, that of the clock too
constexpr double kMaxTfAge = 0.2;      // [s]
constexpr double kDeceleration = 5.0;  // [rad/s^2] or [m/s^2] of each joint
constexpr double kStopLatency = 0.1;   // [s] the node's default
constexpr double kSpeed = 2.0;         // [rad/s] or [m/s] of a joint at most
constexpr double kSize = 0.1;          // [m] of the object that is held
constexpr double kLeastScale = 0.1;    // slower than that may mean that it is stopped
constexpr double kScaleTolerance = 1e-3;
// [s] promised, from the stop of the clock to the first INVALID: two periods of the keep-alive, and as much for a busy
// machine.
constexpr double kFrozenAfter = 4.0;
constexpr double kUnderWay = 0.5;  // [s] after that no message of the clock is under way any more
constexpr double kStart = 20.0;    // [s] that the node has to start

std::chrono::duration<double> wall(double seconds) { return std::chrono::duration<double>(seconds); }

geometry_msgs::Point toPoint(const Eigen::Vector3d& p) {
  geometry_msgs::Point point;
  point.x = p.x();
  point.y = p.y();
  point.z = p.z();
  return point;
}

shape_msgs::Mesh toMessage(const TriangleMesh& mesh) {
  shape_msgs::Mesh message;
  for (const Eigen::Vector3d& vertex : mesh.vertices) message.vertices.push_back(toPoint(vertex));
  for (const auto& corners : mesh.triangles) {
    shape_msgs::MeshTriangle& triangle = message.triangles.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) triangle.vertex_indices[i] = static_cast<std::uint32_t>(corners[i]);
  }
  return message;
}

/// An object that one link holds and that overlaps another one, by words to the node and as the library has it.
struct HeldOverlap {
  proximity_server::ObjectChange change;
  ObjectShape shape;
  Eigen::Isometry3d overlapped_T_held;
};

/// A box or a closed bracket in the middle of the first piece of the link that it overlaps.
HeldOverlap randomOverlap(const RobotModel& robot, const Link& holder, const Link& overlapped, bool is_mesh) {
  const Collision& first = robot.collisions[overlapped.collisions.front()];
  const Piece& piece = robot.pieces[first.pieces.front()];
  HeldOverlap overlap{
      {},
      {Shape(Box{{kSize, kSize, kSize}})},
      Eigen::Isometry3d(Eigen::Translation3d(overlapped.body_T_link.inverse() * piece.body_T_piece.translation()))};
  overlap.change.id = "held";
  overlap.change.link = holder.name;
  overlap.change.header.frame_id = overlapped.name;
  if (is_mesh) {
    const TriangleMesh solid = scaled(bracket(), kSize);
    overlap.overlapped_T_held.translate(Eigen::Vector3d::Constant(-0.5 * kSize));  // in its corner
    overlap.shape.geometry = solid;
    overlap.change.meshes = {toMessage(solid)};
  } else {
    overlap.change.primitives.resize(1);
    overlap.change.primitives[0].type = shape_msgs::SolidPrimitive::BOX;
    overlap.change.primitives[0].dimensions = {kSize, kSize, kSize};
  }
  overlap.change.pose.position = toPoint(overlap.overlapped_T_held.translation());
  for (const Link& link : robot.links)
    if (link.name != overlapped.name) overlap.change.touch_links.push_back(link.name);
  return overlap;
}

proximity_server::ObjectChange ballAt(const Eigen::Vector3d& centre) {
  proximity_server::ObjectChange change;
  change.id = "ahead";
  change.pose.position = toPoint(centre);
  change.primitives.resize(1);
  change.primitives[0].type = shape_msgs::SolidPrimitive::SPHERE;
  change.primitives[0].dimensions = {kSize};
  return change;
}

}  // namespace

double SimulatedClock::now() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return time_ + speed_ * std::chrono::duration<double>(Clock::now() - since_).count();
}

void SimulatedClock::set(double time, double speed) {
  const std::lock_guard<std::mutex> lock(mutex_);
  time_ = time;
  speed_ = speed;
  since_ = Clock::now();
}

SimulatedNode::SimulatedNode(const TestRobot& robot, SoakRecord& record, AnswerChecks::Levels levels, double rate,
                             double speed)
    : robot_(robot),
      record_(record),
      levels_(levels),
      speed_(speed),
      checks_(robot.model),
      motion_(robot.model->robot) {
  ros::NodeHandle nh;
  clock_.set(clock_.now(), speed);
  clock_pub_ = nh.advertise<rosgraph_msgs::Clock>("/clock", 10);
  joints_pub_ = nh.advertise<sensor_msgs::JointState>(kName + "/joint_states", 10);
  tf_ = std::make_unique<TfStream>(
      nh, kTfRate, [this](const ros::Time&) { return publish(); }, kName + "/tf");
  ros::param::set("/use_sim_time", true);  // only the node that starts now reads it
  node_ = startNode({{"rate", rate},
                     {"max_tf_age", kMaxTfAge},
                     {"mesh_cache", "user"},
                     {"mesh_tolerance", 0.0},
                     {"max_deceleration", kDeceleration}},
                    kName, {"/tf:=" + kName + "/tf", "joint_states:=" + kName + "/joint_states"});
  const bool starts = awaitService(kName + "/enable_monitor", kStart);
  ros::param::del("/use_sim_time");
  if (!starts) throw std::runtime_error("the node in simulated time does not start");
  clearance_sub_ = nh.subscribe(kName + "/clearance", 1000, &SimulatedNode::onClearance, this);
}

SimulatedNode::~SimulatedNode() {
  clearance_sub_.shutdown();
  tf_.reset();
  stopProgram(*node_);
}

/// The clock and the joint states; what tf gets.
std::vector<geometry_msgs::TransformStamped> SimulatedNode::publish() {
  rosgraph_msgs::Clock clock;
  clock.clock = ros::Time(clock_.now());
  clock_pub_.publish(clock);
  const Lock lock(mutex_);
  if (!posture_) return motion_.transformsAt(clock.clock);
  sensor_msgs::JointState joints = posture_->joints;
  joints.header.stamp = clock.clock;
  joints_pub_.publish(joints);
  std::vector<geometry_msgs::TransformStamped> transforms = posture_->transforms;
  for (geometry_msgs::TransformStamped& transform : transforms) transform.header.stamp = clock.clock;
  return transforms;
}

void SimulatedNode::onClearance(const Clearance& message) {
  const Lock lock(mutex_);
  ++messages_;
  if (message.level == Clearance::INVALID) {
    said_so_ |= stands_still_;
    arrived_.notify_all();
    return record_.count(kTopic, SoakRecord::Outcome::Refused);
  }
  if (posture_) return;  // it rests: its stamps do not tell where it is
  const double age = message.tf_age.toSec();
  Verdict wrong = checks_.check(message, levels_);
  if (age > kMaxTfAge) wrong = "its transforms were " + std::to_string(age) + " s old";
  if (said_so_ && stands_still_) wrong = "not INVALID any more, while the clock stands still";
  if (!wrong.empty())
    return record_.countWrong(kTopic, "at " + std::to_string(message.header.stamp.toSec()) + ": " + wrong);
  record_.count(kTopic, SoakRecord::Outcome::Right);
  last_right_ = message.header.stamp.toSec();
  arrived_.notify_all();
}

bool SimulatedNode::awaitRightAnswer(double patience) {
  Lock lock(mutex_);
  const double moment = clock_.now();
  last_right_ = 0.0;
  return arrived_.wait_for(lock, wall(patience),
                           [&] { return last_right_ >= moment && last_right_ <= clock_.now() + kMaxTfAge; });
}

bool SimulatedNode::staysInvalidWithoutTime(double seconds) {
  const double moment = clock_.now();
  clock_.set(moment, 0.0);
  std::this_thread::sleep_for(wall(kUnderWay));
  Lock lock(mutex_);
  stands_still_ = true;
  said_so_ = false;
  bool goes_on = arrived_.wait_for(lock, wall(kFrozenAfter), [&] { return said_so_; });
  if (!goes_on) record_.countWrong(kTopic, "not INVALID while the clock stands still");
  if (goes_on) {
    const std::uint64_t before = messages_;
    lock.unlock();
    std::this_thread::sleep_for(wall(seconds));
    lock.lock();
    goes_on = arrived_.wait_for(lock, wall(kFrozenAfter), [&] { return messages_ > before; });
    if (!goes_on) record_.countWrong(kTopic, "silent while the clock stands still");
  }
  stands_still_ = false;
  clock_.set(moment, speed_);
  return goes_on;
}

void SimulatedNode::onScale(const std_msgs::Float64& message) {
  const Lock lock(mutex_);
  scale_ = message.data;
  if (posture_ && !(message.data <= posture_->fastest + kScaleTolerance))
    record_.countWrong(kScale,
                       std::to_string(message.data) + ", but " + std::to_string(posture_->fastest) + " is safe");
  arrived_.notify_all();
}

/// The child of a joint without velocity holds an object that overlaps the joint's parent. Returns nullopt where two
/// links limit the velocities, or where the robot would hardly move.
std::optional<SimulatedNode::Posture> SimulatedNode::randomPosture(Chance& chance) const {
  const RobotModel& robot = robot_.model->robot;
  const auto joint = static_cast<std::size_t>(chance.below(static_cast<int>(robot.joints.size())));
  const Link& holder = robot.links[robot.joints[joint].child_link];
  const Link& overlapped = robot.links[robot.joints[joint].parent_link];
  if (!isSettable(robot.joints[joint]) || overlapped.collisions.empty() || holder.collisions.empty()) return {};

  const ros::Time time(chance.between(1.0, 86400.0));
  Posture posture{motion_.jointStateAt(time), motion_.transformsAt(time), {}, 0.0, 0.0};
  const std::vector<double> positions = motion_.positionsAt(time);
  MovingState state;
  const BodyPoses poses = forwardKinematics(robot, positions);
  state.positions.assign(positions.begin(), positions.end());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    state.velocities.push_back(i == joint || !isSettable(robot.joints[i]) ? 0.0 : chance.between(-kSpeed, kSpeed));
    if (isSettable(robot.joints[i])) posture.joints.velocity.push_back(state.velocities.back());
  }
  const HeldOverlap overlap = randomOverlap(robot, holder, overlapped, chance.below(2) == 0);
  const Eigen::Vector3d ahead(chance.between(-1.0, 1.0), chance.between(-1.0, 1.0), chance.between(0.0, 1.5));
  posture.objects.changes.changes = {overlap.change, ballAt(ahead)};

  const auto poseOf = [&](const Link& link) { return *poses[link.body] * link.body_T_link; };
  Attached held{holder.name, {}, poseOf(holder).inverse() * poseOf(overlapped) * overlap.overlapped_T_held};
  for (const Link& link : robot.links) held.touch_links.push_back(link.name);
  ObjectOptions exact;
  exact.meshes.tolerance = 0.0;
  const Fixed ball_place{Eigen::Isometry3d(Eigen::Translation3d(ahead))};
  const bool is_useful = setScales(
      poses, state,
      {makeObject("held", {overlap.shape}, held, exact), makeObject("ahead", {{Shape(Sphere{kSize})}}, ball_place)},
      posture);
  return is_useful ? std::optional(posture) : std::nullopt;
}

/// Sets the scales of a posture, for a robot that may touch what it holds. Returns whether an object limits them, and
/// they are not nearly 0.
bool SimulatedNode::setScales(const BodyPoses& poses, const MovingState& state, const std::vector<Object>& added,
                              Posture& posture) const {
  ObjectRules rules;
  rules.base = ObjectRules::Base::StandsStill;
  std::vector<scene::ObjectChange> changes;
  for (const Object& object : added) changes.push_back(AddObject{object});
  const auto objects = std::make_shared<const Objects>(Objects(robot_.model).withRules(rules).changed(changes));
  PosedScene scene(robot_.model);
  MotionSearch moving(robot_.model);
  scene.use(objects);
  moving.use(objects);
  scene.update(poses);
  const auto scaleWith = [&](double latency) {
    const Braking braking{latency, std::vector<double>(state.velocities.size(), kDeceleration)};
    return velocityScale(moving, scene.scene, scene.state, state, braking, {levels_.stop, levels_.stop});
  };
  const VelocityScale scale = scaleWith(kStopLatency);
  posture.fastest = scale.scale;
  posture.slowest = scaleWith(kStopLatency + kMaxTfAge).scale;
  const bool meets_object = !scale.pair.asked.areLinks();
  return meets_object && posture.slowest > kLeastScale;
}

bool SimulatedNode::isNotSlowedByAnOverlapThatStays(Chance& chance, double patience) {
  std::optional<Posture> posture;
  while (!posture) posture = randomPosture(chance);
  {
    const Lock lock(mutex_);
    posture_ = posture;
  }
  std::this_thread::sleep_for(wall(kUnderWay));  // until tf has no pose of before
  ApplyObjectsResponse response;
  if (!ros::service::call(kName + "/apply_objects", posture->objects, response) || !response.success) {
    record_.countWrong(kScale, "the objects are refused: " + response.status.message);
    return false;
  }
  const ros::Subscriber scales =
      ros::NodeHandle().subscribe(kName + "/collision_velocity_scale", 10, &SimulatedNode::onScale, this);
  Lock lock(mutex_);
  const bool reaches =
      arrived_.wait_for(lock, wall(patience), [&] { return scale_ && *scale_ >= posture->slowest - kScaleTolerance; });
  if (reaches)
    record_.count(kScale, SoakRecord::Outcome::Right);
  else
    record_.countWrong(kScale, std::to_string(scale_.value_or(-1.0)) + " with an object of " +
                                   posture->objects.changes.changes[0].link + " that stays in " +
                                   posture->objects.changes.changes[0].header.frame_id + ", " +
                                   std::to_string(posture->slowest) + " is safe");
  return reaches;
}

}  // namespace proximity_server::node
