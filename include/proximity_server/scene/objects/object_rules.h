#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// The rules that tell which pairs with an object may touch. The names of links and objects need not exist:
/// an object may be added later. Pairs of two links are decided by the pair filter alone.
///
/// Three kinds of rules apply to a pair: for both of its names, for one of them and all others ("*"), and for all pairs
/// ("*" and "*"). Among these, the rule that was set last decides. Without any rule a pair is checked. The allowed
/// collision matrix of MoveIt is such a list: first the names whose default allows, then those whose default forbids,
/// then the entries of two names.
class AllowedPairs {
 public:
  enum class Rule : unsigned char { Allowed, Checked };

  /// Sets the rule of a pair, in either order. "*" stands for all others.
  /// Throws std::invalid_argument for an empty name.
  void set(const std::string& name_a, const std::string& name_b, Rule rule);

  bool empty() const { return rules_.empty(); }

  Rule of(const std::string& name_a, const std::string& name_b) const;

 private:
  struct Entry {
    int number = 0;  ///< counts up with every rule that is set
    Rule rule = Rule::Checked;
  };
  const Entry& find(const std::string& name_a, const std::string& name_b) const;

  std::map<std::pair<std::string, std::string>, Entry> rules_;  ///< the two names in alphabetical order
  int set_ = 0;                                                 ///< the number of rules that were set
};

/// The rules that decide which pairs with objects are checked.
struct ObjectRules {
  AllowedPairs allowed;

  /// Pairs of two objects that are not attached, if one of them moves.
  enum class FreeObjects : unsigned char { NotChecked, Checked };
  FreeObjects free_objects = FreeObjects::NotChecked;

  /// Tells whether the root link of the robot stands still in the world. If it does, its body is not checked against
  /// fixed objects.
  enum class Base : unsigned char { MayMove, StandsStill };
  Base base = Base::MayMove;
};

}  // namespace proximity_server::scene
