#include "scene/inequalities/inequality_text.h"

#include "proximity_server/scene/model/names.h"
#include "system/number_text.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>
#include <string_view>

namespace proximity_server::scene {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr int kDeepest = 20;  // brackets and signs

/// A linear function of the positions of joints.
struct Sum {
  std::map<int, double> coefficients;  ///< by index of the joint
  double constant = 0.0;

  bool isNumber() const { return coefficients.empty(); }
  void add(const Sum& other, double factor) {
    for (const auto& [joint, coefficient] : other.coefficients) coefficients[joint] += factor * coefficient;
    constant += factor * other.constant;
  }
};

[[noreturn]] void refuse(const std::string& reason) { throw std::invalid_argument(reason); }

bool isOfNumber(char c) { return std::isdigit(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '+'; }
bool isOfName(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '/'; }

/// Reads a text by recursive descent: sums of products of numbers, joints and brackets.
class Reader {
 public:
  Reader(std::string_view text, const RobotModel& robot) : rest_(text), robot_(robot) {}

  Sum sum() {
    Sum whole;
    for (double sign = 1.0;;) {
      whole.add(product(), sign);
      if (take("+"))
        sign = 1.0;
      else if (take("-"))
        sign = -1.0;
      else
        return whole;
    }
  }

  /// The comparison that follows, "<=" or ">="; "" at the end.
  std::string comparison() {
    for (const char* const known : {"<=", ">="})
      if (take(known)) return known;
    if (!rest_.empty()) refuse("expected +, -, *, <= or >= before '" + std::string(rest_) + "'");
    return "";
  }

 private:
  void skipBlanks() {
    while (!rest_.empty() && std::isspace(static_cast<unsigned char>(rest_.front()))) rest_.remove_prefix(1);
  }

  bool take(std::string_view token) {
    skipBlanks();
    if (rest_.substr(0, token.size()) != token) return false;
    rest_.remove_prefix(token.size());
    skipBlanks();
    return true;
  }

  Sum product() {
    Sum whole = factor();
    while (take("*")) {
      const Sum other = factor();
      if (!whole.isNumber() && !other.isNumber()) refuse("a product of joints is not linear");
      Sum scaled;
      whole.isNumber() ? scaled.add(other, whole.constant) : scaled.add(whole, other.constant);
      whole = scaled;
    }
    return whole;
  }

  Sum factor() {
    const bool is_negative = take("-");
    if (!is_negative && !take("(")) return operand();
    if (++depth_ > kDeepest) refuse("brackets and signs are nested more than " + std::to_string(kDeepest) + " deep");
    Sum inner;
    inner.add(is_negative ? factor() : sum(), is_negative ? -1.0 : 1.0);
    if (!is_negative && !take(")")) refuse("a bracket is not closed");
    --depth_;
    return inner;
  }

  Sum operand() {
    if (const std::optional<Sum> joint = knownJoint()) return *joint;
    if (!rest_.empty() && isOfNumber(rest_.front()) && rest_.front() != '+') return number();
    const auto end = std::find_if_not(rest_.begin(), rest_.end(), isOfName);
    const std::string name(rest_.begin(), end);
    if (name.empty())
      refuse("expected a number or a joint " + (rest_.empty() ? "at the end" : "before '" + std::string(rest_) + "'"));
    refuse("there is no joint " + unknownName(name, namesOf(robot_.joints)));
  }

  /// Takes the longest name of a joint that the text continues with.
  std::optional<Sum> knownJoint() {
    const auto begins = [&](const std::string& name) {
      return rest_.substr(0, name.size()) == name && (rest_.size() == name.size() || !isOfName(rest_[name.size()]));
    };
    for (const std::string& fixed : robot_.fixed_joints)
      if (begins(fixed)) refuse("joint " + quoted(fixed) + " is fixed");
    int best = -1;
    for (int i = 0; i < static_cast<int>(robot_.joints.size()); ++i) {
      const std::string& name = robot_.joints[i].name;
      if (begins(name) && (best < 0 || name.size() > robot_.joints[best].name.size())) best = i;
    }
    if (best < 0) return std::nullopt;
    const Joint& joint = robot_.joints[best];
    if (!hasOnePosition(joint))
      refuse("joint " + quoted(joint.name) + " is floating or planar, it has not one position");
    rest_.remove_prefix(joint.name.size());
    const Joint::Mimic leader = robot_.leaderOf(best);
    return Sum{{{leader.joint, leader.multiplier}}, leader.offset};
  }

  /// Takes the longest number that the text continues with.
  Sum number() {
    const auto end = std::find_if_not(rest_.begin(), rest_.end(), [](char c) { return isOfName(c) || isOfNumber(c); });
    std::string_view text = rest_.substr(0, static_cast<std::size_t>(end - rest_.begin()));
    std::optional<double> value;
    while (!text.empty() && !(value = system::numberIn<double>(text))) text.remove_suffix(1);
    if (!value || !std::isfinite(*value)) refuse("'" + std::string(rest_) + "' begins with no finite number");
    rest_.remove_prefix(text.size());
    return {{}, take("deg") ? *value * kDegree : *value};
  }

  std::string_view rest_;
  const RobotModel& robot_;
  int depth_ = 0;
};

/// lower <= upper
JointInequality inequalityOf(const std::string& text, const Sum& lower, const Sum& upper) {
  Sum difference = lower;
  difference.add(upper, -1.0);
  JointInequality inequality{text, {}, -difference.constant};
  for (const auto& [joint, coefficient] : difference.coefficients)
    if (coefficient != 0.0) inequality.terms.push_back({joint, coefficient});
  if (inequality.terms.empty()) refuse("no joint is left in it");
  if (!std::isfinite(inequality.weight()) || !std::isfinite(inequality.bound)) refuse("its numbers are too large");
  return inequality;
}

}  // namespace

std::vector<JointInequality> inequalitiesOf(const std::string& text, const RobotModel& robot) {
  Reader reader(text, robot);
  std::vector<JointInequality> inequalities;
  std::string direction;
  for (Sum left = reader.sum();;) {
    const std::string comparison = reader.comparison();
    if (comparison.empty()) break;
    if (inequalities.size() == 2) refuse("it has more than two comparisons");
    if (!direction.empty() && comparison != direction) refuse("its two comparisons are not in the same direction");
    direction = comparison;
    const Sum right = reader.sum();
    inequalities.push_back(direction == "<=" ? inequalityOf(text, left, right) : inequalityOf(text, right, left));
    left = right;
  }
  if (inequalities.empty()) refuse("it has no <= or >=");
  return inequalities;
}

}  // namespace proximity_server::scene
