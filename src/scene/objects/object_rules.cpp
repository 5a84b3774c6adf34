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
  rules_[inOrder(name_a, name_b)] = rule;
}

void AllowedPairs::forget(const std::string& name_a, const std::string& name_b) {
  rules_.erase(inOrder(name_a, name_b));
}

const AllowedPairs::Rule* AllowedPairs::find(const std::string& name_a, const std::string& name_b) const {
  const auto found = rules_.find(inOrder(name_a, name_b));
  return found == rules_.end() ? nullptr : &found->second;
}

AllowedPairs::Rule AllowedPairs::of(const std::string& name_a, const std::string& name_b) const {
  if (rules_.empty()) return Rule::Checked;
  if (const Rule* own = find(name_a, name_b)) return *own;
  const Rule *of_a = find(name_a, kAll), *of_b = find(name_b, kAll);
  if (of_a && of_b) return std::max(*of_a, *of_b);
  if (of_a || of_b) return of_a ? *of_a : *of_b;
  const Rule* of_all = find(kAll, kAll);
  return of_all ? *of_all : Rule::Checked;
}

}  // namespace proximity_server::scene
