#include "python/driven_edges.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace proximity_server::python {
namespace {

namespace py = pybind11;

/// A pair of arguments: for the start and for the goal.
void addPair(const std::string& name, const py::object& pair, const scene::RobotModel& robot,
             std::vector<JointPositions::Named>& arrays) {
  if (!py::isinstance<py::sequence>(pair) && !py::isinstance<py::array>(pair))
    throw std::invalid_argument(name + " is not a pair: those at the start and those at the goal");
  if (py::len(pair) != 2)
    throw std::invalid_argument(name + " has " + std::to_string(py::len(pair)) +
                                " entries, but it must have two: those at the start and those at the goal");
  for (int i = 0; i < 2; ++i) {
    const std::string of_one = name + "[" + std::to_string(i) + "]";
    arrays.push_back({of_one, jointArray(py::object(pair[py::int_(i)]), robot, of_one)});
  }
}

py::array durationArray(const py::object& duration) {
  py::array given = columnArray(duration, "duration");
  const auto numbers = py::array_t<double, py::array::c_style | py::array::forcecast>(given);
  for (py::ssize_t i = 0; i < numbers.size(); ++i)
    if (!(std::isfinite(numbers.data()[i]) && numbers.data()[i] > 0.0))
      throw std::invalid_argument("duration is not a positive number of seconds");
  return given;
}

std::vector<double> trackingErrors(const py::object& given, const scene::RobotModel& robot) {
  if (given.is_none()) return {};
  const auto numbers =
      py::array_t<double, py::array::c_style | py::array::forcecast>(float64Array(given, "tracking_error"));
  std::vector<double> errors(numbers.data(), numbers.data() + numbers.size());
  if (numbers.ndim() == 0) errors.assign(robot.joints.size(), numbers.data()[0]);
  if (numbers.ndim() > 1 || errors.size() != robot.joints.size())
    throw std::invalid_argument("tracking_error has the shape " + shapeText(numbers) +
                                ", but it must be a number, or one for each of the " +
                                std::to_string(robot.joints.size()) + " joints");
  if (!std::all_of(errors.begin(), errors.end(), [](double error) { return std::isfinite(error) && error >= 0.0; }))
    throw std::invalid_argument("tracking_error has a number that is negative or not finite");
  const bool is_none = std::none_of(errors.begin(), errors.end(), [](double error) { return error > 0.0; });
  return is_none ? std::vector<double>() : errors;
}

}  // namespace

DrivenEdges::DrivenEdges(const py::object& start, const py::object& goal, const EdgeMotion& motion,
                         const scene::RobotModel& robot)
    : has_velocities_(!motion.velocities.is_none()),
      has_accelerations_(!motion.accelerations.is_none()),
      tracking_error_(trackingErrors(motion.tracking_error, robot)) {
  if (has_accelerations_ && !has_velocities_) throw std::invalid_argument("accelerations need velocities too");
  std::vector<JointPositions::Named> arrays{{"start", jointArray(start, robot, "start")},
                                            {"goal", jointArray(goal, robot, "goal")}};
  if (has_velocities_) {
    arrays.push_back({"duration", durationArray(motion.duration)});
    addPair("velocities", motion.velocities, robot, arrays);
  }
  if (has_accelerations_) addPair("accelerations", motion.accelerations, robot, arrays);
  arrays_ = JointPositions::broadcast(arrays);
}

DrivenEdges::Edge DrivenEdges::at(Eigen::Index edge) const {
  bool is_finite = true;
  const auto read = [&](std::size_t array) {
    std::vector<double> numbers;
    positionsOf(arrays_[array].block(edge, 1), 0, numbers);
    for (const double number : numbers) is_finite &= std::isfinite(number);
    return numbers;
  };
  Edge driven{{0.0, read(0)}, {1.0, read(1)}, true};
  for (std::size_t i = 0; i < driven.start.positions.size(); ++i)
    is_finite &= std::isfinite(driven.goal.positions[i] - driven.start.positions[i]);
  if (has_velocities_ && !driven.start.positions.empty()) {
    driven.goal.time = read(2).front();
    driven.start.velocities = read(3);
    driven.goal.velocities = read(4);
  }
  if (has_accelerations_) {
    driven.start.accelerations = read(5);
    driven.goal.accelerations = read(6);
  }
  driven.is_finite = is_finite;
  return driven;
}

}  // namespace proximity_server::python
