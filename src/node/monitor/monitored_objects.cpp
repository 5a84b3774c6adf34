#include "node/monitor/monitored_objects.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <utility>

namespace proximity_server::node {
namespace {

/// The joints from a body to its root, in ascending order; none for the body -1, which is the frame of the poses.
std::vector<int> chainOf(const scene::RobotModel& robot, int body) {
  std::vector<int> joints;
  for (; body >= 0 && robot.bodies[body].joint >= 0; body = robot.bodies[body].parent)
    joints.push_back(robot.bodies[body].joint);
  std::sort(joints.begin(), joints.end());
  return joints;
}

/// The robot of a body, or TfPoses::kReferenceFrame for the body -1.
int rootOf(const scene::RobotModel& robot, int body) {
  return body < 0 ? TfPoses::kReferenceFrame : robot.bodies[body].robot;
}

/// The two bodies of each checked pair. Pairs with the same bodies are one entry.
std::set<std::pair<int, int>> checkedBodies(const Robot& robot, const scene::Objects& objects) {
  const scene::RobotModel& model = robot.robotModel();
  std::set<std::pair<int, int>> bodies;
  for (const scene::ShapeRefPair& pair : robot.candidates())
    bodies.emplace(model.links[pair.a.link()].body, model.links[pair.b.link()].body);

  std::map<int, std::vector<int>> carried;  // the objects that each body carries
  for (const int number : objects.numbers()) carried[carrierOf(robot, *objects.object(number))].push_back(number);
  const auto add = [&](int body, const auto& reason_with) {
    for (const auto& [carrier, numbers] : carried) {
      const auto is_checked = [&](int number) { return reason_with(number) == scene::PairReason::Checked; };
      if (std::any_of(numbers.begin(), numbers.end(), is_checked)) bodies.emplace(body, carrier);
    }
  };
  for (std::size_t link = 0; link < model.links.size(); ++link)
    add(model.links[link].body,
        [&](int number) { return objects.reason(static_cast<int>(link), scene::ShapeRef::ofObject(number)); });
  for (const int searcher : objects.searchers())
    add(carrierOf(robot, *objects.object(searcher)), [&](int number) {
      return objects.reason(scene::ShapeRef::ofObject(searcher), scene::ShapeRef::ofObject(number));
    });
  return bodies;
}

std::size_t longestName(const scene::RobotModel& robot, const scene::Objects& objects) {
  std::size_t longest = 0;
  for (const int number : objects.numbers()) longest = std::max(longest, objects.object(number)->id.size());
  for (const scene::Link& link : robot.links) longest = std::max(longest, link.name.size());
  for (const scene::Member& member : robot.robots) longest = std::max(longest, member.name.size());
  for (const scene::Collision& collision : robot.collisions) longest = std::max(longest, collision.name.size());
  return longest;
}

}  // namespace

MotionSources motionSourcesOf(const Robot& robot, const scene::Objects& objects) {
  const scene::RobotModel& model = robot.robotModel();
  std::set<int> joints, roots;
  for (const auto& [body_a, body_b] : checkedBodies(robot, objects)) {
    const std::vector<int> a = chainOf(model, body_a), b = chainOf(model, body_b);
    std::vector<int> between;
    std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(between));
    for (const int joint : between) joints.insert(model.leaderOf(joint).joint);
    const int root_a = rootOf(model, body_a), root_b = rootOf(model, body_b);
    if (root_a != root_b) roots.insert({root_a, root_b});
  }
  for (const scene::JointInequality& inequality : model.inequalities)
    for (const scene::JointInequality::Term& term : inequality.terms) joints.insert(term.joint);
  return {{joints.begin(), joints.end()}, {roots.begin(), roots.end()}};
}

MonitoredObjects::MonitoredObjects(const Robot& robot, const RobotObjects& present)
    : objects(present),
      bodies(withInequalities(robot, bodiesOfCheckedPairs(robot, *present.all))),
      motion_sources(motionSourcesOf(robot, *present.all)),
      frames(framesOf(*present.all)),
      carriers(carriersOf(robot, *present.all)),
      longest_name(longestName(robot.robotModel(), *present.all)) {}

}  // namespace proximity_server::node
