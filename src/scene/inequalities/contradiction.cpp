#include "scene/inequalities/contradiction.h"

#include "scene/mesh/input_limits.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <set>

namespace proximity_server::scene {
namespace {

using Eigen::Index;

constexpr double kZero = 1e-12;  // a smaller coefficient is rounding; the coefficients of the program are about 1
constexpr int kMostSteps = 100'000;

/// A linear program as equations of its basic variables, a row for each: value + row . the others, which are 0. The
/// last row is the objective, which is maximised.
class Dictionary {
 public:
  /// All variables are numbered; at first 0 to variables-1 are 0, and the slack of row i is variables + i.
  Dictionary(Eigen::MatrixXd rows, Index variables)
      : rows_(std::move(rows)), others_(variables), basic_(rows_.rows() - 1) {
    std::iota(others_.begin(), others_.end(), 0);
    std::iota(basic_.begin(), basic_.end(), static_cast<int>(variables));
  }

  double objective() const { return rows_(rows_.rows() - 1, 0); }

  /// The multiplier of a slack in the optimum.
  double multiplier(int slack) const {
    const auto place = std::find(others_.begin(), others_.end(), slack);
    return place == others_.end() ? 0.0 : -rows_(rows_.rows() - 1, 1 + (place - others_.begin()));
  }

  /// Exchanges the basic variable of a row with another one.
  void pivot(Index row, Index other) {
    const double factor = rows_(row, 1 + other);
    rows_(row, 1 + other) = -1.0;
    rows_.row(row) /= -factor;
    for (Index i = 0; i < rows_.rows(); ++i) {
      if (i == row) continue;
      const double own = rows_(i, 1 + other);
      rows_(i, 1 + other) = 0.0;
      rows_.row(i) += own * rows_.row(row);
    }
    std::swap(basic_[row], others_[other]);
  }

  void maximise() {
    for (int step = 0; step < kMostSteps; ++step) {
      const Index entering = best(others_, [&](Index i) { return rows_(rows_.rows() - 1, 1 + i) > kZero ? 0.0 : kNo; });
      if (entering < 0) return;
      const Index leaving = best(basic_, [&](Index i) {
        const double rate = rows_(i, 1 + entering);
        return rate < -kZero ? std::max(0.0, rows_(i, 0)) / -rate : kNo;
      });
      if (leaving < 0) return;  // unbounded, which a program with limits is not
      pivot(leaving, entering);
    }
  }

 private:
  static constexpr double kNo = std::numeric_limits<double>::infinity();

  /// The place of the variable with the smallest cost, and of equal ones that with the smallest number; -1 if all are
  /// kNo.
  template <typename Cost>
  static Index best(const std::vector<int>& variables, const Cost& costOf) {
    Index place = -1;
    double smallest = kNo;
    for (Index i = 0; i < static_cast<Index>(variables.size()); ++i) {
      const double cost = costOf(i);
      if (cost > smallest || cost == kNo || (cost == smallest && variables[i] > variables[place])) continue;
      place = i;
      smallest = cost;
    }
    return place;
  }

  Eigen::MatrixXd rows_;
  std::vector<int> others_, basic_;
};

std::vector<int> jointsOf(const std::vector<JointInequality>& inequalities) {
  std::set<int> joints;
  for (const JointInequality& inequality : inequalities)
    for (const JointInequality::Term& term : inequality.terms) joints.insert(term.joint);
  return {joints.begin(), joints.end()};
}

}  // namespace

std::vector<int> contradiction(const RobotModel& robot) {
  const std::vector<JointInequality>& inequalities = robot.inequalities;
  const std::vector<int> joints = jointsOf(inequalities);
  const auto count = static_cast<Index>(inequalities.size()), width = static_cast<Index>(joints.size());
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(count + width + 1, width + 2);  // columns: value, joints, t
  for (Index j = 0; j < width; ++j) {
    const Joint& joint = robot.joints[joints[j]];
    const double lower = std::max(joint.lower, -kFarthest), upper = std::min(joint.upper, kFarthest);
    rows(count + j, 0) = upper - lower;
    rows(count + j, 1 + j) = -1.0;
    for (Index i = 0; i < count; ++i)
      for (const JointInequality::Term& term : inequalities[i].terms)
        if (term.joint == joints[j]) {
          rows(i, 1 + j) = -term.coefficient / inequalities[i].weight();
          rows(i, 0) += rows(i, 1 + j) * lower;
        }
  }
  for (Index i = 0; i < count; ++i) rows(i, 0) += inequalities[i].bound / inequalities[i].weight();
  rows.col(1 + width).head(count).setOnes();
  rows(count + width, 1 + width) = -1.0;

  Index worst = 0;
  if (count == 0 || rows.col(0).head(count).minCoeff(&worst) >= 0.0) return {};
  Dictionary program(std::move(rows), width + 1);
  program.pivot(worst, width);
  program.maximise();
  std::vector<int> contradicting;
  for (int i = 0; i < count && -program.objective() > JointInequality::kRounding; ++i)
    if (program.multiplier(static_cast<int>(width) + 1 + i) > kZero) contradicting.push_back(i);
  return contradicting;
}

}  // namespace proximity_server::scene
