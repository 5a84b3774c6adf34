#pragma once

#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/model/robot_model.h"
#include "proximity_server/scene/scene_model/pair_table.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// A pair of links in the order of their indices, so that a list of names may have them in either order.
struct OrderedPair {
  OrderedPair(int a, int b) : link_a(std::min(a, b)), link_b(std::max(a, b)) {}
  bool operator<(const OrderedPair& other) const {
    return link_a != other.link_a ? link_a < other.link_a : link_b < other.link_b;
  }
  int link_a, link_b;
};

/// The links of a robot, with the look-ups of the pair filter.
class LinkTable {
 public:
  explicit LinkTable(const RobotModel& model);

  int size() const { return static_cast<int>(names_.size()); }
  std::string names(const OrderedPair& pair) const { return names_[pair.link_a] + " - " + names_[pair.link_b]; }
  std::string unknown(const std::string& name) const { return unknownName(name, names_); }

  /// The index of a link, or -1.
  int find(const std::string& name) const;
  /// Throws std::invalid_argument, with the name of the list, if there is no such link.
  int require(const std::string& name, const std::string& list) const;

  int body(int link) const { return model_.links[link].body; }
  bool hasGeometry(int link) const { return has_geometry_[link]; }
  bool sameBody(const OrderedPair& pair) const { return body(pair.link_a) == body(pair.link_b); }
  bool sameRobot(const OrderedPair& pair) const {
    return model_.bodies[body(pair.link_a)].robot == model_.bodies[body(pair.link_b)].robot;
  }
  bool adjacent(const OrderedPair& pair) const { return model_.areNeighbours(pair.link_a, pair.link_b); }
  /// True if the two are joined by several movable joints, with only links without geometry between them.
  bool adjacentButForEmptyLinks(const OrderedPair& pair) const;

 private:
  const RobotModel& model_;
  std::vector<std::string> names_;
  std::map<std::string, int> index_;
  std::vector<bool> has_geometry_;
};

/// Adds the warning "what (2): a - b, c - d.", with all pairs by name. Does nothing if there are none.
void addPairsWarning(const std::string& what, const std::vector<std::string>& pairs, PairTable& table);

/// Looks up the pairs of one list of names, and collects the entries that have no effect.
class PairListReader {
 public:
  PairListReader(std::string list, const LinkTable& links) : list_(std::move(list)), links_(links) {}

  /// For lists in which an unknown link is an error: throws std::invalid_argument.
  OrderedPair require(const std::pair<std::string, std::string>& names);

  /// For lists in which an unknown link is a warning: returns nullopt for it.
  std::optional<OrderedPair> find(const std::pair<std::string, std::string>& names);

  /// Adds warnings: one sentence for all entries without effect, and one for all unknown names.
  void report(PairTable& table) const;

 private:
  OrderedPair recorded(const OrderedPair& pair, const std::pair<std::string, std::string>& names);
  void addIdle(const std::pair<std::string, std::string>& names, IdleEntry::Cause cause);

  std::string list_;
  const LinkTable& links_;
  std::set<OrderedPair> seen_;
  std::set<std::string> unknown_;
  std::vector<IdleEntry> idle_;
  int entries_ = 0;
};

}  // namespace proximity_server::scene
