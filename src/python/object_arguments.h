#pragma once

#include "proximity_server/scene/objects/object.h"

#include <pybind11/numpy.h>
#include <Eigen/Geometry>

#include <vector>

// Conversions of shapes and poses from and into Python, with the classes of proximity/_shapes.py.

namespace proximity_server::python {

/// Reads a pose: None (the identity), three numbers (a position) or a matrix of shape (4, 4). It is not checked whether
/// the matrix has a rotation; the functions that use the pose do that.
/// Failure: throws std::invalid_argument for another shape or last row, and as float64Array() does.
Eigen::Isometry3d poseOf(const pybind11::object& pose);

/// Converts a pose into a matrix of shape (4, 4).
pybind11::array_t<double> matrixOf(const Eigen::Isometry3d& pose);

/// Reads a shape, or a sequence of shapes and of pairs (shape, pose).
/// Failure: throws py::type_error if an entry is not a shape, and std::invalid_argument naming a shape with a wrong
///          size.
std::vector<scene::ObjectShape> shapesOf(const pybind11::object& shapes);

/// Converts shapes into a tuple of pairs (shape, pose).
pybind11::tuple shapesOf(const std::vector<scene::ObjectShape>& shapes);

}  // namespace proximity_server::python
