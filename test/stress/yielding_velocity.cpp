#include "stress/yielding_velocity.h"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace proximity_server::scene {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kSlack = 0.02;     // [m/rad, m/m]
constexpr double kFeasible = 1e-8;  // [m/s]

/// min |E u - f|, u >= 0. Source: Lawson, Hanson, Solving Least Squares Problems, 1974, algorithm NNLS.
class NonNegativeLeastSquares {
 public:
  NonNegativeLeastSquares(const MatrixXd& equations, const VectorXd& right)
      : equations_(equations), right_(right), solution_(VectorXd::Zero(equations.cols())) {}

  std::optional<VectorXd> solve() {
    const auto most = 10 * equations_.cols() + 50;
    for (Eigen::Index turn = 0; turn < most; ++turn) {
      const int next = mostHelpful();
      if (next < 0) return solution_;
      positive_.push_back(next);
      while (!step()) {
      }
    }
    return std::nullopt;
  }

 private:
  /// The column that reduces the residual most; -1 if none does.
  int mostHelpful() const {
    const VectorXd gains = equations_.transpose() * (right_ - equations_ * solution_);
    int best = -1;
    double most = 1e-11;
    for (int i = 0; i < static_cast<int>(gains.size()); ++i) {
      const double gain = gains[i] / equations_.col(i).norm();
      if (!(gain > most) || std::find(positive_.begin(), positive_.end(), i) != positive_.end()) continue;
      most = gain;
      best = i;
    }
    return best;
  }

  /// Goes to the least squares of the positive columns, or as far as all stay positive; whether it got there.
  bool step() {
    MatrixXd columns(equations_.rows(), static_cast<Eigen::Index>(positive_.size()));
    for (std::size_t i = 0; i < positive_.size(); ++i)
      columns.col(static_cast<Eigen::Index>(i)) = equations_.col(positive_[i]);
    const VectorXd wanted = columns.householderQr().solve(right_);
    double share = 1.0;
    for (std::size_t i = 0; i < positive_.size(); ++i) {
      const double now = solution_[positive_[i]], then = wanted[static_cast<Eigen::Index>(i)];
      if (!(then > 0.0)) share = std::min(share, now > then ? now / (now - then) : 0.0);
    }
    for (std::size_t i = 0; i < positive_.size(); ++i)
      solution_[positive_[i]] += share * (wanted[static_cast<Eigen::Index>(i)] - solution_[positive_[i]]);
    if (share == 1.0) return true;
    const auto is_zero = [&](int i) {
      if (solution_[i] > std::numeric_limits<double>::epsilon()) return false;
      solution_[i] = 0.0;
      return true;
    };
    positive_.erase(std::remove_if(positive_.begin(), positive_.end(), is_zero), positive_.end());
    return positive_.empty();
  }

  const MatrixXd& equations_;
  const VectorXd& right_;
  VectorXd solution_;
  std::vector<int> positive_;
};

}  // namespace

std::optional<YieldingVelocity> yieldingVelocity(const VelocityProgram& program) {
  const Eigen::Index joints = program.wanted.size(), rows = program.lower_bounds.size();
  std::vector<Eigen::Index> used, parting;
  for (Eigen::Index i = 0; i < rows; ++i) {
    if (program.lower_bounds[i] == -std::numeric_limits<double>::infinity()) continue;
    used.push_back(i);
    if (program.lower_bounds[i] > 0.0) parting.push_back(i);
  }
  const auto slacks = static_cast<Eigen::Index>(parting.size()), hard = static_cast<Eigen::Index>(used.size());
  const Eigen::Index all = hard + slacks + 2 * joints;
  MatrixXd matrix = MatrixXd::Zero(all, joints + slacks);
  VectorXd bounds(all);
  for (Eigen::Index i = 0; i < hard; ++i) {
    matrix.row(i).head(joints) = program.matrix.row(used[i]);
    bounds[i] = std::min(program.lower_bounds[used[i]], 0.0);
  }
  for (Eigen::Index i = 0; i < slacks; ++i) {
    matrix.row(hard + i).head(joints) = program.matrix.row(parting[i]);
    matrix(hard + i, joints + i) = kSlack;
    bounds[hard + i] = program.lower_bounds[parting[i]];
  }
  matrix.block(hard + slacks, 0, joints, joints).setIdentity();
  matrix.block(hard + slacks + joints, 0, joints, joints) = -MatrixXd::Identity(joints, joints);
  bounds.segment(hard + slacks, joints) = program.lower;
  bounds.tail(joints) = -program.upper;

  VectorXd wanted = VectorXd::Zero(joints + slacks);
  wanted.head(joints) = program.wanted;
  MatrixXd equations(joints + slacks + 1, all);
  std::vector<Eigen::Index> counts;
  bool is_kept = true;
  for (Eigen::Index i = 0; i < all; ++i) {
    if (!std::isfinite(bounds[i])) continue;  // a joint without a limit
    const auto column = static_cast<Eigen::Index>(counts.size());
    const double missing = bounds[i] - matrix.row(i).dot(wanted);
    equations.col(column).head(joints + slacks) = matrix.row(i).transpose();
    equations(joints + slacks, column) = missing;
    is_kept = is_kept && !(missing > 0.0);
    counts.push_back(i);
  }
  YieldingVelocity result{program.wanted, VectorXd::Zero(rows)};
  if (is_kept) return result;
  equations.conservativeResize(Eigen::NoChange, static_cast<Eigen::Index>(counts.size()));
  const VectorXd right = VectorXd::Unit(joints + slacks + 1, joints + slacks);
  const std::optional<VectorXd> multipliers = NonNegativeLeastSquares(equations, right).solve();
  if (!multipliers) return std::nullopt;
  const VectorXd residual = equations * *multipliers - right;
  if (!(residual[joints + slacks] < 0.0)) return std::nullopt;
  const VectorXd velocity = wanted - residual.head(joints + slacks) / residual[joints + slacks];
  for (std::size_t k = 0; k < counts.size(); ++k) {
    const Eigen::Index i = counts[k];
    if (!(bounds[i] - matrix.row(i).dot(velocity) <= kFeasible)) return std::nullopt;
    const double push = -(*multipliers)[static_cast<Eigen::Index>(k)] / residual[joints + slacks];
    if (i < hard) result.pushes[used[i]] += push;
    if (i >= hard && i < hard + slacks) result.pushes[parting[i - hard]] += push;
  }
  result.velocity = velocity.head(joints);
  return result;
}

}  // namespace proximity_server::scene
