#pragma once

#include <pybind11/numpy.h>

#include <Eigen/Core>

#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::python {

/// The argument `q` of every question: joint positions [rad] or [m], of shape (states, joints), or (joints,) for one state.
///
/// An array of float64 with any layout of strides that are positive and whole is used in place; others are copied. Types that
/// numpy casts to float64 safely are converted: float32 exactly, and integers.
/// Failure: throws py::type_error for another type, and std::invalid_argument for another shape, naming both; what numpy
///          throws for what is no array.
class JointPositions {
 public:
  JointPositions(const pybind11::object& q, const scene::RobotModel& robot);

  /// Whether q has the shape (joints,), so that the answer has one dimension less, too.
  bool isSingleState() const { return array_.ndim() == 1; }
  Eigen::Index count() const { return count_; }

  /// The states first, first + 1, ... Does not need the GIL.
  using Block = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;
  Block block(Eigen::Index first, Eigen::Index count) const;

 private:
  pybind11::array array_;
  const double* data_;
  Eigen::Index count_, joints_, state_stride_, joint_stride_;
};

}  // namespace proximity_server::python
