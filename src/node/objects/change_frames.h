#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "node/objects/change_fields.h"
#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/scene/objects/object_editor.h"

namespace proximity_server::node {

/// Finds the pose of a tf frame now, in the reference frame of a robot. Throws ChangeError naming the frame if that is not known.
using FindFrame = std::function<Eigen::Isometry3d(const Robot& robot, const std::string& frame)>;

/// Finds frames in tf; waits at most Config::tf_timeout for the robot, and as long for the frame.
FindFrame frameFinder(TfPoses& tf);

/// The frames of tf for changes of objects: each is looked up once, and none that has no pose is waited for twice.
class ChangeFrames : public scene::ObjectFrames {
 public:
  /// The robot must outlive it.
  explicit ChangeFrames(const Robot& robot, FindFrame find = {}) : robot_(robot), find_(std::move(find)) {}

  /// "" is the reference frame, and a link has its frame; a slash in front counts for nothing.
  std::string named(const std::string& name) const override;
  std::string ofLink(const std::string& link) const override;
  Eigen::Isometry3d seenFrom(const std::string& frame, const std::string& other,
                             const Eigen::Isometry3d& pose) override;

 private:
  const Eigen::Isometry3d& referenceTo(const std::string& frame);

  const Robot& robot_;
  const FindFrame find_;
  std::map<std::string, Eigen::Isometry3d> poses_;  ///< in the reference frame
  std::map<std::string, ChangeError> failed_;
};

}  // namespace proximity_server::node
