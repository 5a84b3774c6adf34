#pragma once

#include "proximity_server/scene/model/robot_model.h"
#include "proximity_server/scene/model/states.h"

#include <pybind11/numpy.h>
#include <Eigen/Core>

#include <string>
#include <vector>

namespace proximity_server::python {

/// Converts an argument into an array of float64. An array of float64 is returned as it is. Error messages have the
/// `name`.
/// Failure: throws py::type_error for a masked array, and for types that numpy does not cast to float64 safely; throws
///          as numpy does if the argument cannot be converted into an array.
pybind11::array float64Array(const pybind11::object& argument, const std::string& name);

/// float64Array() for an array with a number for each joint in its last dimension. Throws std::invalid_argument for a
/// wrong shape, naming the right one, too.
pybind11::array jointArray(const pybind11::object& argument, const scene::RobotModel& robot, const std::string& name);

/// An array of float64 with one more dimension, which numpy broadcasts to all columns.
pybind11::array columnArray(const pybind11::object& argument, const std::string& name);

/// float64Array() for vectors, with x, y and z in the last dimension. Throws std::invalid_argument for a wrong shape.
pybind11::array vectorArray(const pybind11::object& argument, const std::string& name);

/// The shape of an array as text: "(2, 3)".
std::string shapeText(const pybind11::array& array);

/// The joint positions [rad] or [m] of a question. The array has the shape (..., joints): its last dimension has the
/// joints, and the others, if there are any, have the states.
///
/// An array of float64 is used in place if its strides are positive multiples of the size of a number, and if numpy can
/// reshape the states to one dimension without a copy. Other arrays are copied. Types that numpy casts to float64
/// safely are converted, such as integers and float32.
/// Failure: the constructor throws as float64Array() does, and std::invalid_argument for a wrong shape, naming the
///          right one, too.
class JointPositions {
 public:
  JointPositions(const pybind11::object& q, const scene::RobotModel& robot, const std::string& name = "q");

  /// Arrays of joints, or of vectors, all with the shape to which numpy broadcasts them.
  /// Failure: throws std::invalid_argument with the names if they do not broadcast to one shape.
  struct Named {
    std::string name;
    pybind11::array array;
  };
  static std::vector<JointPositions> broadcast(const std::vector<Named>& arrays);

  /// The shape of the states: () for one state.
  const std::vector<pybind11::ssize_t>& shape() const { return shape_; }
  Eigen::Index count() const { return count_; }

  /// The states first, first + 1, ... in the order of their numbers; numbers are counted along the last dimension of
  /// shape() first. Does not need the GIL.
  using Block = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;
  Block block(Eigen::Index first, Eigen::Index count) const;

 private:
  explicit JointPositions(const pybind11::array& checked);

  pybind11::array array_;  ///< of shape (states, joints)
  std::vector<pybind11::ssize_t> shape_;
  const double* data_;
  Eigen::Index count_, joints_, state_stride_, joint_stride_;
};

/// The positions of one state of a block.
void positionsOf(const JointPositions::Block& block, Eigen::Index state, std::vector<double>& positions);

}  // namespace proximity_server::python
