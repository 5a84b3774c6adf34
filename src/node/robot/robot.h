#pragma once

#include <ros/node_handle.h>

#include <memory>
#include <string>
#include <vector>

#include "node/robot/config.h"
#include "node/robot/object_slot.h"
#include "node/robot/scene_pool.h"
#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/query/pairs.h"

namespace proximity_server::node {

/// A transform that a robot needs from tf: the pose of one frame in another.
struct TfEdge {
  std::string parent, child;  ///< frames
  std::string name;           ///< in messages: "joint 'elbow'"
};

/// A robot as the parameter server described it. Besides its objects it does not change after loading: a reload makes a
/// new Robot, and running requests keep the old one.
class Robot {
 public:
  /// Reads URDF and SRDF from the parameters that `config` names, searched upwards from the namespace of `nh`.
  ///
  /// Failure: throws std::invalid_argument naming the parameter, file, link or element that is missing or broken.
  Robot(const ros::NodeHandle& nh, const Config& config);

  /// Reads the texts of a URDF and an SRDF. An empty `srdf` means that there is none.
  Robot(const std::string& urdf, const std::string& srdf, const Config& config);

  const Config& config() const { return config_; }
  const scene::SceneModel& sceneModel() const { return *model_; }
  const std::shared_ptr<const scene::SceneModel>& sharedModel() const { return model_; }
  const scene::RobotModel& robotModel() const { return model_->robot; }

  /// The frame of a link in tf, with the prefix of Config::tf_prefix.
  std::string frameOf(int link) const;

  /// The link whose frame in tf this is, with or without the prefix; -1 if there is none.
  int linkOfFrame(const std::string& frame) const;

  /// The frame of all answers, and the link whose frame it is; -1 if it is not the frame of a link.
  const std::string& referenceFrame() const { return reference_frame_; }
  int referenceLink() const { return reference_link_; }

  /// One edge for each of RobotModel::joints. If the reference frame is no link, the last edge leads from it to the
  /// root.
  const std::shared_ptr<const std::vector<TfEdge>>& tfEdges() const { return tf_edges_; }

  /// The pairs that are checked, and the bodies of their links, each once.
  const scene::Candidates& candidates() const { return candidates_; }
  const std::vector<int>& candidateBodies() const { return candidate_bodies_; }

  /// The objects around the robot. Unlike all else of a robot they change while it is used.
  ObjectSlot& objects() const { return *objects_; }

  /// Candidate pairs in which a link of this SRDF group moves. Throws std::invalid_argument for an unknown group.
  std::vector<scene::ShapeRefPair> pairsOfGroup(const std::string& group) const;

  /// A scene for one request; it may still have the poses of an earlier one. The lease must end before the robot.
  ScenePool::Lease borrowScene() const { return scenes_->borrow(); }
  MovingScenePool::Lease borrowMovingScene() const { return moving_scenes_->borrow(); }

 private:
  Config config_;
  std::string srdf_;
  std::shared_ptr<const scene::SceneModel> model_;
  scene::Candidates candidates_;
  std::vector<int> candidate_bodies_;
  int reference_link_;
  std::string reference_frame_;
  std::shared_ptr<const std::vector<TfEdge>> tf_edges_;
  std::unique_ptr<ObjectSlot> objects_;
  std::unique_ptr<ScenePool> scenes_;
  std::unique_ptr<MovingScenePool> moving_scenes_;
};

/// Finds the mesh files of links and objects: those of packages below the roots of the parameters and of
/// ROS_PACKAGE_PATH, and only below the allowed roots.
scene::MeshResolver meshResolver(const Config& config);

/// The bodies of all links in `pairs`, each once, in ascending order. Objects are left out.
std::vector<int> bodiesOf(const scene::RobotModel& robot, const std::vector<scene::ShapeRefPair>& pairs);

}  // namespace proximity_server::node
