#include "node/objects/cloud_boxes.h"

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
  robot_ = robot;
  padding_ = {sensing_.self_padding, {}};
  for (const auto& [link, padding] : sensing_.link_padding)
    padding_.of_links[robot->robotModel().findLink(link)] = padding;
  filter_.emplace(robot->sharedModel(), sensing_.resolution);
  state_.emplace(robot->sharedModel());
}

std::vector<scene::ObjectShape> CloudBoxes::make(const std::shared_ptr<const Robot>& robot,
                                                 const scene::Objects& objects, const scene::BodyPoses& poses,
                                                 const Eigen::Isometry3d& pose, std::vector<Vector3d>& points,
                                                 SensedCloud& cloud) {
  const Clock::time_point begin = Clock::now();
  follow(robot);
  cloud.points = points.size();
  const auto is_far = [&](const Vector3d& point) { return !(point.norm() <= sensing_.range); };
  points.erase(std::remove_if(points.begin(), points.end(), is_far), points.end());
  cloud.out_of_range = cloud.points - points.size();
  for (Vector3d& point : points) point = pose * point;

  std::vector<scene::ObjectChange> held;
  for (const int number : objects.numbers())
    if (const scene::Object& object = *objects.object(number);
        std::holds_alternative<scene::Attached>(object.placement))
      held.emplace_back(scene::AddObject{object});
  state_->set(std::make_shared<const scene::Objects>(scene::Objects(robot->sharedModel()).changed(held)));
  state_->set(poses);
  cloud.on_robot = filter_->remove(*state_, padding_, points);

  grid_.clear();
  for (const Vector3d& point : points) grid_.add(point);
  cloud.voxels = grid_.size();
  std::vector<scene::ObjectShape> shapes;
  if (!points.empty()) {
    scene::Boxes boxes{grid_.boxes()};
    cloud.boxes = boxes.boxes.size();
    shapes.push_back({std::move(boxes)});
  }
  cloud.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return shapes;
}

}  // namespace proximity_server::node
