#include "python/joint_positions.h"

#include <stdexcept>
#include <string>

#include "proximity_server/scene/model/names.h"

namespace proximity_server::python {
namespace {

namespace py = pybind11;

std::string textOf(const py::handle& object) { return py::str(object).cast<std::string>(); }

py::array asFloat64(const py::object& q) {
  const py::array given =
      py::isinstance<py::array>(q) ? py::array(q) : py::array(py::module_::import("numpy").attr("asarray")(q));
  if (py::isinstance<py::array_t<double>>(given)) return given;
  const py::dtype wanted = py::dtype::of<double>();
  if (!py::module_::import("numpy").attr("can_cast")(given.dtype(), wanted).cast<bool>())
    throw py::type_error("q has the dtype " + textOf(given.dtype()) + ", which numpy does not cast to float64 safely");
  return py::array(given.attr("astype")(wanted));
}

void requireShape(const py::array& q, const scene::RobotModel& robot) {
  const auto joints = static_cast<py::ssize_t>(robot.joints.size());
  if ((q.ndim() == 1 || q.ndim() == 2) && q.shape(q.ndim() - 1) == joints) return;
  const std::string count = std::to_string(joints);
  throw std::invalid_argument("q has the shape " + textOf(q.attr("shape")) + ", but it must be (states, " + count +
                              ") or (" + count + ",): the robot has " + count + " joints" + (joints > 0 ? ": " : "") +
                              scene::listed(scene::namesOf(robot.joints)));
}

/// Eigen takes a stride of 0 for the usual one, and no negative ones.
bool isUsable(const py::array& q) {
  constexpr int kAligned = py::detail::npy_api::NPY_ARRAY_ALIGNED_;
  for (py::ssize_t i = 0; i < q.ndim(); ++i)
    if (q.strides(i) <= 0 || q.strides(i) % static_cast<py::ssize_t>(sizeof(double)) != 0) return false;
  return (q.flags() & kAligned) != 0;
}

}  // namespace

JointPositions::JointPositions(const py::object& q, const scene::RobotModel& robot) : array_(asFloat64(q)) {
  requireShape(array_, robot);
  if (!isUsable(array_)) array_ = py::array(array_.attr("copy")());
  constexpr auto kSize = static_cast<Eigen::Index>(sizeof(double));
  data_ = static_cast<const double*>(array_.data());
  joints_ = array_.shape(array_.ndim() - 1);
  joint_stride_ = array_.strides(array_.ndim() - 1) / kSize;
  count_ = isSingleState() ? 1 : array_.shape(0);
  state_stride_ = isSingleState() ? 1 : array_.strides(0) / kSize;
}

JointPositions::Block JointPositions::block(Eigen::Index first, Eigen::Index count) const {
  return {data_ + first * state_stride_, count, joints_, {joint_stride_, state_stride_}};
}

}  // namespace proximity_server::python
