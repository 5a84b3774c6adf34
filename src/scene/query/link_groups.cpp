#include "scene/query/link_groups.h"

#include <algorithm>
#include <limits>

#include "scene/model/infinity.h"

namespace proximity_server::scene {
namespace {

/// The links of the candidate pairs, those of a branch of the kinematic tree together.
std::vector<int> linksInOrder(const SceneModel& model) {
  std::vector<bool> is_candidate(model.robot.links.size(), false);
  for (const int index : model.pairs.checked) {
    const LinkPair& pair = model.pairs.pairs[index];
    is_candidate[pair.link_a] = is_candidate[pair.link_b] = true;
  }
  const std::vector<Body>& bodies = model.robot.bodies;
  std::vector<std::vector<int>> children(bodies.size());
  for (std::size_t body = 1; body < bodies.size(); ++body)
    if (bodies[body].parent >= 0) children[bodies[body].parent].push_back(static_cast<int>(body));

  std::vector<int> links, pending;
  for (std::size_t body = bodies.size(); body-- > 0;)
    if (bodies[body].parent < 0) pending.push_back(static_cast<int>(body));
  while (!pending.empty()) {
    const auto body = static_cast<std::size_t>(pending.back());
    pending.pop_back();
    for (const int link : bodies[body].links)
      if (is_candidate[link]) links.push_back(link);
    pending.insert(pending.end(), children[body].rbegin(), children[body].rend());
  }
  return links;
}

}  // namespace

LinkGroups::LinkGroups(const SceneModel& model)
    : candidates_(model.robot.links.size() * model.robot.links.size(), -1), links_(model.robot.links.size()) {
  for (std::size_t i = 0; i < model.pairs.checked.size(); ++i) {
    const LinkPair& pair = model.pairs.pairs[model.pairs.checked[i]];
    candidates_[static_cast<std::size_t>(pair.link_a) * links_ + static_cast<std::size_t>(pair.link_b)] =
        static_cast<int>(i);
    largest_padding_ = std::max(largest_padding_, pair.padding);
  }
  const std::vector<int> links = linksInOrder(model);
  if (!links.empty()) add(links.begin(), links.end());
}

int LinkGroups::add(std::vector<int>::const_iterator begin, std::vector<int>::const_iterator end) {
  const auto index = groups_.size();
  groups_.emplace_back();
  if (end - begin == 1) {
    groups_[index].link = *begin;
  } else {
    const auto middle = begin + (end - begin) / 2;
    const int first = add(begin, middle), second = add(middle, end);
    groups_[index].parts = {first, second};
  }
  return static_cast<int>(index);
}

bool LinkGroups::refit(const PlacedRobot& robot) {
  for (std::size_t i = groups_.size(); i-- > 0;) {
    Group& group = groups_[i];
    if (group.isLink()) {
      if (!robot.isPlaced(group.link)) return false;
      group.box = robot.boxAround(group.link);
    } else {
      group.box = (*this)[group.parts[0]].box.merged((*this)[group.parts[1]].box);
    }
  }
  rounding_ = kPoseRounding * groups_.front().box.diagonal().norm();
  return true;
}

double LinkGroups::gap(int a, int b) const {
  const double distance = (*this)[a].box.exteriorDistance((*this)[b].box);
  return distance > 0.0 ? distance - rounding_ - largest_padding_ : -kInfinity;
}

int LinkGroups::candidate(int link_a, int link_b) const {
  const auto [a, b] = std::minmax(link_a, link_b);
  return candidates_[static_cast<std::size_t>(a) * links_ + static_cast<std::size_t>(b)];
}

}  // namespace proximity_server::scene
