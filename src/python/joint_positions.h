#pragma once

#include <pybind11/numpy.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "proximity_server/scene/model/robot_model.h"
#include "proximity_server/scene/model/states.h"

namespace proximity_server::python {

/// The argument with this name as an array of float64; one that is such an array already is returned as it is.
/// Failure: throws py::type_error for what numpy does not cast to float64 safely, and for a masked array; what numpy throws for what is no
///          array.
pybind11::array float64Array(const pybind11::object& argument, const std::string& name);

/// "(2, 3)"
std::string shapeText(const pybind11::array& array);

/// The joint positions [rad] or [m] of a question, of shape (..., joints): the joints are in the last dimension, and the others, if
/// there are any, are those of the states.
///
/// An array of float64 with any layout of strides that are positive and whole is used in place, if numpy can see its states as one
/// dimension; others are copied. Types that numpy casts to float64 safely are converted: float32 exactly, and integers.
/// Failure: the constructor throws as float64Array() does, and std::invalid_argument for another shape, naming both.
class JointPositions {
 public:
  JointPositions(const pybind11::object& q, const scene::RobotModel& robot, const std::string& name = "q");

  /// Both of one shape, that to which numpy broadcasts them.
  /// Failure: throws std::invalid_argument also if there is none.
  struct Edges;
  static Edges edges(const pybind11::object& start, const pybind11::object& goal, const scene::RobotModel& robot);

  /// The shape of the states: () for one state.
  const std::vector<pybind11::ssize_t>& shape() const { return shape_; }
  Eigen::Index count() const { return count_; }

  /// The states first, first + 1, ... in the order of their numbers: the last dimension of shape() is the fastest. Does not need the
  /// GIL.
  using Block = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;
  Block block(Eigen::Index first, Eigen::Index count) const;

 private:
  explicit JointPositions(const pybind11::array& checked);

  pybind11::array array_;  ///< of shape (states, joints)
  std::vector<pybind11::ssize_t> shape_;
  const double* data_;
  Eigen::Index count_, joints_, state_stride_, joint_stride_;
};

struct JointPositions::Edges {
  JointPositions start, goal;
};

/// The positions of one state of a block.
void positionsOf(const JointPositions::Block& block, Eigen::Index state, std::vector<double>& positions);

}  // namespace proximity_server::python
