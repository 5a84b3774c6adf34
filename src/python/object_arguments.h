#pragma once

#include <pybind11/numpy.h>

#include <Eigen/Geometry>
#include <vector>

#include "proximity_server/scene/objects/object.h"

// Objects as Python has them: the classes of proximity/_shapes.py.

namespace proximity_server::python {

/// A pose: None, three numbers (a position) or a matrix of shape (4, 4). What is no rotation is found by who uses the pose.
/// Failure: throws std::invalid_argument for another shape or last row, and as float64Array() does.
Eigen::Isometry3d poseOf(const pybind11::object& pose);

/// A matrix of shape (4, 4).
pybind11::array_t<double> matrixOf(const Eigen::Isometry3d& pose);

/// A shape, or a sequence of shapes and of pairs of a shape and its pose.
/// Failure: throws py::type_error for what is none, and std::invalid_argument for one with a wrong size, naming the shape.
std::vector<scene::ObjectShape> shapesOf(const pybind11::object& shapes);

/// The same back: a tuple of pairs of a shape and its pose.
pybind11::tuple shapesOf(const std::vector<scene::ObjectShape>& shapes);

}  // namespace proximity_server::python
