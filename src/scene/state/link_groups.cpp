#include "scene/state/link_groups.h"

#include "proximity_server/narrowphase/assertion.h"
#include "scene/model/numbers.h"

#include <algorithm>

namespace proximity_server::scene {
namespace {

/// The links of the candidate pairs. The links of a branch of the kinematic tree are together.
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
    : links_(linksInOrder(model)),
      tree_(BoxTree::inOrder(links_)),
      candidates_(model.robot.links.size() * model.robot.links.size(), -1),
      link_count_(model.robot.links.size()) {
  for (std::size_t i = 0; i < model.pairs.checked.size(); ++i) {
    const LinkPair& pair = model.pairs.pairs[model.pairs.checked[i]];
    candidates_[static_cast<std::size_t>(pair.link_a) * link_count_ + static_cast<std::size_t>(pair.link_b)] =
        static_cast<int>(i);
    largest_padding_ = std::max(largest_padding_, pair.padding);
  }
}

bool LinkGroups::refit(const PlacedRobot& robot) {
  if (!std::all_of(links_.begin(), links_.end(), [&](int link) { return robot.isPlaced(link); })) return false;
  tree_.refit([&](int link) { return robot.boxAround(link); });
  rounding_ = kPoseRounding * tree_[0].box.diagonal().norm();
  return true;
}

double LinkGroups::gap(int a, int b) const {
  const double distance = tree_[a].box.exteriorDistance(tree_[b].box);
  return distance > 0.0 ? distance - rounding_ - largest_padding_ : -kInfinity;
}

int LinkGroups::candidate(int link_a, int link_b) const {
  PROXIMITY_ASSERT(narrowphase::isPlace(link_a, link_count_) && narrowphase::isPlace(link_b, link_count_),
                   "One of the two is no link: only leaves of the tree have links.");
  const auto [a, b] = std::minmax(link_a, link_b);
  return candidates_[static_cast<std::size_t>(a) * link_count_ + static_cast<std::size_t>(b)];
}

}  // namespace proximity_server::scene
