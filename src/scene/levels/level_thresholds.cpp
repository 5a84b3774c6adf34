#include "proximity_server/scene/levels/level_thresholds.h"

#include "scene/filter/link_table.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

/// The rules for one threshold by index of link. Their lists are called pair_NAME, link_NAME and group_NAME.
class RulesByIndex {
 public:
  RulesByIndex(const RobotModel& model, const std::vector<std::string>& srdf_xmls, const DistanceRules& rules,
               const std::string& name)
      : links_(model), of_links_(model.links.size()), of_groups_(model.links.size()) {
    const auto usable = [](const std::string& list, double distance) {
      if (!(distance >= 0.0) || !std::isfinite(distance))
        throw std::invalid_argument(list + " is " + shortest(distance) + ", but must not be negative");
      return distance;
    };
    for (const auto& [names, distance] : rules.of_pairs) {
      const std::string list = "pair_" + name;
      const int a = requireGeometry(names.first, list), b = requireGeometry(names.second, list);
      if (links_.sameBody({a, b}))
        throw std::invalid_argument(list + ": " + links_.names({a, b}) +
                                    " are of one rigid body, which is not checked");
      keepLarger(of_pairs_[{a, b}], usable(list + " of " + links_.names({a, b}), distance));
    }
    for (const auto& [link, distance] : rules.of_links) {
      const int index = requireGeometry(link, "link_" + name);
      keepLarger(of_links_[index], usable("link_" + name + "/" + link, distance));
    }
    for (const auto& [group, distance] : rules.of_groups) {
      const std::vector<bool> moves = bodiesMovedBy(model, srdf_xmls, group, "group_" + name);
      for (std::size_t link = 0; link < model.links.size(); ++link)
        if (moves[model.links[link].body])
          keepLarger(of_groups_[link], usable("group_" + name + "/" + group, distance));
    }
  }

  /// Returns the distance of two links, or of a link with objects (link_b < 0). Returns nullopt if the default counts.
  std::optional<double> of(int link_a, int link_b) const {
    if (link_b >= 0) {
      const auto own = of_pairs_.find({link_a, link_b});
      if (own != of_pairs_.end()) return own->second;
    }
    for (const auto* list : {&of_links_, &of_groups_}) {
      std::optional<double> larger = (*list)[link_a];
      if (link_b >= 0) larger = std::max(larger, (*list)[link_b]);  // nullopt is smaller than any number
      if (larger) return larger;
    }
    return std::nullopt;
  }

 private:
  static void keepLarger(std::optional<double>& known, double distance) { known = std::max(known, {distance}); }

  int requireGeometry(const std::string& link, const std::string& list) const {
    const int index = links_.require(link, list);
    if (!links_.hasGeometry(index))
      throw std::invalid_argument(list + ": the link " + quoted(link) + " has no collision geometry");
    return index;
  }

  const LinkTable links_;
  std::map<OrderedPair, std::optional<double>> of_pairs_;
  std::vector<std::optional<double>> of_links_, of_groups_;
};

PairDistances distances(const RobotModel& model, const RulesByIndex& rules, const PairDistances& defaults) {
  PairDistances distances(defaults.links, defaults.objects);
  const int size = static_cast<int>(model.links.size());
  for (int a = 0; a < size; ++a) {
    if (!model.hasGeometry(a)) continue;
    if (const auto own = rules.of(a, -1)) distances.setWithObjects(a, *own);
    for (int b = a + 1; b < size; ++b)
      if (const auto own = model.hasGeometry(b) ? rules.of(a, b) : std::nullopt) distances.setPair(a, b, *own);
  }
  return distances;
}

void requireOrder(const std::string& who, double stop, double warn) {
  if (stop > warn)
    throw std::invalid_argument("the stop distance of " + who + " is " + shortest(stop) +
                                ", above its warn distance, which is " + shortest(warn) +
                                ": the level WARN comes before STOP");
}

}  // namespace

LevelThresholds levelThresholds(const RobotModel& model, const std::vector<std::string>& srdf_xmls,
                                const ThresholdRules& rules, const LevelThresholds& defaults) {
  const LevelThresholds thresholds{distances(model, {model, srdf_xmls, rules.stop, "stop_distance"}, defaults.stop),
                                   distances(model, {model, srdf_xmls, rules.warn, "warn_distance"}, defaults.warn)};
  requireOrder(model, thresholds);
  return thresholds;
}

void requireOrder(const RobotModel& model, const LevelThresholds& thresholds) {
  requireOrder("two links", thresholds.stop.links, thresholds.warn.links);
  requireOrder("pairs with objects", thresholds.stop.objects, thresholds.warn.objects);
  const int size = static_cast<int>(model.links.size());
  for (int a = 0; a < size; ++a) {
    const std::string& name = model.links[a].name;
    const ShapeRefPair with_object{{a}, ShapeRef::ofObject(0)};
    requireOrder(name + " and objects", thresholds.stop.of(with_object), thresholds.warn.of(with_object));
    for (int b = a + 1; b < size; ++b)
      requireOrder(name + " - " + model.links[b].name, thresholds.stop.of({{a}, {b}}), thresholds.warn.of({{a}, {b}}));
  }
}

}  // namespace proximity_server::scene
