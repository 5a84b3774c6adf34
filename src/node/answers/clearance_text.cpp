#include "node/answers/clearance_text.h"

#include "node/answers/conversions.h"
#include "node/robot/level_name.h"
#include "system/number_text.h"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace proximity_server::node {
namespace {

/// [s] Positions that are farther apart in time give no velocity.
constexpr double kLongestPause = 1.0;
/// [m/s] A slower motion is not told: positions of encoders are as noisy.
constexpr double kAtRest = 5e-4;
/// A second joint is named if it closes the gap at least half as fast as the first one.
constexpr double kShareOfSecond = 0.5;
constexpr double kTurn = 6.283185307179586;

/// [characters] More than all words and numbers of a text.
constexpr std::size_t kWords = 384;

/// Appends a length [m] in millimetres.
void appendMillimetres(std::string& text, double length) {
  system::appendFixed(text, 1000.0 * length, 1);
  text += " mm";
}

void writeDistance(std::string& text, const Proximity& pair) {
  text += pair.a.link;
  if (pair.state == Proximity::TOUCHING) {
    text += " touches ";
    text += pair.b.link;
  } else if (pair.distance < 0.0) {
    text += " overlaps ";
    text += pair.b.link;
    text += pair.depth_is_lower_bound ? " by at least " : " by ";
    appendMillimetres(text, -pair.distance);
  } else {
    text += " is ";
    appendMillimetres(text, pair.distance);
    text += " from ";
    text += pair.b.link;
  }
}

void writeThreshold(std::string& text, const Clearance& clearance) {
  if (clearance.level == Clearance::COLLISION) return;
  text += "; ";
  for (const char* letter = levelOfThreshold(clearance.level); *letter; ++letter)
    text += static_cast<char>(std::tolower(*letter));
  text += " below ";
  system::appendRounded(text, 1000.0 * clearance.deciding_threshold, 4);
  text += " mm";
}

}  // namespace

void ClearanceText::move(const scene::BodyPoses& poses, const ros::Time& stamp) {
  if (stamp == stamp_) return;  // the same transforms once more
  std::swap(before_, poses_);
  poses_ = poses;
  elapsed_ = before_.empty() ? 0.0 : (stamp - stamp_).toSec();
  stamp_ = stamp;
}

/// [rad/s] or [m/s] NaN if it is not known.
double ClearanceText::velocityOf(const scene::DegreeOfFreedom& column) const {
  if (!(elapsed_ > 0.0 && elapsed_ <= kLongestPause)) return kNaN;
  const scene::Joint& joint = robot_.joints[column.joint];
  double way = jointPositionAt(robot_, joint, poses_) - jointPositionAt(robot_, joint, before_);
  if (column.kind == scene::DegreeOfFreedom::Kind::Rotation) way = std::remainder(way, kTurn);
  return way / elapsed_;
}

void ClearanceText::write(std::string& text, const Clearance& clearance, const std::vector<double>& gradient) const {
  text.clear();
  writeDistance(text, clearance.deciding);
  if (clearance.by_guaranteed && clearance.level != Clearance::COLLISION) {
    text += ", guaranteed ";
    appendMillimetres(text, clearance.deciding.guaranteed);
  }
  writeMotion(text, gradient);
  writeThreshold(text, clearance);
}

void ClearanceText::append(std::string& text, const scene::BrokenInequality& broken) {
  text += "; '";
  text += broken.inequality->text;
  text += "' is broken by ";
  system::appendRounded(text, broken.excess, 3);
}

void ClearanceText::writeMotion(std::string& text, const std::vector<double>& gradient) const {
  double rate = 0.0, fastest = 0.0, second = 0.0;  // [m/s] negative: closing
  std::size_t joint_of_fastest = 0, joint_of_second = 0;
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    if (gradient[i] == 0.0) continue;
    const double of_joint = gradient[i] * velocityOf(columns_[i]);
    if (!std::isfinite(of_joint)) continue;
    rate += of_joint;
    if (of_joint < fastest) {
      second = fastest;
      joint_of_second = joint_of_fastest;
      fastest = of_joint;
      joint_of_fastest = i;
    } else if (of_joint < second) {
      second = of_joint;
      joint_of_second = i;
    }
  }
  if (std::abs(rate) < kAtRest) return;
  text += rate < 0.0 ? ", closing " : ", opening ";
  system::appendFixed(text, 1000.0 * std::abs(rate), 0);
  text += " mm/s";
  if (rate > 0.0) return;
  text += " by ";
  text += columns_[joint_of_fastest].name;
  if (second > kShareOfSecond * fastest || second == 0.0) return;
  text += " and ";
  text += columns_[joint_of_second].name;
}

std::size_t ClearanceText::capacity(std::size_t longest_name) const {
  std::size_t longest_joint = 0;
  for (const scene::DegreeOfFreedom& column : columns_) longest_joint = std::max(longest_joint, column.name.size());
  std::size_t longest_inequality = 0;
  for (const scene::JointInequality& inequality : robot_.inequalities)
    longest_inequality = std::max(longest_inequality, inequality.text.size());
  return 2 * longest_name + 3 * longest_joint + longest_inequality + kWords;
}

}  // namespace proximity_server::node
