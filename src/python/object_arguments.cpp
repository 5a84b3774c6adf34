#include "python/object_arguments.h"

#include "proximity_server/scene/objects/object_fields.h"
#include "python/joint_positions.h"
#include "python/loading.h"
#include "python/path_caster.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

namespace proximity_server::python {
namespace {

namespace py = pybind11;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::Shape;
using Geometry = decltype(scene::ObjectShape::geometry);
using RowMajor4d = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

/// Converts an argument into an array of numbers with this many columns: a single row if `ndim` is 1, and many rows if
/// it is 2.
py::array_t<double, py::array::c_style> numbersOf(const py::object& argument, const std::string& name, py::ssize_t ndim,
                                                  py::ssize_t columns) {
  const py::array array = float64Array(argument, name);
  if (array.ndim() != ndim || array.shape(ndim - 1) != columns)
    throw std::invalid_argument(name + " has the shape " + shapeText(array) + ", but it must be (" +
                                (ndim == 2 ? "..., " : "") + std::to_string(columns) + (ndim == 1 ? ",)" : ")"));
  return array;
}

Vector3d vectorOf(const py::object& argument, const std::string& name) {
  const auto numbers = numbersOf(argument, name, 1, 3);
  return Eigen::Map<const Vector3d>(numbers.data());
}

std::vector<Vector3d> rowsOf(const py::object& argument, const std::string& name) {
  const auto numbers = numbersOf(argument, name, 2, 3);
  std::vector<Vector3d> rows(static_cast<std::size_t>(numbers.shape(0)));
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = Eigen::Map<const Vector3d>(numbers.data() + 3 * i);
  return rows;
}

double number(const py::object& shape, const char* field) { return shape.attr(field).cast<double>(); }

/// A shape with a radius, and a length along z.
template <typename Solid>
Geometry lengthwise(const py::object& shape) {
  return Shape(Solid{number(shape, "radius"), number(shape, "length")});
}

Geometry boxesOf(const py::object& shape) {
  const std::vector<Vector3d> lower = rowsOf(shape.attr("lower"), "lower"),
                              upper = rowsOf(shape.attr("upper"), "upper");
  if (lower.size() != upper.size())
    throw std::invalid_argument("lower has " + std::to_string(lower.size()) + " corners, but upper has " +
                                std::to_string(upper.size()));
  scene::Boxes boxes;
  for (std::size_t i = 0; i < lower.size(); ++i) boxes.boxes.emplace_back(lower[i], upper[i]);
  return boxes;
}

Geometry meshOf(const py::object& shape) {
  const py::module_ numpy = py::module_::import("numpy");
  const py::array corners = py::array(numpy.attr("asarray")(shape.attr("triangles")));
  if (!numpy.attr("can_cast")(corners.dtype(), "int64").cast<bool>() && corners.size() > 0)
    throw py::type_error("triangles has the dtype " + py::str(corners.dtype()).cast<std::string>() +
                         ", but it holds numbers of vertices");
  const auto numbers = numbersOf(corners.attr("astype")("float64"), "triangles", 2, 3);  // exact below 2^53
  std::vector<std::array<int, 3>> triangles;
  using Limits = std::numeric_limits<int>;
  const auto vertex = [](double number) {
    return static_cast<int>(std::clamp<double>(number, Limits::min(), Limits::max()));
  };
  for (const double* row = numbers.data(); row != numbers.data() + numbers.size(); row += 3)
    triangles.push_back({vertex(row[0]), vertex(row[1]), vertex(row[2])});
  return scene::meshFrom(rowsOf(shape.attr("vertices"), "vertices"), std::move(triangles));
}

Geometry meshFileOf(const py::object& shape) {
  const auto path = shape.attr("path").cast<std::filesystem::path>();
  const bool is_uri = path.native().find("://") != std::string::npos;
  return scene::MeshFile{is_uri ? path.string() : std::filesystem::absolute(path).string(),
                         vectorOf(shape.attr("scale"), "scale")};
}

/// The classes of proximity/_shapes.py by name, with the functions that read them.
const std::vector<std::pair<std::string, std::function<Geometry(const py::object&)>>>& readers() {
  using Reader = std::function<Geometry(const py::object&)>;
  static const std::vector<std::pair<std::string, Reader>> all{
      {"Sphere", [](const py::object& s) { return Shape(narrowphase::Sphere{number(s, "radius")}); }},
      {"Capsule", lengthwise<narrowphase::Capsule>},
      {"Box", [](const py::object& s) { return Shape(narrowphase::Box{vectorOf(s.attr("size"), "size")}); }},
      {"Cylinder", lengthwise<narrowphase::Cylinder>},
      {"Cone", lengthwise<narrowphase::Cone>},
      {"Ellipsoid",
       [](const py::object& s) { return Shape(narrowphase::Ellipsoid{vectorOf(s.attr("radii"), "radii")}); }},
      {"HalfSpace",
       [](const py::object& s) {
         return scene::HalfSpace{vectorOf(s.attr("normal"), "normal"), number(s, "offset")};
       }},
      {"Boxes", boxesOf},
      {"Mesh", meshOf},
      {"MeshFile", meshFileOf}};
  return all;
}

py::object shapeClass(const std::string& name) { return py::module_::import("proximity._shapes").attr(name.c_str()); }

const std::function<Geometry(const py::object&)>* readerOf(const py::handle& object) {
  for (const auto& [name, reader] : readers())
    if (py::isinstance(object, shapeClass(name))) return &reader;
  return nullptr;
}

scene::ObjectShape shapeOf(const py::object& entry) {
  if (const auto* reader = readerOf(entry)) return {(*reader)(entry)};
  if (py::isinstance<py::sequence>(entry) && !py::isinstance<py::str>(entry) && py::len(entry) == 2) {
    const py::object shape = entry[py::int_(0)];
    if (const auto* reader = readerOf(shape)) return {(*reader)(shape), poseOf(entry[py::int_(1)])};
  }
  throw py::type_error(
      "a shape is a proximity.Sphere, Capsule, Box, Cylinder, Cone, Ellipsoid, HalfSpace, Boxes, Mesh or "
      "MeshFile, or a pair of one and its pose, but not " +
      py::repr(entry).cast<std::string>());
}

py::tuple tupleOf(const Vector3d& v) { return py::make_tuple(v.x(), v.y(), v.z()); }

template <typename Rows>
py::array_t<double> arrayOf(const std::vector<Rows>& rows, const std::function<Vector3d(const Rows&)>& row) {
  py::array_t<double> array({static_cast<py::ssize_t>(rows.size()), py::ssize_t{3}});
  for (std::size_t i = 0; i < rows.size(); ++i) Eigen::Map<Vector3d>(array.mutable_data() + 3 * i) = row(rows[i]);
  return array;
}

/// Makes the object of Python that shapeOf() would read as this shape. Sizes are halved there and doubled here, which
/// is exact.
struct PythonShape {
  py::object operator()(const Shape& shape) const {
    const Vector3d& half = shape.halfExtents();
    switch (shape.kind()) {
      case Shape::Kind::Point:
        return shapeClass("Sphere")(shape.margin());
      case Shape::Kind::Segment:
        return shapeClass("Capsule")(shape.margin(), 2.0 * half.z());
      case Shape::Kind::Box:
        return shapeClass("Box")(tupleOf(2.0 * half));
      case Shape::Kind::Cylinder:
        return shapeClass("Cylinder")(half.x(), 2.0 * half.z());
      case Shape::Kind::Cone:
        return shapeClass("Cone")(half.x(), 2.0 * half.z());
      case Shape::Kind::Ellipsoid:
        return shapeClass("Ellipsoid")(tupleOf(half));
      default:
        throw std::logic_error("no file and no argument has such a shape");
    }
  }
  py::object operator()(const scene::HalfSpace& plane) const {
    return shapeClass("HalfSpace")(tupleOf(plane.normal), plane.offset);
  }
  py::object operator()(const scene::Boxes& boxes) const {
    using Box = Eigen::AlignedBox3d;
    return shapeClass("Boxes")(arrayOf<Box>(boxes.boxes, [](const Box& box) { return box.min(); }),
                               arrayOf<Box>(boxes.boxes, [](const Box& box) { return box.max(); }));
  }
  py::object operator()(const scene::TriangleMesh& mesh) const {
    py::array_t<int> triangles({static_cast<py::ssize_t>(mesh.triangles.size()), py::ssize_t{3}});
    int* out = triangles.mutable_data();
    for (const auto& triangle : mesh.triangles) out = std::copy(triangle.begin(), triangle.end(), out);
    return shapeClass("Mesh")(arrayOf<Vector3d>(mesh.vertices, [](const Vector3d& v) { return v; }), triangles);
  }
  py::object operator()(const scene::MeshFile& file) const {
    return shapeClass("MeshFile")(file.uri, tupleOf(file.scale));
  }
};

}  // namespace

Isometry3d poseOf(const py::object& pose) {
  Isometry3d result = Isometry3d::Identity();
  if (pose.is_none()) return result;
  const py::array_t<double, py::array::c_style> numbers = float64Array(pose, "pose");
  if (numbers.ndim() == 1 && numbers.shape(0) == 3) {
    result.translation() = Eigen::Map<const Vector3d>(numbers.data());
    return result;
  }
  if (numbers.ndim() != 2 || numbers.shape(0) != 4 || numbers.shape(1) != 4)
    throw std::invalid_argument("pose has the shape " + shapeText(numbers) +
                                ", but it must be (3,) for a position or (4, 4)");
  result.matrix() = Eigen::Map<const RowMajor4d>(numbers.data());
  if (result.matrix().row(3) != Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0))
    throw std::invalid_argument("the last row of a pose is 0, 0, 0, 1");
  return result;
}

