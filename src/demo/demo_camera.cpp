// Simulates a depth camera for ./dev demo: it publishes what its rays meet first, the robot of robot_description in the
// latest joint_states, or a box that comes near and goes. Nobody else knows of the box. The parameters are in
// config/demo/camera.yaml.
#include "demo/demo_parameter.h"
#include "node/log_fatal.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/objects/object.h"
#include "proximity_server/scene/points/ray_search.h"
#include "system/version.h"

#include <geometry_msgs/TransformStamped.h>
#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <tf2_msgs/TFMessage.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace proximity_server::scene;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using proximity_server::demo::parameter;

constexpr char kFrame[] = "camera_frame";  // z is forwards, x to the right, y down, as in images
constexpr char kBox[] = "box";

Vector3d vectorOf(const ros::NodeHandle& nh, const std::string& name) {
  const auto values = parameter<std::vector<double>>(nh, name);
  return {values.at(0), values.at(1), values.at(2)};
}

std::shared_ptr<const SceneModel> modelOf(const ros::NodeHandle& nh) {
  RobotModel robot = loadRobotModel(parameter<std::string>(nh, "robot_description"), packageResolver(rosPackagePath()));
  return std::make_shared<const SceneModel>(makeSceneModel(std::move(robot), ""));
}

Object boxOf(const Vector3d& size) {
  return makeObject(kBox, {{proximity_server::narrowphase::Shape(proximity_server::narrowphase::Box{size})}},
                    Moving{kBox});
}

/// The pose of the camera in the frame of the root link.
Isometry3d poseOf(const Vector3d& position, const Vector3d& looks_at) {
  const Vector3d forwards = (looks_at - position).normalized();
  const Vector3d right = forwards.cross(Vector3d::UnitZ()).normalized();
  Isometry3d pose(Eigen::Translation3d{position});
  pose.linear() << right, forwards.cross(right), forwards;
  return pose;
}

/// Where the box is at a time [s]; it begins again after a period.
class Way {
 public:
  explicit Way(const ros::NodeHandle& nh)
      : far_(vectorOf(nh, "box/far")),
        near_(vectorOf(nh, "box/near")),
        times_(parameter<std::vector<double>>(nh, "box/times")) {
    if (times_.size() != 5) throw std::invalid_argument("~box/times has not five times");
  }

  /// The pose in the frame of the root link; nullopt while there is no box.
  std::optional<Isometry3d> at(double time) const {
    const double t = std::fmod(std::max(0.0, time), times_[4]);
    if (t < times_[0] || t >= times_[3]) return std::nullopt;
    const double nearness =
        std::min({1.0, (t - times_[0]) / (times_[1] - times_[0]), (times_[3] - t) / (times_[3] - times_[2])});
    return Isometry3d(Eigen::Translation3d(far_ + nearness * (near_ - far_)));
  }

 private:
  Vector3d far_, near_;
  std::vector<double> times_;  // [s] of a period: it appears, is near, leaves, is gone; the end
};

class Camera {
 public:
  Camera(ros::NodeHandle& nh, const ros::NodeHandle& private_nh)
      : model_(modelOf(nh)),
        state_(model_),
        search_(model_),
        way_(private_nh),
        pose_(poseOf(vectorOf(private_nh, "position"), vectorOf(private_nh, "looks_at"))),
        width_(parameter<int>(private_nh, "width")),
        height_(parameter<int>(private_nh, "height")),
        period_(1.0 / parameter<double>(private_nh, "rate")),
        noise_(0.0, parameter<double>(private_nh, "noise")),
        cloud_pub_(nh.advertise<sensor_msgs::PointCloud2>("camera/points", 1)),
        tf_pub_(nh.advertise<tf2_msgs::TFMessage>("/tf_static", 1, /*latch=*/true)) {
    state_.set(
        std::make_shared<const Objects>(Objects(model_).changed({AddObject{boxOf(vectorOf(private_nh, "box/size"))}})));
    const double focal_length = 0.5 * width_ / std::tan(0.5 * parameter<double>(private_nh, "view"));  // [pixels]
    for (int row = 0; row < height_; ++row)
      for (int column = 0; column < width_; ++column)
        rays_.push_back({pose_.translation(), pose_.linear() * Vector3d(column - 0.5 * (width_ - 1),
                                                                        row - 0.5 * (height_ - 1), focal_length)});
    publishPose();
    joints_sub_ = nh.subscribe("joint_states", 1, &Camera::onJoints, this);
  }

