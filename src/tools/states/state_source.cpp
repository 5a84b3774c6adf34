#include "tools/states/state_source.h"

#include "tools/text/csv.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace proximity_server::tools {

using Quantity = JointColumn::Quantity;

bool StateSource::next(scene::TrajectoryPoint& state) {
  const std::optional<const double*> numbers = fetch();
  if (!numbers) return false;
  clear(state);
  limits_.beginState(state_, line_);
  passState();
  for (std::size_t i = 0; i < header_.columns.size(); ++i) {
    const auto& [name, joint, quantity] = header_.columns[i];
    const double number = (*numbers)[i];
    if (!std::isfinite(number))
      fail("column " + scene::quoted(name) + ": " + scene::quoted(textOf(i, number)) + " is no finite number");
    if (quantity == Quantity::Position) {
      state.positions[joint] = number;
      limits_.add(joint, number);
    } else if (quantity == Quantity::Time) {
      state.time = number;
    } else {
      scene::Positions& rates = quantity == Quantity::Velocity ? state.velocities : state.accelerations;
      rates.resize(state.positions.size());
      rates[joint] = number;
    }
  }
  limits_.endState(state.positions);
  return true;
}

void StateSource::clear(scene::TrajectoryPoint& state) const {
  state.time = std::numeric_limits<double>::quiet_NaN();
  state.positions.assign(header_.robot.joints.size(), 0.0);
  state.velocities.clear();
  state.accelerations.clear();
}

std::string StateSource::textOf(std::size_t /*column*/, double number) const { return shortest(number); }

std::string StateSource::place() const {
  if (line_ > 0) return header_.source + ", line " + std::to_string(line_);
  return header_.source + ", state " + std::to_string(state_ == 0 ? 0 : state_ - 1);
}

void StateSource::fail(const std::string& what) const { throw std::invalid_argument(place() + ": " + what); }

void StateHeader::setColumns(const std::vector<std::string>& names) {
  columns = jointColumns(names, robot);
  for (const JointColumn& column : columns) {
    const std::string reason = column.quantity == Quantity::Time ? "" : whyNotUsed(robot, column.joint);
    if (!reason.empty()) warn("column " + scene::quoted(column.name) + " is not used: " + reason + ".");
  }
}

bool StateHeader::has(Quantity quantity, std::optional<int> joint) const {
  return std::any_of(columns.begin(), columns.end(), [&](const JointColumn& column) {
    return column.quantity == quantity && (!joint || column.joint == *joint);
  });
}

}  // namespace proximity_server::tools