py::array_t<double> matrixOf(const Isometry3d& pose) {
  py::array_t<double> matrix({py::ssize_t{4}, py::ssize_t{4}});
  Eigen::Map<RowMajor4d>(matrix.mutable_data()) = pose.matrix();
  return matrix;
}

std::vector<scene::ObjectShape> shapesOf(const py::object& shapes) {
  const bool is_one = readerOf(shapes) != nullptr;
  if (!is_one && (!py::isinstance<py::sequence>(shapes) || py::isinstance<py::str>(shapes))) return {shapeOf(shapes)};
  std::vector<scene::ObjectShape> list;
  const py::tuple entries = is_one ? py::make_tuple(shapes) : py::tuple(shapes);
  for (const py::handle& entry : entries) {
    withNameInErrors("shape " + std::to_string(list.size() + 1),
                     [&] { list.push_back(shapeOf(py::reinterpret_borrow<py::object>(entry))); });
  }
  return list;
}

py::tuple shapesOf(const std::vector<scene::ObjectShape>& shapes) {
  py::list list;
  for (const scene::ObjectShape& shape : shapes)
    list.append(py::make_tuple(std::visit(PythonShape{}, shape.geometry), matrixOf(shape.object_T_shape)));
  return py::tuple(list);
}

}  // namespace proximity_server::python
