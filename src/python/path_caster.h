#pragma once

#include <pybind11/pybind11.h>

// Paths as arguments and results of the module.

#if __has_include(<pybind11/stl/filesystem.h>)
#include <pybind11/stl/filesystem.h>
#else  // pybind11 before 2.8

#include <filesystem>

namespace PYBIND11_NAMESPACE {
namespace detail {

/// Takes what os.fspath() takes. A path becomes a pathlib.Path.
template <>
struct type_caster<std::filesystem::path> {
  PYBIND11_TYPE_CASTER(std::filesystem::path, _("os.PathLike"));

  bool load(handle source, bool /*convert*/) {
    PyObject* bytes = nullptr;
    if (PyUnicode_FSConverter(source.ptr(), &bytes) == 0) {
      PyErr_Clear();
      return false;
    }
    value = PyBytes_AsString(bytes);
    Py_DECREF(bytes);
    return true;
  }

  static handle cast(const std::filesystem::path& path, return_value_policy /*policy*/, handle /*parent*/) {
    const std::string& native = path.native();
    const auto text = reinterpret_steal<object>(
        PyUnicode_DecodeFSDefaultAndSize(native.c_str(), static_cast<ssize_t>(native.size())));
    if (!text) throw error_already_set();
    return module_::import("pathlib").attr("Path")(text).release();
  }
};

}  // namespace detail
}  // namespace PYBIND11_NAMESPACE

#endif
