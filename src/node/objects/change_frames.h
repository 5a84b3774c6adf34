#pragma once

#include "node/objects/change_fields.h"
#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/scene/objects/object_editor.h"

#include <Eigen/Geometry>

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace proximity_server::node {

/// Finds the present pose of a tf frame in the reference frame of a robot. Throws ChangeError naming the frame if the
/// pose is not known.
using FindFrame = std::function<Eigen::Isometry3d(const Robot& robot, const std::string& frame)>;

/// Makes a function that finds frames in tf, at `stamp`; if that is 0, their latest poses. It waits at most `timeout`
/// [s] of wall time for the robot, and then at most as long for the frame; nullopt: Config::tf_timeout.
FindFrame frameFinder(TfPoses& tf, const ros::Time& stamp = {}, std::optional<double> timeout = {});

/// The frames of tf for changes of objects. Each frame is looked up once, also one that has no pose, so that nothing
/// waits for it twice.
class ChangeFrames : public scene::ObjectFrames {
 public:
  /// The robot must outlive it.
  explicit ChangeFrames(const Robot& robot, FindFrame find = {}) : robot_(robot), find_(std::move(find)) {}

  /// The tf frame that `name` stands for: "" is the reference frame, and the name of a link stands for the frame of the
  /// link. A slash in front of the name is ignored.
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
