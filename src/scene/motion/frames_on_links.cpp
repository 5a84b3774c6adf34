#include "proximity_server/scene/motion/frames_on_links.h"

#include "proximity_server/scene/model/names.h"

#include <stdexcept>

namespace proximity_server::scene {

using Eigen::Isometry3d;

namespace {

int linkOfFrame(const RobotModel& robot, const std::string& frame) {
  const int link = robot.findLink(frame);
  if (link < 0) throw std::invalid_argument("frame: there is no link " + unknownName(frame, namesOf(robot.links)));
  return link;
}

}  // namespace

std::string LinkFrames::named(const std::string& name) const {
  return robot_.links[name.empty() ? robot_.rootLink() : linkOfFrame(robot_, name)].name;
}

Isometry3d LinkFrames::seenFrom(const std::string& frame, const std::string& other, const Isometry3d& pose) {
  if (frame == other) return pose;
  const auto poseOf = [this](const std::string& link) { return poseOfLink(robot_, linkOfFrame(robot_, link), poses_); };
  return poseOf(frame).inverse() * poseOf(other) * pose;
}

Objects noObjects(const std::shared_ptr<const SceneModel>& model, ObjectRules::FreeObjects free_objects) {
  ObjectRules rules;
  rules.free_objects = free_objects;
  rules.base = ObjectRules::Base::StandsStill;
  return Objects(model).withRules(std::move(rules));
}

int carryingLink(const RobotModel& robot, const Object& object) {
  if (const auto* moving = std::get_if<Moving>(&object.placement)) return linkOfFrame(robot, moving->frame);
  if (const auto* held = std::get_if<Attached>(&object.placement)) return linkOfFrame(robot, held->link);
  return robot.rootLink();
}

Isometry3d poseOfLink(const RobotModel& robot, int link, const BodyPoses& poses) {
  return *poses[robot.links[link].body] * robot.links[link].body_T_link;
}

void setPoses(State& state, const BodyPoses& poses) {
  FramePoses frames;
  for (const std::string& frame : state.objects()->frames())
    frames.emplace_back(poseOfLink(state.robot(), linkOfFrame(state.robot(), frame), poses));
  state.set(poses, frames);
}

void setPositions(State& state, const Positions& positions) {
  setPoses(state, forwardKinematics(state.robot(), positions));
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
