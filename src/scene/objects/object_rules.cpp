#include "proximity_server/scene/objects/object_rules.h"

#include <algorithm>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

constexpr char kAll[] = "*";

std::pair<std::string, std::string> inOrder(const std::string& a, const std::string& b) {
  return a < b ? std::make_pair(a, b) : std::make_pair(b, a);
}

}  // namespace

void AllowedPairs::set(const std::string& name_a, const std::string& name_b, Rule rule) {
  if (name_a.empty() || name_b.empty()) throw std::invalid_argument("allowed pairs: a name is empty");
  rules_[inOrder(name_a, name_b)] = {++set_, rule};
}

/// The rule for exactly these names; an entry with number 0 if there is none.
const AllowedPairs::Entry& AllowedPairs::find(const std::string& name_a, const std::string& name_b) const {
  static const Entry kNone;
  const auto found = rules_.find(inOrder(name_a, name_b));
  return found == rules_.end() ? kNone : found->second;
}

AllowedPairs::Rule AllowedPairs::of(const std::string& name_a, const std::string& name_b) const {
  if (rules_.empty()) return Rule::Checked;
  const auto isEarlier = [](const Entry& a, const Entry& b) { return a.number < b.number; };
  return std::max({find(name_a, name_b), find(name_a, kAll), find(name_b, kAll), find(kAll, kAll)}, isEarlier).rule;
}

}  // namespace proximity_server::scene
