#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// Which pairs with an object may touch (the allowed collision matrix of MoveIt). Names are those of links and objects,
/// and need not exist: an object may come later. Pairs of two links are decided by the pair filter alone.
///
/// The rule of a pair is the one that names both. Else, of the rules of each of the two with all others ("*"), Checked
/// goes before Allowed. Else the rule of all with all ("*" and "*"). Without any rule a pair is checked.
class AllowedPairs {
 public:
  enum class Rule : unsigned char { Allowed, Checked };

  /// Sets the rule of a pair, in either order. "*" stands for all others.
  /// Throws std::invalid_argument for an empty name.
  void set(const std::string& name_a, const std::string& name_b, Rule rule);

  /// Forgets the rule of a pair, in either order.
  void forget(const std::string& name_a, const std::string& name_b);

  bool empty() const { return rules_.empty(); }

  Rule of(const std::string& name_a, const std::string& name_b) const;

 private:
  const Rule* find(const std::string& name_a, const std::string& name_b) const;

  std::map<std::pair<std::string, std::string>, Rule> rules_;  ///< names in their order
};

/// What is checked beside the objects themselves.
struct ObjectRules {
  AllowedPairs allowed;

  /// Pairs of two objects that are not attached, of which one moves.
  enum class FreeObjects : unsigned char { NotChecked, Checked };
  FreeObjects free_objects = FreeObjects::NotChecked;

  /// Whether the root link of the robot stands still in the world: then its body is not checked against fixed objects.
  enum class Base : unsigned char { MayMove, StandsStill };
  Base base = Base::MayMove;
};

}  // namespace proximity_server::scene
