#include "proximity_server/scene/model/joint_inequality.h"

#include "proximity_server/scene/model/names.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

namespace proximity_server::scene {

double JointInequality::excess(const std::vector<double>& positions) const {
  double sum = -bound;
  for (const Term& term : terms) sum += term.coefficient * positions[term.joint];
  return sum;
}

double JointInequality::weight() const {
  double sum = 0.0;
  for (const Term& term : terms) sum += std::abs(term.coefficient);
  return sum;
}

std::string JointInequality::brokenText(double excess) const {
  return "'" + text + "' is broken by " + shortest(std::round(excess * 1e6) / 1e6);
}

const JointInequality* mostBroken(const std::vector<JointInequality>& inequalities,
                                  const std::vector<double>& positions) {
  const JointInequality* most = nullptr;
  double largest = 1.0;
  for (const JointInequality& inequality : inequalities) {
    const double tolerances = inequality.excess(positions) / inequality.tolerance();
    if (!(tolerances > largest)) continue;
    most = &inequality;
    largest = tolerances;
  }
  return most;
}

void drawWithin(const std::vector<JointInequality>& inequalities, const std::vector<double>& positions,
                const std::function<void(std::uint32_t)>& draw) {
  std::vector<std::uint32_t> refused(inequalities.size(), 0);
  for (std::uint32_t n = 0; n < kMostDraws; ++n) {
    draw(n);
    const JointInequality* const broken = mostBroken(inequalities, positions);
    if (!broken) return;
    ++refused[static_cast<std::size_t>(broken - inequalities.data())];
  }
  const auto most = std::max_element(refused.begin(), refused.end());
  throw std::invalid_argument("none of " + std::to_string(kMostDraws) +
                              " random states obeys the joint inequalities; '" +
                              inequalities[static_cast<std::size_t>(most - refused.begin())].text + "' refuses most");
}

}  // namespace proximity_server::scene
