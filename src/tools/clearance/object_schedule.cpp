#include "tools/clearance/object_schedule.h"

#include <functional>
#include <stdexcept>
#include <utility>
#include <variant>

#include "proximity_server/scene/model/names.h"

namespace proximity_server::tools {
namespace {

using Eigen::Isometry3d;
using scene::RobotModel;
using Operation = scene::WrittenChange::Operation;

/// Runs `act`; an error of it begins with the place in the file.
template <class Act>
auto at(const scene::WrittenObject& object, Act act) {
  try {
    return act();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(object.source + ": " + error.what());
  }
}

int linkNamed(const RobotModel& robot, const std::string& name, const std::string& field) {
  const int link = robot.findLink(name);
  if (link < 0)
    throw std::invalid_argument(field + ": there is no link " + scene::unknownName(name, scene::namesOf(robot.links)));
  return link;
}

bool isDue(const scene::Moment& moment, long row, std::optional<double> time) {
  if (const auto* at_row = std::get_if<scene::AtRow>(&moment)) return at_row->row <= row;
  return time && std::get<scene::AtTime>(moment).time <= *time;
}

scene::ObjectRules rulesOf(const std::vector<scene::WrittenRule>& rules) {
  scene::ObjectRules result;
  result.base = scene::ObjectRules::Base::StandsStill;  // all poses are in the frame of the root link
  for (const scene::WrittenRule& rule : rules) result.allowed.set(rule.a, rule.b, rule.rule);
  return result;
}

}  // namespace

ObjectSchedule::ObjectSchedule(const std::shared_ptr<const scene::SceneModel>& model, const scene::ObjectFile& file,
                               const scene::ObjectOptions& options)
    : model_(model),
      now_(std::make_shared<const scene::Objects>(scene::Objects(model).withRules(rulesOf(file.rules)))) {
  std::vector<scene::ObjectChange> additions;
  for (const scene::WrittenObject& object : file.objects)
    additions.emplace_back(scene::AddObject{made(object, options)});
  try {
    now_ = std::make_shared<const scene::Objects>(now_->changed(additions));
  } catch (const std::invalid_argument&) {
    addOneByOne(file.objects, additions);  // names the place of the one that is refused
  }
  for (const scene::WrittenChange& change : file.changes) {
    const bool has_shapes = change.operation == Operation::Add || change.operation == Operation::Replace;
    steps_.push_back({change, has_shapes ? made(change.object, options) : scene::Object()});
  }
  const std::shared_ptr<const scene::Objects> start = now_;
  const scene::BodyPoses zero =
      scene::forwardKinematics(model_->robot, scene::Positions(model_->robot.joints.size(), 0.0));
  for (const Step& step : steps_) make(step, zero);
  now_ = start;
}

void ObjectSchedule::addOneByOne(const std::vector<scene::WrittenObject>& objects,
                                 const std::vector<scene::ObjectChange>& additions) {
  for (std::size_t i = 0; i < objects.size(); ++i)
    now_ = at(objects[i], [&] { return std::make_shared<const scene::Objects>(now_->changed({additions[i]})); });
}

void ObjectSchedule::advance(long row, std::optional<double> time, const scene::Positions& positions) {
  if (next_ == steps_.size() || !isDue(steps_[next_].change.at, row, time)) return;
  const scene::BodyPoses poses = scene::forwardKinematics(model_->robot, positions);
  while (next_ < steps_.size() && isDue(steps_[next_].change.at, row, time)) make(steps_[next_++], poses);
}

std::optional<double> ObjectSchedule::nextTime() const {
  const auto* at_time = next_ < steps_.size() ? std::get_if<scene::AtTime>(&steps_[next_].change.at) : nullptr;
  return at_time ? std::optional<double>(at_time->time) : std::nullopt;
}

bool ObjectSchedule::hasTimes() const {
  for (const Step& step : steps_)
    if (std::holds_alternative<scene::AtTime>(step.change.at)) return true;
  return false;
}

std::string ObjectSchedule::leftOver() const {
  if (next_ == steps_.size()) return "";
  const std::size_t left = steps_.size() - next_;
  return std::to_string(left) + (left == 1 ? " change of objects was" : " changes of objects were") +
         " never made, because the states end before: the first is that of " + steps_[next_].change.object.source;
}

void ObjectSchedule::make(const Step& step, const scene::BodyPoses& poses) {
  const std::string& id = step.change.object.id;
  std::vector<scene::ObjectChange> changes;
  at(step.change.object, [&] {
    if (step.change.operation != Operation::Remove) {
      changes.push_back(changeFor(step, poses));
    } else {
      for (const int number : now_->numbers())
        if (id == "*" || now_->object(number)->id == id)
          changes.emplace_back(scene::RemoveObject{now_->object(number)->id});
    }
    now_ = std::make_shared<const scene::Objects>(now_->changed(changes));
  });
}

/// All but the removal of objects.
scene::ObjectChange ObjectSchedule::changeFor(const Step& step, const scene::BodyPoses& poses) const {
  const RobotModel& robot = model_->robot;
  const scene::WrittenPlace& place = step.change.object.place;
  const std::string& id = step.change.object.id;
  switch (step.change.operation) {
    case Operation::Add:
      return scene::AddObject{step.object};
    case Operation::Replace:
      if (now_->find(id) < 0) return scene::AddObject{step.object};
      return scene::ReplaceObject{step.object};
    case Operation::Move:
      return scene::MoveObject{id, standingIn(robot, place.frame, place.pose)};
    default:
      break;
  }
  const int number = now_->find(id);
  if (number < 0) throw std::invalid_argument("there is no object with this id then");
  const scene::Object& object = *now_->object(number);
  if (step.change.operation == Operation::Detach) {
    const int frame = place.frame.empty() ? robot.bodies.front().link : linkNamed(robot, place.frame, "frame");
    return scene::DetachObject{id, standingIn(robot, place.frame, seenFrom(robot, frame, object, poses))};
  }
  const int link = linkNamed(robot, place.link, "link");
  const bool stays = step.change.pose == scene::WrittenChange::Pose::Kept;
  return scene::AttachObject{
      id, {place.link, place.touch_links, stays ? seenFrom(robot, link, object, poses) : place.pose}};
}

scene::Object ObjectSchedule::made(const scene::WrittenObject& object, const scene::ObjectOptions& options) {
  scene::ObjectOptions padded = options;
  padded.padding = object.padding;
  scene::Object result = at(object, [&] {
    return scene::makeObject(object.id, object.shapes, placementOf(model_->robot, object.place), padded);
  });
  for (const std::string& warning : scene::warningsOf(result))
    warnings_.push_back("object " + scene::quoted(object.id) + ": " + warning);
  all_.push_back(result);
  return result;
}

}  // namespace proximity_server::tools
