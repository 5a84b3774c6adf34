#include "scene/filter/srdf_group.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

/// Collects the movable joints of a group.
class GroupJoints {
 public:
  GroupJoints(const RobotModel& model, const LinkTable& links, const Srdf& srdf)
      : model_(model), links_(links), srdf_(srdf) {}

  void add(const std::string& name, std::vector<std::string> within = {}) {
    if (std::find(within.begin(), within.end(), name) != within.end()) {
      throw std::invalid_argument("SRDF: the group " + quoted(name) + " contains itself");
    }
    if (!added_.insert(name).second) return;  // otherwise the work would double with each level of nested groups
    within.push_back(name);
    const Srdf::Group& group = find(name);
    for (const std::string& link : group.links) addLink(link);
    for (const std::string& joint : group.joints) addJoint(joint);
    for (const auto& [base, tip] : group.chains) addChain(base, tip);
    for (const std::string& subgroup : group.subgroups) add(subgroup, within);
  }

  const std::set<int>& joints() const { return joints_; }
  const std::vector<std::string>& unknown() const { return unknown_; }

 private:
  const Srdf::Group& find(const std::string& name) const {
    std::vector<std::string> names;
    for (const Srdf::Group& group : srdf_.groups) {
      if (group.name == name) return group;
      names.push_back(group.name);
    }
    constexpr std::size_t kMostGroups = 30;
    const std::string all = names.empty() ? "it has none" : "it has " + listed(names, kMostGroups);
    throw std::invalid_argument("the SRDF has no group " + unknownName(name, names) + "; " + all);
  }

  /// Adds the joint that carries a link.
  void addLink(const std::string& name) {
    const int link = findLink(name);
    if (link < 0) return;
    const Body& body = model_.bodies[links_.body(link)];
    if (body.link == link && body.joint >= 0) joints_.insert(body.joint);
  }

  void addJoint(const std::string& name) {
    std::vector<std::string> known = model_.fixed_joints;
    known.insert(known.end(), srdf_.virtual_joints.begin(), srdf_.virtual_joints.end());
    if (std::find(known.begin(), known.end(), name) != known.end()) return;
    for (int i = 0; i < static_cast<int>(model_.joints.size()); ++i) {
      if (model_.joints[i].name == name) {
        joints_.insert(i);
        return;
      }
      known.push_back(model_.joints[i].name);
    }
    unknown_.push_back("no joint " + unknownName(name, known));
  }

  /// Adds the joints between two links: those above one of them, but not above both.
  void addChain(const std::string& base, const std::string& tip) {
    const int base_link = findLink(base), tip_link = findLink(tip);
    if (base_link < 0 || tip_link < 0) return;
    const std::set<int> above_base = jointsAbove(base_link), above_tip = jointsAbove(tip_link);
    std::set_symmetric_difference(above_base.begin(), above_base.end(), above_tip.begin(), above_tip.end(),
                                  std::inserter(joints_, joints_.end()));
  }

  std::set<int> jointsAbove(int link) const {
    std::set<int> joints;
    for (const Body* body = &model_.bodies[links_.body(link)]; body->joint >= 0; body = &model_.bodies[body->parent]) {
      joints.insert(body->joint);
    }
    return joints;
  }

  int findLink(const std::string& name) {
    const int link = links_.find(name);
    if (link < 0) unknown_.push_back("no link " + links_.unknown(name));
    return link;
  }

  const RobotModel& model_;
  const LinkTable& links_;
  const Srdf& srdf_;
  std::set<std::string> added_;
  std::set<int> joints_;
  std::vector<std::string> unknown_;
};

}  // namespace

std::vector<bool> bodiesMovedByGroup(const RobotModel& model, const LinkTable& links, const Srdf& srdf,
                                     const std::string& group, std::vector<std::string>& warnings) {
  GroupJoints collected(model, links, srdf);
  collected.add(group);
  if (!collected.unknown().empty()) {
    warnings.push_back("group " + quoted(group) + " of the SRDF: " + listed(collected.unknown()) + ".");
  }
  const auto follows = [&](int joint) {
    while (!collected.joints().count(joint)) {
      if (!model.joints[joint].mimic) return false;
      joint = model.joints[joint].mimic->joint;
    }
    return true;
  };
  std::vector<bool> moved;
  for (const Body& body : model.bodies) {  // parents come first
    moved.push_back(body.joint >= 0 && (moved[body.parent] || follows(body.joint)));
  }
  return moved;
}

}  // namespace proximity_server::scene
