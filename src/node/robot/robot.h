#pragma once

#include "node/robot/config.h"
#include "node/robot/object_slot.h"
#include "node/robot/scene_pool.h"
#include "proximity_server/scene/query/pairs.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/uncertainty/uncertainty.h"

#include <ros/node_handle.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::node {

/// A transform that a robot needs from tf: the pose of one frame in another.
struct TfEdge {
  std::string parent, child;  ///< frames
  std::string name;           ///< in messages: "joint 'elbow'"
};

/// The texts that describe one robot.
struct RobotTexts {
  std::string urdf;
  std::string srdf;  ///< "" if there is none
};

/// A robot as the parameter server described it, or several robots in one model (scene::loadRobots). Only its objects
/// and its default thresholds change after loading: a reload makes a new Robot, and running requests keep the old one.
class Robot {
 public:
  /// Reads URDF and SRDF from the parameters that `config` names, searched upwards from the namespace of `nh`.
  ///
  /// Failure: throws std::invalid_argument naming the parameter, file, link or element that is missing or broken.
  Robot(const ros::NodeHandle& nh, const Config& config);

  /// Makes the robots from their texts, one for each of robotSources(config).
  Robot(const std::vector<RobotTexts>& texts, const Config& config);

  /// Makes a single robot from its texts.
  Robot(const std::string& urdf, const std::string& srdf, const Config& config);

  const Config& config() const { return config_; }
  const scene::SceneModel& sceneModel() const { return *model_; }
  const std::shared_ptr<const scene::SceneModel>& sharedModel() const { return model_; }
  const scene::RobotModel& robotModel() const { return model_->robot; }

  /// The sources of the robots of the model, in the order of RobotModel::robots. If they were read from the parameter
  /// server, RobotSource::joint_states is the full name of the topic.
  const std::vector<RobotSource>& sources() const { return sources_; }

  /// The texts of these robots.
  const std::vector<RobotTexts>& texts() const { return texts_; }

  /// The frame of a link in tf, with the prefix of its robot.
  const std::string& frameOf(int link) const { return frames_[link]; }

  /// The link that has this frame in tf, which may be given with or without the prefix; -1 if there is none.
  int linkOfFrame(const std::string& frame) const;

  /// The frame of all answers, and the link that has this frame; -1 if no link has it.
  const std::string& referenceFrame() const { return reference_frame_; }
  int referenceLink() const { return reference_link_; }

  /// The robot with the reference link, as an index into RobotModel::robots; -1 if the reference frame is not the frame
  /// of a link.
  int referenceRobot() const;

  /// The transforms that the robot needs from tf. There is one edge for each of RobotModel::joints. Behind them there
  /// is one edge to the root of each robot but referenceRobot(). It begins at the root of referenceRobot(), or at the
  /// reference frame if there is no such robot. rootEdge() is the index of this edge; it is -1 for referenceRobot().
  const std::shared_ptr<const std::vector<TfEdge>>& tfEdges() const { return tf_edges_; }
  int rootEdge(int robot) const { return root_edges_[robot]; }

  /// The pairs that are checked, and the bodies of their links, each body once.
  const scene::Candidates& candidates() const { return candidates_; }
  const std::vector<int>& candidateBodies() const { return candidate_bodies_; }

  /// The largest deceleration of each of RobotModel::joints [rad/s^2] or [m/s^2]; nullopt if the parameters have none
  /// for it.
  const std::vector<std::optional<double>>& maxDecelerations() const { return max_decelerations_; }

  /// The uncertainty of the parameters. It does not contain the motion since the time of the poses, see addAge().
  const scene::Uncertainty& uncertainty() const { return uncertainty_; }

  /// False if guaranteed distances are the lower bounds of the distances themselves.
  bool isUncertain() const { return is_uncertain_; }

  /// The largest acceleration of each of RobotModel::joints; nullopt if the parameters have none for it.
  const std::vector<std::optional<double>>& maxAccelerations() const { return max_accelerations_; }

  /// How far each of RobotModel::joints may be off its trajectory [rad] or [m]; nullopt counts as 0.
  const std::vector<std::optional<double>>& trackingErrors() const { return tracking_errors_; }

  /// How far their velocities may be off [rad/s] or [m/s].
  const std::vector<std::optional<double>>& trackingVelocityErrors() const { return tracking_velocity_errors_; }

  /// How fast roots and moving objects can be.
  const scene::FrameSpeeds& baseSpeeds() const { return base_speeds_; }
  const scene::FrameSpeeds& objectSpeeds() const { return object_speeds_; }

  /// The columns of scene::DegreesOfFreedom that the controller of ~constraints moves.
  const std::vector<int>& constraintColumns() const { return constraint_columns_; }

  /// The distances at or below which a pair has a level.
  std::shared_ptr<const scene::LevelThresholds> thresholds() const { return std::atomic_load(&thresholds_); }

  /// thresholds(), with the distances of tracked sources for their objects among these.
  scene::LevelThresholds thresholdsWith(const scene::Objects& objects) const;

  /// Gives all pairs without thresholds of their own the thresholds of `settings`.
  /// Failure: throws std::invalid_argument naming a pair if its stop distance is above its warn distance, or if a stop
  ///          distance of its own is not below influence_distance. Then nothing changes.
  void useDefaults(const MonitorSettings& settings) const;

  /// The objects around the robot. They may change while the robot is used.
  ObjectSlot& objects() const { return *objects_; }

  /// The candidate pairs in which a link of this SRDF group moves. Throws std::invalid_argument for an unknown group.
  std::vector<scene::ShapeRefPair> pairsOfGroup(const std::string& group) const;

  /// Lends a state and scenes to one request. They may still have the poses and objects of an earlier request. The
  /// lease must end before the robot is destroyed.
  ScenePool::Lease borrowScenes() const { return scenes_->borrow(); }

 private:
  Config config_;
  std::vector<RobotSource> sources_;
  std::vector<RobotTexts> texts_;
  std::shared_ptr<const scene::SceneModel> model_;
  std::vector<std::string> frames_;  ///< the tf frame of each link
  scene::Candidates candidates_;
  std::vector<int> candidate_bodies_;
  int reference_link_;
  std::string reference_frame_;
  std::shared_ptr<const std::vector<TfEdge>> tf_edges_;
  std::vector<int> root_edges_;
  std::vector<std::optional<double>> max_decelerations_;
  std::vector<std::optional<double>> max_accelerations_;
  std::vector<std::optional<double>> tracking_errors_;
  std::vector<std::optional<double>> tracking_velocity_errors_;
  scene::Uncertainty uncertainty_;
  bool is_uncertain_;
  scene::FrameSpeeds base_speeds_, object_speeds_;
  std::vector<int> constraint_columns_;
  struct Thresholds : scene::LevelThresholds {
    scene::LevelDistances usual;  ///< the distances of the settings
  };
  mutable std::shared_ptr<const Thresholds> thresholds_;  ///< accessed by std::atomic_load and atomic_store
  std::unique_ptr<ObjectSlot> objects_;
  std::unique_ptr<ScenePool> scenes_;
};

/// Gives the objects of tracked sources among these the thresholds of `distances`, and no other object any. Allocates
/// only if there are more of them than ever before.
void assignTracked(const std::vector<TrackedSource>& tracked, const scene::Objects& objects,
                   const scene::LevelDistances& distances, scene::LevelThresholds& thresholds);

/// The bodies of all links in `pairs`, each once, in ascending order. Objects are left out.
std::vector<int> bodiesOf(const scene::RobotModel& robot, const std::vector<scene::ShapeRefPair>& pairs);

}  // namespace proximity_server::node
