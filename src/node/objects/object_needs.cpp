#include "node/objects/object_needs.h"

#include <algorithm>
#include <set>
#include <string>
#include <variant>

namespace proximity_server::node {
namespace {

std::vector<int> toVector(const std::set<int>& numbers) { return {numbers.begin(), numbers.end()}; }

/// The body that holds an object, or -1.
int bodyOf(const scene::RobotModel& robot, const scene::Object& object) {
  const auto* held = std::get_if<scene::Attached>(&object.placement);
  return held ? robot.links[robot.findLink(held->link)].body : -1;
}

/// The body of a link; -1 if `link` is -1.
int bodyOfLink(const Robot& robot, int link) { return link < 0 ? -1 : robot.robotModel().links[link].body; }

int bodyOfReferenceFrame(const Robot& robot) { return bodyOfLink(robot, robot.referenceLink()); }

/// The body that carries a tf frame: that of the link with this frame. Any other frame counts as at rest in the
/// reference frame.
int carrierOf(const Robot& robot, const std::string& frame) {
  const int link = robot.linkOfFrame(frame);
  return link >= 0 ? bodyOfLink(robot, link) : bodyOfReferenceFrame(robot);
}

bool isChecked(const scene::Objects& objects, int link) {
  const auto is_checked = [&](int number) { return objects.isChecked(link, scene::ShapeRef::ofObject(number)); };
  return std::any_of(objects.numbers().begin(), objects.numbers().end(), is_checked);
}

}  // namespace

std::vector<int> bodiesOfCheckedPairs(const Robot& robot, const scene::Objects& objects) {
  const scene::RobotModel& model = robot.robotModel();
  std::set<int> bodies(robot.candidateBodies().begin(), robot.candidateBodies().end());
  if (objects.empty()) return toVector(bodies);
  for (std::size_t link = 0; link < model.links.size(); ++link) {
    if (bodies.count(model.links[link].body) == 0 && isChecked(objects, static_cast<int>(link)))
      bodies.insert(model.links[link].body);
  }
  for (const int number : objects.searchers()) {
    const int body = bodyOf(model, *objects.object(number));
    if (body >= 0) bodies.insert(body);
  }
  for (const int body : bodiesOf(robot, framesOf(objects))) bodies.insert(body);
  return toVector(bodies);
}

std::vector<int> withInequalities(const Robot& robot, const std::vector<int>& bodies) {
  const scene::RobotModel& model = robot.robotModel();
  std::set<int> needed(bodies.begin(), bodies.end());
  for (const scene::JointInequality& inequality : model.inequalities)
    for (const scene::JointInequality::Term& term : inequality.terms)
      needed.insert(model.links[model.joints[term.joint].child_link].body);
  return toVector(needed);
}

CarrierFrames framesOf(const scene::Objects& objects) {
  CarrierFrames frames{objects.frames(), {}};
  for (std::size_t i = 0; i < frames.names.size(); ++i) frames.needed.push_back(static_cast<int>(i));
  return frames;
}

std::vector<int> bodiesOf(const Robot& robot, const scene::Objects& objects,
                          const std::vector<scene::ShapeRefPair>& pairs) {
  const std::vector<int> of_links = bodiesOf(robot.robotModel(), pairs);
  std::set<int> bodies(of_links.begin(), of_links.end());
  for (const scene::ShapeRefPair& pair : pairs) {
    for (const scene::ShapeRef& ref : {pair.a, pair.b}) {
      const int body = ref.isObject() ? bodyOf(robot.robotModel(), *objects.object(ref.object())) : -1;
      if (body >= 0) bodies.insert(body);
    }
  }
  for (const int body : bodiesOf(robot, framesOf(objects, pairs))) bodies.insert(body);
  return toVector(bodies);
}

CarrierFrames framesOf(const scene::Objects& objects, const std::vector<scene::ShapeRefPair>& pairs) {
  CarrierFrames frames{objects.frames(), {}};
  std::set<int> asked;
  for (const scene::ShapeRefPair& pair : pairs) {
    for (const scene::ShapeRef& ref : {pair.a, pair.b}) {
      const scene::Object* object = ref.isObject() ? objects.object(ref.object()) : nullptr;
      const auto* moving = object ? std::get_if<scene::Moving>(&object->placement) : nullptr;
      if (!moving) continue;
      const auto place = std::lower_bound(frames.names.begin(), frames.names.end(), moving->frame);
      asked.insert(static_cast<int>(place - frames.names.begin()));
    }
  }
  frames.needed = toVector(asked);
  return frames;
}

int carrierOf(const Robot& robot, const scene::Object& object) {
  if (const auto* moving = std::get_if<scene::Moving>(&object.placement)) return carrierOf(robot, moving->frame);
  const int held_by = bodyOf(robot.robotModel(), object);
  return held_by >= 0 ? held_by : bodyOfReferenceFrame(robot);
}

scene::ObjectCarriers carriersOf(const Robot& robot, const scene::Objects& objects) {
  const auto isRoot = [&](int body) { return body >= 0 && robot.robotModel().bodies[body].joint < 0; };
  scene::ObjectCarriers carriers;
  if (const int body = bodyOfReferenceFrame(robot); !isRoot(body)) carriers.of_fixed = body;
  for (const std::string& frame : objects.frames()) {
    const int body = carrierOf(robot, frame);
    carriers.of_frames.push_back(isRoot(body) && robot.linkOfFrame(frame) < 0 ? -1 : body);
  }
  return carriers;
}

}  // namespace proximity_server::node
