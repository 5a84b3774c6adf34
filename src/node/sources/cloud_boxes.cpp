#include "node/sources/cloud_boxes.h"

#include <algorithm>
#include <chrono>

namespace proximity_server::node {

using Clock = std::chrono::steady_clock;
using Eigen::Vector3d;

std::vector<int> CloudBoxes::bodiesOf(const Robot& robot) {
  std::vector<scene::ShapeRefPair> links;
  for (int link = 0; link < static_cast<int>(robot.robotModel().links.size()); ++link)
    if (robot.robotModel().hasGeometry(link)) links.push_back({{link}, {link}});
  return node::bodiesOf(robot.robotModel(), links);
}

void CloudBoxes::follow(const std::shared_ptr<const Robot>& robot) {
  if (robot == robot_) return;
  if (robot_ && robot_->referenceFrame() != robot->referenceFrame()) memory_.clear();
  robot_ = robot;
  padding_ = {sensing_.self_padding, {}, sensing_.object_padding};
  for (const auto& [link, padding] : sensing_.link_padding)
    padding_.of_links[robot->robotModel().findLink(link)] = padding;
  filter_.emplace(robot->sharedModel(), sensing_.resolution);
  state_.emplace(robot->sharedModel());
}

/// Takes the points to the reference frame, without those that are too many or out of range, and finds the rays to them.
void CloudBoxes::place(const Eigen::Isometry3d& sensor, std::vector<Vector3d>& points, SensedCloud& cloud) {
  const std::size_t step = (points.size() - 1) / static_cast<std::size_t>(sensing_.max_points) + 1;
  const bool clears = memory_.isPersistent() && sensing_.clearing;
  ends_.clear();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); i += step) {
    const double distance = points[i].norm();
    const bool is_far = !(distance <= sensing_.range);
    const Vector3d point = sensor * points[i];
    if (clears) ends_.push_back(is_far ? sensor * Vector3d(sensing_.range / distance * points[i]) : point);
    if (is_far)
      ++cloud.out_of_range;
    else
      points[kept++] = point;
  }
  cloud.over_limit = points.size() - kept - cloud.out_of_range;
  points.resize(kept);
  rays_.set(sensor.translation(), ends_);
}

/// Removes the points of the robot, of what it holds, and of what stands still and has a padding.
void CloudBoxes::removeOwn(const scene::Objects& objects, const scene::BodyPoses& poses, std::vector<Vector3d>& points,
                           SensedCloud& cloud) {
  std::vector<scene::ObjectChange> known;
  for (const int number : objects.numbers()) {
    const scene::Object& object = *objects.object(number);
    const bool is_held = std::holds_alternative<scene::Attached>(object.placement);
    const bool stands = std::holds_alternative<scene::Fixed>(object.placement);
    if (is_held || (stands && padding_.of_objects.count(object.id) > 0)) known.emplace_back(scene::AddObject{object});
  }
  state_->set(std::make_shared<const scene::Objects>(scene::Objects(robot_->sharedModel()).changed(known)));
  state_->set(poses);
  cloud.on_robot = filter_->remove(*state_, padding_, points);
}

std::vector<scene::ObjectShape> CloudBoxes::make(const std::shared_ptr<const Robot>& robot,
                                                 const scene::Objects& objects, const Moment& at,
                                                 std::vector<Vector3d>& points, SensedCloud& cloud) {
  const Clock::time_point begin = Clock::now();
  follow(robot);
  cloud.points = points.size();
  rays_.set(at.sensor.translation(), {});
  if (!points.empty()) {
    place(at.sensor, points, cloud);
    removeOwn(objects, at.poses, points, cloud);
  }
  memory_.see(at.time, points, rays_);
  cloud.voxels = memory_.grid().size();
  cloud.persistent = memory_.persistent();
  std::vector<scene::ObjectShape> shapes;
  if (cloud.voxels > 0) {
    scene::Boxes boxes{memory_.grid().boxes()};
    cloud.boxes = boxes.boxes.size();
    shapes.push_back({std::move(boxes)});
  }
  cloud.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return shapes;
}

}  // namespace proximity_server::node
