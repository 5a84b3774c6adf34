#include "proximity_server/scene/motion/frames_on_links.h"

#include <stdexcept>

#include "proximity_server/scene/model/names.h"

namespace proximity_server::scene {

using Eigen::Isometry3d;

namespace {

int rootOf(const RobotModel& robot) { return robot.bodies.front().link; }

int linkOfFrame(const RobotModel& robot, const std::string& frame) {
  const int link = robot.findLink(frame);
  if (link < 0) throw std::invalid_argument("frame: there is no link " + unknownName(frame, namesOf(robot.links)));
  return link;
}

}  // namespace

std::variant<Fixed, Moving> standingIn(const RobotModel& robot, const std::string& frame, const Isometry3d& pose) {
  if (frame.empty() || linkOfFrame(robot, frame) == rootOf(robot)) return Fixed{pose};
  return Moving{frame, pose};
}

Placement placementOf(const RobotModel& robot, const WrittenPlace& place) {
  if (!place.link.empty()) return Attached{place.link, place.touch_links, place.pose};
  return std::visit([](auto&& standing) { return Placement(standing); }, standingIn(robot, place.frame, place.pose));
}

int carryingLink(const RobotModel& robot, const Object& object) {
  if (const auto* moving = std::get_if<Moving>(&object.placement)) return linkOfFrame(robot, moving->frame);
  if (const auto* held = std::get_if<Attached>(&object.placement)) return linkOfFrame(robot, held->link);
  return rootOf(robot);
}

const Isometry3d& poseInCarrier(const Object& object) {
  if (const auto* fixed = std::get_if<Fixed>(&object.placement)) return fixed->world_T_object;
  if (const auto* moving = std::get_if<Moving>(&object.placement)) return moving->frame_T_object;
  return std::get<Attached>(object.placement).link_T_object;
}

Isometry3d poseOfLink(const RobotModel& robot, int link, const BodyPoses& poses) {
  return *poses[robot.links[link].body] * robot.links[link].body_T_link;
}

Isometry3d seenFrom(const RobotModel& robot, int link, const Object& object, const BodyPoses& poses) {
  const int carrier = carryingLink(robot, object);
  if (carrier == link) return poseInCarrier(object);
  return poseOfLink(robot, link, poses).inverse() * poseOfLink(robot, carrier, poses) * poseInCarrier(object);
}

FramePoses framePoses(const Objects& objects, const BodyPoses& poses) {
  const RobotModel& robot = objects.model().robot;
  FramePoses frames;
  for (const std::string& frame : objects.frames())
    frames.emplace_back(poseOfLink(robot, linkOfFrame(robot, frame), poses));
  return frames;
}

RobotMotion::ObjectFrames framesOnLinks(const Objects& objects) {
  const RobotModel& robot = objects.model().robot;
  RobotMotion::ObjectFrames frames;
  for (const std::string& frame : objects.frames()) {
    const Link& link = robot.links[linkOfFrame(robot, frame)];
    frames.moving.push_back(RobotMotion::atRest(link.body_T_link, link.body));
  }
  return frames;
}

}  // namespace proximity_server::scene
