#include "proximity_server/scene/motion/spline_delays.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {
namespace {

/// A delay of 0.1 s counts as much as an error of 1 mrad, so that noise at rest is not taken for a delay.
constexpr double kPriceOfDelay = 0.01;

double square(double x) { return x * x; }

}  // namespace

SplineDelays::SplineDelays(double least, double agreed_since) : agreed_since_(agreed_since) {
  bounds_ = (Cells{1} << kCells) - 1;
  for (int i = 0; delayOf(i + 1) < least + 0.5 * kStep; ++i) bounds_ &= ~(Cells{1} << i);
  possible_ = agreed_ = bounds_;
}

void SplineDelays::observe(double time, const std::vector<MeasuredJoint>& joints,
                           const std::function<double(std::size_t joint, double delay)>& position_at) {
  samples_.resize(joints.size() * (kCells + 1));
  for (std::size_t joint = 0; joint < joints.size(); ++joint)
    for (int i = 0; i <= kCells; ++i) samples_[joint * (kCells + 1) + i] = position_at(joint, delayOf(i));
  const bool did_fit = fits();
  const bool is_after_gap = time - time_ > kLongestGap;  // not at the first state
  time_ = time;
  const Cells now = bounds_ & fitting(joints);
  const bool agree = (possible_ & now) != 0;
  possible_ = agree ? possible_ & now : now;
  if (now == 0) {
    possible_ = agreed_ = bounds_;
    agreed_since_ = std::numeric_limits<double>::infinity();
    if (did_fit) left_ = time;
  } else {
    last_fit_ = time;
    const Cells alike = possible_ & agreeing(joints);
    agreed_since_ = agree && !is_after_gap && (agreed_ & alike) != 0 ? std::min(agreed_since_, time) : time;
    agreed_ = agreed_since_ < time ? agreed_ & alike : alike;
  }
  findBest(joints);
}

SplineDelays::Cells SplineDelays::fitting(const std::vector<MeasuredJoint>& joints) const {
  Cells cells = bounds_;
  for (std::size_t joint = 0; joint < joints.size(); ++joint) {
    const double *samples = samplesOf(joint), error = joints[joint].position_error;
    for (int i = 0; i < kCells; ++i) {
      const auto [lowest, highest] = std::minmax(samples[i], samples[i + 1]);
      const double position = joints[joint].position;
      if (!(position >= lowest - error && position <= highest + error)) cells &= ~(Cells{1} << i);
    }
  }
  return cells;
}

/// The cells in which the velocities fit. That of a spline is its mean over a cell.
SplineDelays::Cells SplineDelays::agreeing(const std::vector<MeasuredJoint>& joints) const {
  Cells cells = bounds_;
  for (std::size_t joint = 0; joint < joints.size(); ++joint) {
    const double* samples = samplesOf(joint);
    const double later = std::clamp(joints[joint].velocity_later / kStep, -1.0 * kCells, 1.0 * kCells);
    const int shift = static_cast<int>(std::lround(later));
    for (int i = 0; i < kCells; ++i) {
      const int then = std::clamp(i - shift, 0, kCells - 1);
      const double velocity = (samples[then] - samples[then + 1]) / kStep;
      if (!(std::abs(joints[joint].velocity - velocity) <= joints[joint].velocity_error)) cells &= ~(Cells{1} << i);
    }
  }
  return cells;
}

void SplineDelays::findBest(const std::vector<MeasuredJoint>& joints) {
  Fit best{0, 0.0, std::numeric_limits<double>::infinity()};
  for (int i = 0; i < kCells; ++i) {
    if ((possible_ >> i & 1U) == 0) continue;
    const Fit fit = bestIn(i, joints);
    if (fit.price < best.price) best = fit;
  }
  best_ = delayOf(best.cell) + best.place * kStep;
  double excess = -std::numeric_limits<double>::infinity();
  for (std::size_t joint = 0; joint < joints.size(); ++joint) {
    const double off = std::abs(joints[joint].position - positionAt(joint, best));
    if (!(off - joints[joint].position_error > excess)) continue;
    excess = off - joints[joint].position_error;
    farthest_joint_ = static_cast<int>(joint);
    farthest_ = off;
  }
}

/// On a cell the spline is taken for a straight line, so that the least squares have a formula.
SplineDelays::Fit SplineDelays::bestIn(int cell, const std::vector<MeasuredJoint>& joints) const {
  double along = -square(kPriceOfDelay) * delayOf(cell) * kStep, squares = square(kPriceOfDelay * kStep);
  for (std::size_t joint = 0; joint < joints.size(); ++joint) {
    const double* samples = samplesOf(joint) + cell;
    along += (joints[joint].position - samples[0]) * (samples[1] - samples[0]);
    squares += square(samples[1] - samples[0]);
  }
  Fit fit{cell, std::clamp(along / squares, 0.0, 1.0), 0.0};
  fit.price = square(kPriceOfDelay * (delayOf(cell) + fit.place * kStep));
  for (std::size_t joint = 0; joint < joints.size(); ++joint)
    fit.price += square(joints[joint].position - positionAt(joint, fit));
  return fit;
}

double SplineDelays::positionAt(std::size_t joint, const Fit& fit) const {
  const double* samples = samplesOf(joint) + fit.cell;
  return samples[0] + fit.place * (samples[1] - samples[0]);
}

double SplineDelays::least() const {
  int i = 0;
  while ((possible_ >> i & 1U) == 0) ++i;
  return delayOf(i);
}

double SplineDelays::most() const {
  int i = kCells;
  while ((possible_ >> (i - 1) & 1U) == 0) --i;
  return delayOf(i);
}

}  // namespace proximity_server::scene
