#include "scene/filter/link_table.h"

#include <stdexcept>

namespace proximity_server::scene {

LinkTable::LinkTable(const RobotModel& model) : model_(model) {
  for (const Link& link : model.links) {
    index_.emplace(link.name, static_cast<int>(names_.size()));
    names_.push_back(link.name);
    has_geometry_.push_back(model.hasGeometry(static_cast<int>(has_geometry_.size())));
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

bool LinkTable::adjacentButForEmptyLinks(const OrderedPair& pair) const {
  const auto path = model_.connection(pair.link_a, pair.link_b);
  return path && path->movable_joints > 1 && !path->passes_geometry;
}

void addPairsWarning(const std::string& what, const std::vector<std::string>& pairs, PairTable& table) {
  if (pairs.empty()) return;
  std::string names;
  for (const std::string& pair : pairs) names += (names.empty() ? "" : ", ") + pair;
  table.warnings.push_back(what + " (" + std::to_string(pairs.size()) + "): " + names + ".");
}

OrderedPair PairListReader::require(const std::pair<std::string, std::string>& names) {
  ++entries_;
  return recorded({links_.require(names.first, list_), links_.require(names.second, list_)}, names);
}

std::optional<OrderedPair> PairListReader::find(const std::pair<std::string, std::string>& names) {
  ++entries_;
  const int a = links_.find(names.first), b = links_.find(names.second);
  if (a < 0) unknown_.insert(names.first);
  if (b < 0) unknown_.insert(names.second);
  if (a >= 0 && b >= 0) return recorded({a, b}, names);
  addIdle(names, IdleEntry::Cause::UnknownLink);
  return std::nullopt;
}

/// Each entry counts once, under the first cause that makes it useless.
OrderedPair PairListReader::recorded(const OrderedPair& pair, const std::pair<std::string, std::string>& names) {
  if (!links_.hasGeometry(pair.link_a) || !links_.hasGeometry(pair.link_b)) {
    addIdle(names, IdleEntry::Cause::NoGeometry);
  } else if (links_.sameBody(pair)) {
    addIdle(names, IdleEntry::Cause::SameBody);
  } else if (!seen_.insert(pair).second) {
    addIdle(names, IdleEntry::Cause::Repeated);
  }
  return pair;
}

void PairListReader::addIdle(const std::pair<std::string, std::string>& names, IdleEntry::Cause cause) {
  idle_.push_back({list_, names.first, names.second, cause});
}

void PairListReader::report(PairTable& table) const {
  std::vector<std::string> counts;
  using Cause = IdleEntry::Cause;
  for (const Cause cause : {Cause::UnknownLink, Cause::NoGeometry, Cause::SameBody, Cause::Repeated}) {
    const auto count =
        std::count_if(idle_.begin(), idle_.end(), [&](const IdleEntry& entry) { return entry.cause == cause; });
    const bool is_only = count == static_cast<std::ptrdiff_t>(idle_.size());
    if (count > 0) counts.push_back(std::string(toString(cause)) + (is_only ? "" : " (" + std::to_string(count) + ")"));
  }
  if (!counts.empty()) {
    table.warnings.push_back(list_ + ": " + std::to_string(idle_.size()) + " of " + std::to_string(entries_) +
                             " entries " + (idle_.size() == 1 ? "has" : "have") + " no effect: " + listed(counts) +
                             ".");
  }
  std::vector<std::string> names;
  for (const std::string& name : unknown_) names.push_back(names.size() < kMaxListed ? links_.unknown(name) : name);
  if (!names.empty()) table.warnings.push_back(list_ + ": no link " + listed(names) + ".");
  table.idle.insert(table.idle.end(), idle_.begin(), idle_.end());
}

}  // namespace proximity_server::scene
