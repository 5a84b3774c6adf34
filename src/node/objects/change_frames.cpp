#include "node/objects/change_frames.h"

#include "proximity_server/QueryStatus.h"

namespace proximity_server::node {

using Eigen::Isometry3d;

FindFrame frameFinder(TfPoses& tf, const ros::Time& stamp, std::optional<double> timeout) {
  return [&tf, stamp, timeout](const Robot& robot, const std::string& frame) -> Isometry3d {
    const CarrierFrames frames{{frame}, {0}};
    const PoseSnapshot robot_poses = tf.await(robot, bodiesOf(robot, frames), stamp, timeout);
    const FrameSnapshot found = tf.awaitFrames(robot, frames, robot_poses, stamp, timeout);
    if (found.poses.front()) return *found.poses.front();
    const QueryStatus& why = robot_poses.status.code == QueryStatus::OK ? found.status : robot_poses.status;
    const bool says_why = why.code != QueryStatus::OK;
    throw ChangeError(says_why ? why.code : static_cast<std::int8_t>(QueryStatus::TF_UNAVAILABLE),
                      "frame '" + frame + "' has no pose: " + why.message);
  };
}

std::string ChangeFrames::named(const std::string& name) const {
  const std::string plain = !name.empty() && name.front() == '/' ? name.substr(1) : name;
  if (plain.empty()) return robot_.referenceFrame();
  const int link = robot_.linkOfFrame(plain);
  return link < 0 ? plain : robot_.frameOf(link);
}

std::string ChangeFrames::ofLink(const std::string& link) const {
  return robot_.frameOf(robot_.robotModel().findLink(link));
}

Isometry3d ChangeFrames::seenFrom(const std::string& frame, const std::string& other, const Isometry3d& pose) {
  return scene::requireReach(frame == other ? pose : referenceTo(frame).inverse() * referenceTo(other) * pose);
}

const Isometry3d& ChangeFrames::referenceTo(const std::string& frame) {
  if (const auto failed = failed_.find(frame); failed != failed_.end()) throw failed->second;
  if (const auto known = poses_.find(frame); known != poses_.end()) return known->second;
  try {
    const Isometry3d pose = frame == robot_.referenceFrame() ? Isometry3d::Identity() : find_(robot_, frame);
    return poses_.emplace(frame, pose).first->second;
  } catch (const ChangeError& error) {
    failed_.emplace(frame, error);
    throw;
  }
}

}  // namespace proximity_server::node
