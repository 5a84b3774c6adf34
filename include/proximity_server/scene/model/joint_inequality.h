#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace proximity_server::scene {

/// A limit that couples joints, as a cable or a differential does: the sum of coefficient * position over the terms is
/// at most `bound`. Positions are in [rad] or [m].
struct JointInequality {
  struct Term {
    int joint;  ///< index into RobotModel::joints; never a mimic joint
    double coefficient;
  };
  std::string text;         ///< as it was written: "2*j1 - j2 <= 1.7"
  std::vector<Term> terms;  ///< each joint once; no coefficient is 0
  double bound;

  /// By how much the sum is above the bound. `positions` has one for each of RobotModel::joints.
  double excess(const std::vector<double>& positions) const;

  /// The sum of the absolute values of the coefficients.
  double weight() const;

  /// An inequality is broken if its excess is above this. It is what positions that are off by kRounding can cause, and
  /// far above the rounding of the sum.
  double tolerance() const { return kRounding * weight(); }
  static constexpr double kRounding = 1e-6;  ///< [rad] or [m] positions may be written with six decimals

  /// A text like: '2*j1 - j2 <= 1.7' is broken by 0.2
  std::string brokenText(double excess) const;
};

/// The inequality that positions break by the most tolerances; nullptr if they break none.
const JointInequality* mostBroken(const std::vector<JointInequality>& inequalities,
                                  const std::vector<double>& positions);

/// Calls draw(0), draw(1) and so on, which set `positions`, until these break no inequality.
/// Failure: throws std::invalid_argument after kMostDraws, and names the inequality that refuses most of them.
void drawWithin(const std::vector<JointInequality>& inequalities, const std::vector<double>& positions,
                const std::function<void(std::uint32_t)>& draw);
constexpr std::uint32_t kMostDraws = 1'000'000;

}  // namespace proximity_server::scene
