#include "tools/states/state_source.h"

#include "tools/text/csv.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace proximity_server::tools {

bool StateSource::next(scene::Positions& positions) {
  const double* numbers = nullptr;
  if (!fetch(numbers)) return false;
  positions.assign(robot_.joints.size(), 0.0);
  velocities_.resize(robot_.joints.size());  // each state has the same columns
  accelerations_.resize(robot_.joints.size());
  limits_.beginState(state_, line_);
  passState();
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const auto& [name, joint, quantity] = columns_[i];
    if (!std::isfinite(numbers[i]))
      fail("column " + scene::quoted(name) + ": " + scene::quoted(textOf(i, numbers[i])) + " is no finite number");
    if (joint == JointColumn::kTime) {
      time_ = numbers[i];
    } else if (quantity == JointColumn::Quantity::Velocity) {
      velocities_[joint] = numbers[i];
    } else if (quantity == JointColumn::Quantity::Acceleration) {
      accelerations_[joint] = numbers[i];
    } else {
      positions[joint] = numbers[i];
      limits_.add(joint, numbers[i]);
    }
  }
  limits_.endState(positions);
  return true;
}

std::string StateSource::textOf(std::size_t /*column*/, double number) const { return shortest(number); }

void StateSource::setColumns(const std::vector<std::string>& names) {
  columns_ = jointColumns(names, robot_);
  for (const JointColumn& column : columns_) {
    const std::string reason = column.joint == JointColumn::kTime ? "" : whyNotUsed(robot_, column.joint);
    if (!reason.empty()) warn("column " + scene::quoted(column.name) + " is not used: " + reason + ".");
  }
}

bool StateSource::hasTimes() const {
  return std::any_of(columns_.begin(), columns_.end(),
                     [](const JointColumn& column) { return column.joint == JointColumn::kTime; });
}

bool StateSource::hasColumn(JointColumn::Quantity quantity, std::optional<int> joint) const {
  return std::any_of(columns_.begin(), columns_.end(), [&](const JointColumn& column) {
    return column.quantity == quantity && (joint ? column.joint == *joint : column.joint != JointColumn::kTime);
  });
}

std::string StateSource::place() const { return source_ + ", state " + std::to_string(state_ == 0 ? 0 : state_ - 1); }

int StateSource::read(Eigen::Ref<Eigen::MatrixXd> block, const std::function<void(const scene::Positions&)>& each) {
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
  int count = 0;
  try {
    for (; count < block.rows() && next(row_); ++count) {
      for (Eigen::Index joint = 0; joint < block.cols(); ++joint) block(count, joint) = row_[joint];
      if (each) each(row_);
    }
  } catch (const std::invalid_argument&) {
    if (count == 0) throw;
    error_ = std::current_exception();
  }
  return count;
}

void StateSource::fail(const std::string& what) const { throw std::invalid_argument(place() + ": " + what); }

}  // namespace proximity_server::tools