 private:
  void publishPose() {
    const Eigen::Quaterniond turn(pose_.linear());
    tf2_msgs::TFMessage message;
    geometry_msgs::TransformStamped& transform = message.transforms.emplace_back();
    transform.header.stamp = ros::Time::now();
    transform.header.frame_id = model_->robot.links[model_->robot.rootLink()].name;
    transform.child_frame_id = kFrame;
    transform.transform.translation.x = pose_.translation().x();
    transform.transform.translation.y = pose_.translation().y();
    transform.transform.translation.z = pose_.translation().z();
    transform.transform.rotation.w = turn.w();
    transform.transform.rotation.x = turn.x();
    transform.transform.rotation.y = turn.y();
    transform.transform.rotation.z = turn.z();
    tf_pub_.publish(message);
  }

  /// Publishes a cloud if it is time. Its stamp is that of the joints: robot_state_publisher knows them at this time.
  void onJoints(const sensor_msgs::JointState& joints) {
    const ros::Time stamp = joints.header.stamp;
    if (stamp >= latest_ && stamp < latest_ + period_) return;
    latest_ = stamp;
    std::map<std::string, double> positions;
    for (std::size_t i = 0; i < joints.name.size(); ++i) positions[joints.name[i]] = joints.position.at(i);
    state_.set(forwardKinematics(model_->robot, positions), {way_.at((stamp - start_).toSec())});
    sensor_msgs::PointCloud2 cloud = cloudOf(search_.firstHits(state_, rays_));
    cloud.header.stamp = stamp;
    cloud_pub_.publish(cloud);
  }

  /// A point for each pixel, in the frame of the camera; NaN where nothing was hit.
  sensor_msgs::PointCloud2 cloudOf(const std::vector<RayHit>& hits) {
    sensor_msgs::PointCloud2 cloud;
    cloud.header.frame_id = kFrame;
    sensor_msgs::PointCloud2Modifier modifier(cloud);
    modifier.setPointCloud2FieldsByString(1, "xyz");
    modifier.resize(hits.size());
    cloud.width = static_cast<unsigned>(width_);
    cloud.height = static_cast<unsigned>(height_);
    cloud.row_step = cloud.width * cloud.point_step;
    cloud.is_dense = 0;
    sensor_msgs::PointCloud2Iterator<float> out(cloud, "x");
    for (std::size_t i = 0; i < hits.size(); ++i, ++out) {
      const Vector3d along = pose_.linear().transpose() * rays_[i].direction.normalized();
      const Vector3d point = (hits[i].distance + noise_(random_)) * along;
      for (int axis = 0; axis < 3; ++axis) out[axis] = static_cast<float>(point[axis]);
    }
    return cloud;
  }

  std::shared_ptr<const SceneModel> model_;
  State state_;
  RaySearch search_;
  Way way_;
  Isometry3d pose_;  // in the frame of the root link
  int width_, height_;
  ros::Duration period_;
  std::vector<Ray> rays_;
  std::mt19937 random_{1};
  std::normal_distribution<double> noise_;  // [m] of a depth
  ros::Time start_ = ros::Time::now(), latest_;
  ros::Publisher cloud_pub_, tf_pub_;
  ros::Subscriber joints_sub_;
};

}  // namespace

int main(int argc, char** argv) {
  if (proximity_server::system::tellsVersion(argc, argv, "demo_camera")) return 0;
  ros::init(argc, argv, "demo_camera");
  ros::NodeHandle nh, private_nh("~");
  try {
    const Camera camera(nh, private_nh);
    ros::spin();
  } catch (const std::exception& error) {
    proximity_server::node::logFatal(error.what());
    return 1;
  }
  return 0;
}
