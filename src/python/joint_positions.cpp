#include "python/joint_positions.h"

#include "proximity_server/scene/model/names.h"

#include <stdexcept>

namespace proximity_server::python {
namespace {

namespace py = pybind11;

std::string textOf(const py::handle& object) { return py::str(object).cast<std::string>(); }

/// Returns whether Eigen can use the array in place. For Eigen a stride of 0 means the default stride, and negative
/// strides are not allowed.
bool hasUsableStrides(const py::array& q) {
  constexpr int kAligned = py::detail::npy_api::NPY_ARRAY_ALIGNED_;
  for (py::ssize_t i = 0; i < q.ndim(); ++i)
    if (q.strides(i) <= 0 || q.strides(i) % static_cast<py::ssize_t>(sizeof(double)) != 0) return false;
  return (q.flags() & kAligned) != 0;
}

}  // namespace

py::array float64Array(const py::object& argument, const std::string& name) {
  const py::module_ numpy = py::module_::import("numpy");
  if (numpy.attr("ma").attr("isMaskedArray")(argument).cast<bool>())
    throw py::type_error(name + " is a masked array, whose mask would be lost: take " + name +
                         ".filled(numpy.nan); a state with a NaN has no answer");
  const py::array given =
      py::isinstance<py::array>(argument) ? py::array(argument) : py::array(numpy.attr("asarray")(argument));
  if (py::isinstance<py::array_t<double>>(given)) return given;
  const py::dtype wanted = py::dtype::of<double>();
  if (!numpy.attr("can_cast")(given.dtype(), wanted).cast<bool>())
    throw py::type_error(name + " has the dtype " + textOf(given.dtype()) +
                         ", which numpy does not cast to float64 safely");
  return py::array(given.attr("astype")(wanted));
}

py::array jointArray(const py::object& q, const scene::RobotModel& robot, const std::string& name) {
  const py::array array = float64Array(q, name);
  const auto joints = static_cast<py::ssize_t>(robot.joints.size());
  if (array.ndim() > 0 && array.shape(array.ndim() - 1) == joints) return array;
  const std::string count = std::to_string(joints);
  throw std::invalid_argument(name + " has the shape " + shapeText(array) + ", but it must be (..., " + count +
                              "): the robot has " + count + " joints" + (joints > 0 ? ": " : "") +
                              scene::listed(scene::namesOf(robot.joints)));
}

py::array columnArray(const py::object& argument, const std::string& name) {
  return py::array(float64Array(argument, name).attr("__getitem__")(py::make_tuple(py::ellipsis(), py::none())));
}

py::array vectorArray(const py::object& argument, const std::string& name) {
  const py::array array = float64Array(argument, name);
  if (array.ndim() > 0 && array.shape(array.ndim() - 1) == 3) return array;
  throw std::invalid_argument(name + " has the shape " + shapeText(array) + ", but it must be (..., 3): x, y and z");
}

std::string shapeText(const py::array& array) { return textOf(array.attr("shape")); }

JointPositions::JointPositions(const py::object& q, const scene::RobotModel& robot, const std::string& name)
    : JointPositions(jointArray(q, robot, name)) {}

JointPositions::JointPositions(const py::array& checked)
    : shape_(checked.shape(), checked.shape() + checked.ndim() - 1),
      count_(1),
      joints_(checked.shape(checked.ndim() - 1)) {
  for (const py::ssize_t length : shape_) count_ *= length;
  array_ = py::array(checked.attr("reshape")(count_, joints_));  // numpy copies only if this is necessary
  if (!hasUsableStrides(array_)) array_ = py::array(array_.attr("copy")());
  constexpr auto kSize = static_cast<Eigen::Index>(sizeof(double));
  data_ = static_cast<const double*>(array_.data());
  state_stride_ = array_.strides(0) / kSize;
  joint_stride_ = array_.strides(1) / kSize;
}

std::vector<JointPositions> JointPositions::broadcast(const std::vector<Named>& arrays) {
  py::list given;
  std::string shapes;
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    given.append(arrays[i].array);
    const char* const between = i + 1 < arrays.size() ? ", " : ", and ";
    shapes +=
        (i == 0 ? "" : between) + arrays[i].name + (i == 0 ? " has the shape " : " ") + shapeText(arrays[i].array);
  }
  py::list all;
  try {
    all = py::list(py::module_::import("numpy").attr("broadcast_arrays")(*given));
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_ValueError)) throw;
    throw std::invalid_argument(shapes + ": these do not broadcast to one shape");
  }
  std::vector<JointPositions> positions;
  for (const py::handle& array : all)
    positions.push_back(JointPositions(py::array(py::reinterpret_borrow<py::object>(array))));
  return positions;
}

JointPositions::Block JointPositions::block(Eigen::Index first, Eigen::Index count) const {
  return {data_ + first * state_stride_, count, joints_, {joint_stride_, state_stride_}};
}

void positionsOf(const JointPositions::Block& block, Eigen::Index state, std::vector<double>& positions) {
  positions.resize(block.cols());
  for (Eigen::Index j = 0; j < block.cols(); ++j) positions[j] = block(state, j);
}

}  // namespace proximity_server::python
