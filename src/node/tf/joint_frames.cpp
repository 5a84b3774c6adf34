#include "node/tf/joint_frames.h"

#include "proximity_server/scene/model/kinematics.h"

#include <utility>

namespace proximity_server::node {
namespace {

void addChain(const scene::RobotModel& robot, int body, std::vector<bool>& is_listed, std::vector<int>& joints) {
  for (; robot.bodies[body].joint >= 0; body = robot.bodies[body].parent) {
    const int joint = robot.bodies[body].joint;
    if (is_listed[joint]) return;
    is_listed[joint] = true;
    joints.push_back(joint);
  }
}

}  // namespace

std::vector<int> edgesTo(const Robot& asked, const std::vector<int>& bodies) {
  const scene::RobotModel& robot = asked.robotModel();
  std::vector<bool> is_listed(robot.joints.size(), false);
  std::vector<bool> has_bodies(robot.robots.size(), robot.robots.size() == 1);
  std::vector<int> edges;
  for (const int body : bodies) {
    addChain(robot, body, is_listed, edges);
    has_bodies[robot.bodies[body].robot] = true;
  }
  if (asked.referenceLink() >= 0) addChain(robot, robot.links[asked.referenceLink()].body, is_listed, edges);
  for (int i = 0; i < static_cast<int>(has_bodies.size()); ++i)
    if (has_bodies[i] && asked.rootEdge(i) >= 0) edges.push_back(asked.rootEdge(i));
  return edges;
}

double positionAt(const scene::RobotModel& robot, int joint, const Eigen::Isometry3d& parent_T_child) {
  const scene::Joint& model = robot.joints[joint];
  return scene::jointPosition(robot, model, robot.links[model.parent_link].body_T_link * parent_T_child);
}

bool hasPosition(const scene::RobotModel& robot, int joint, const JointValues& positions) {
  return positions[robot.leaderOf(joint).joint].has_value();
}

JointFrames framesAt(const scene::RobotModel& robot, const JointValues& positions, const JointFrames& others) {
  JointFrames frames = others;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const scene::Joint::Mimic leader = robot.leaderOf(static_cast<int>(i));
    const std::optional<double>& position = positions[leader.joint];
    if (!position) continue;
    const scene::Joint& joint = robot.joints[i];
    frames[i] = joint.parent_T_joint * jointMotion(joint, leader.offset + leader.multiplier * *position);
  }
  return frames;
}

scene::BodyPoses posesInRoot(const scene::RobotModel& robot, const JointFrames& joints, scene::BodyPoses reused) {
  scene::BodyPoses poses = std::move(reused);
  poses.assign(robot.bodies.size(), std::nullopt);
  for (std::size_t i = 0; i < poses.size(); ++i) {  // a parent has a smaller index than its children
    const scene::Body& body = robot.bodies[i];
    if (body.joint < 0) {
      poses[i] = Eigen::Isometry3d::Identity();
      continue;
    }
    const auto& parent = poses[body.parent];
    const auto& frame = joints[body.joint];
    if (!parent || !frame) continue;
    poses[i] = *parent * robot.links[robot.joints[body.joint].parent_link].body_T_link * *frame;
  }
  return poses;
}

std::optional<Eigen::Isometry3d> referenceToRoot(const Robot& robot, const scene::BodyPoses& poses_in_root,
                                                 const std::optional<Eigen::Isometry3d>& pose_from_tf) {
  if (robot.referenceLink() < 0) return pose_from_tf;
  const scene::Link& reference = robot.robotModel().links[robot.referenceLink()];
  const auto& root_T_body = poses_in_root[reference.body];
  if (!root_T_body) return std::nullopt;
  return (*root_T_body * reference.body_T_link).inverse();
}

// This does not use scene::placedAt(), because it must not allocate memory.
scene::BodyPoses inReference(const Robot& robot, scene::BodyPoses poses_in_root, const RootPoses& roots) {
  const int own = robot.referenceRobot();
  const std::optional<Eigen::Isometry3d> reference_T_parent =
      referenceToRoot(robot, poses_in_root, Eigen::Isometry3d::Identity());  // the parent is the frame of `roots`
  for (std::size_t i = 0; i < poses_in_root.size(); ++i) {
    const int member = robot.robotModel().bodies[i].robot;
    std::optional<Eigen::Isometry3d>& pose = poses_in_root[i];
    if (pose && reference_T_parent && (member == own || roots[member])) {
      pose = *reference_T_parent * (member == own ? *pose : *roots[member] * *pose);
    } else {
      pose.reset();
    }
  }
  return poses_in_root;
}

}  // namespace proximity_server::node
