#include "link_table.h"

#include <stdexcept>

namespace proximity_server {

LinkTable::LinkTable(const RobotModel& model) : model_(model) {
  for (const Link& link : model.links) {
    index_.emplace(link.name, static_cast<int>(names_.size()));
    names_.push_back(link.name);
    has_geometry_.push_back(std::any_of(link.collisions.begin(), link.collisions.end(),
                                        [&](int i) { return !model.collisions[i].pieces.empty(); }));
  }
}

int LinkTable::find(const std::string& name) const {
  const auto hit = index_.find(name);
  return hit == index_.end() ? -1 : hit->second;
}

int LinkTable::require(const std::string& name, const std::string& list) const {
  const int link = find(name);
  if (link < 0) throw std::invalid_argument(list + ": no link " + unknown(name));
  return link;
}

bool LinkTable::adjacent(const OrderedPair& pair) const {
  const int a = body(pair.link_a), b = body(pair.link_b);
  return model_.bodies[a].parent == b || model_.bodies[b].parent == a;
}

bool LinkTable::adjacentButForEmptyBodies(const OrderedPair& pair) const {
  const auto solidParent = [&](int body) {
    do {
      body = model_.bodies[body].parent;
    } while (body >= 0 && model_.bodies[body].pieces.empty());
    return body;
  };
  const int a = body(pair.link_a), b = body(pair.link_b);
  return !adjacent(pair) && (solidParent(a) == b || solidParent(b) == a);
}

OrderedPair PairListReader::require(const std::pair<std::string, std::string>& names) {
  ++entries_;
  return counted({links_.require(names.first, list_), links_.require(names.second, list_)});
}

std::optional<OrderedPair> PairListReader::find(const std::pair<std::string, std::string>& names) {
  ++entries_;
  const int a = links_.find(names.first), b = links_.find(names.second);
  if (a < 0) unknown_.insert(names.first);
  if (b < 0) unknown_.insert(names.second);
  if (a >= 0 && b >= 0) return counted({a, b});
  ++without_link_;
  return std::nullopt;
}

/// Each entry counts once, under the first reason that makes it useless.
OrderedPair PairListReader::counted(const OrderedPair& pair) {
  if (!links_.hasGeometry(pair.link_a) || !links_.hasGeometry(pair.link_b)) {
    ++without_geometry_;
  } else if (links_.sameBody(pair)) {
    ++same_body_;
  } else if (!seen_.insert(pair).second) {
    ++repeated_;
  }
  return pair;
}

void PairListReader::report(std::vector<std::string>& warnings) const {
  std::vector<std::string> counts;
  const auto tell = [&](int count, const std::string& what) {
    if (count > 0) counts.push_back(std::to_string(count) + " " + what);
  };
  tell(without_link_, "name a link that does not exist");
  tell(without_geometry_, "a link without collision geometry");
  tell(same_body_, "two links of one rigid body");
  tell(repeated_, "a pair for the second time");
  if (!counts.empty()) {
    warnings.push_back(list_ + ": without effect are, of " + std::to_string(entries_) + ", " + listed(counts) + ".");
  }
  std::vector<std::string> names;
  for (const std::string& name : unknown_) names.push_back(links_.unknown(name));
  if (!names.empty()) warnings.push_back(list_ + ": no link " + listed(names) + ".");
}

}  // namespace proximity_server
