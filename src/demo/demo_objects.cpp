#include "demo/demo_objects.h"

#include <proximity_server/ApplyObjects.h>
#include <proximity_server/ObjectChange.h>
#include <proximity_server/PairRule.h>
#include "demo/demo_parameter.h"

#include <shape_msgs/SolidPrimitive.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <algorithm>

namespace proximity_server::demo {
namespace {

constexpr char kBar[] = "bar";

geometry_msgs::Pose poseAt(const std::vector<double>& position) {
  geometry_msgs::Pose pose;
  pose.position.x = position.at(0);
  pose.position.y = position.at(1);
  pose.position.z = position.at(2);
  return pose;
}

ObjectChange change(std::uint8_t operation, const std::string& id) {
  ObjectChange result;
  result.operation = operation;
  result.id = id;
  return result;
}

ObjectChange solid(const std::string& id, std::uint8_t type, const std::vector<double>& dimensions,
                   const std::vector<double>& position) {
  ObjectChange result = change(ObjectChange::REPLACE, id);
  result.pose = poseAt(position);
  result.primitives.resize(1);
  result.primitives[0].type = type;
  result.primitives[0].dimensions = dimensions;
  return result;
}

std::vector<ObjectChange> boxesOf(const ros::NodeHandle& nh) {
  std::vector<ObjectChange> boxes;
  for (const auto& [id, box] : parameter<XmlRpc::XmlRpcValue>(nh, "boxes")) {
    boxes.push_back(solid(id, shape_msgs::SolidPrimitive::BOX,
                          parameter<std::vector<double>>(nh, "boxes/" + id + "/size"),
                          parameter<std::vector<double>>(nh, "boxes/" + id + "/position")));
  }
  return boxes;
}

ObjectChange barOf(const ros::NodeHandle& nh) {
  return solid(kBar, shape_msgs::SolidPrimitive::CYLINDER,
               {parameter<double>(nh, "bar/length"), parameter<double>(nh, "bar/radius")},
               parameter<std::vector<double>>(nh, "bar/position"));
}

ObjectChange attachmentOf(const ros::NodeHandle& nh) {
  ObjectChange result = change(ObjectChange::ATTACH, kBar);
  result.link = parameter<std::string>(nh, "held/link");
  result.touch_links = parameter<std::vector<std::string>>(nh, "held/touch_links");
  result.header.frame_id = result.link;
  result.pose = poseAt(parameter<std::vector<double>>(nh, "held/position"));
  return result;
}

std::vector<PairRule> rulesOf(const ros::NodeHandle& nh) {
  std::vector<PairRule> rules;
  for (const std::string& other : parameter<std::vector<std::string>>(nh, "bar/may_touch")) {
    PairRule rule;
    rule.a = kBar;
    rule.b = other;
    rule.allowed = true;
    rules.push_back(rule);
  }
  return rules;
}

}  // namespace

DemoObjects::DemoObjects(ros::NodeHandle& nh, const ros::NodeHandle& private_nh)
    : boxes_(boxesOf(private_nh)),
      bar_(barOf(private_nh)),
      rules_(rulesOf(private_nh)),
      attach_bar_(attachmentOf(private_nh)),
      held_from_(parameter<double>(private_nh, "held/from")),
      held_until_(parameter<double>(private_nh, "held/until")),
      apply_(nh.serviceClient<ApplyObjects>("proximity_server/apply_objects")),
      objects_(nh.subscribe("proximity_server/objects", 1, &DemoObjects::onObjects, this)) {}

void DemoObjects::onObjects(const ObjectList::ConstPtr& list) {
  latest_list_ = list;
  node_start_ = list->node_start;
}

void DemoObjects::update(double time) {
  const bool starts_again = time < time_;
  time_ = time;
  if (node_start_ == 0) return;
  if (node_start_ != sent_to_) sendAll();
  // The list shows what others have changed. A list that is older than our last change is of no use.
  if (node_start_ != sent_to_ || latest_list_->node_start != node_start_ || latest_list_->revision < revision_) return;
  if (starts_again && isAnyMissing()) return sendAll();
  const ObjectInfo* bar = find(kBar);
  if (!bar) return;
  const bool is_held = held_from_ <= time && time < held_until_, is_in_hand = bar->link == attach_bar_.link;
  if (is_held && !is_in_hand) pickUp();
  if (!is_held && is_in_hand) putDown();
}

const ObjectInfo* DemoObjects::find(const std::string& id) const {
  const auto has_id = [&](const ObjectInfo& object) { return object.id == id; };
  const auto found = std::find_if(latest_list_->objects.begin(), latest_list_->objects.end(), has_id);
  return found == latest_list_->objects.end() ? nullptr : &*found;
}

bool DemoObjects::isAnyMissing() const {
  const auto is_missing = [&](const ObjectChange& box) { return !find(box.id); };
  return !find(kBar) || std::any_of(boxes_.begin(), boxes_.end(), is_missing);
}

void DemoObjects::sendAll() {
  ObjectChanges changes;
  changes.changes = boxes_;
  changes.changes.push_back(bar_);
  changes.set_rules = true;
  changes.rules = rules_;
  if (apply(changes)) sent_to_ = node_start_;
}

void DemoObjects::pickUp() {
  ObjectChanges changes;
  changes.changes = {attach_bar_};
  apply(changes);
}

void DemoObjects::putDown() {
  ObjectChange place = change(ObjectChange::MOVE, kBar);
  place.pose = bar_.pose;
  ObjectChanges changes;
  changes.changes = {change(ObjectChange::DETACH, kBar), place};
  apply(changes);
}

/// Calls the service; returns false if it has changed nothing.
bool DemoObjects::apply(const ObjectChanges& changes) {
  ApplyObjects call;
  call.request.changes = changes;
  if (!apply_.call(call)) return false;
  node_start_ = call.response.node_start;
  revision_ = call.response.revision;
  // The change may be refused because somebody has just removed the bar, or because the node was restarted. The next
  // list shows that.
  if (!call.response.success)
    ROS_WARN_STREAM_THROTTLE(5.0, "the objects of the demo are refused: " << call.response.status.message);
  return call.response.success;
}

}  // namespace proximity_server::demo
