#include "python/signal_watch.h"

#include <pybind11/pybind11.h>

namespace proximity_server::python {

namespace py = pybind11;

bool SignalWatch::mayContinue() {
  using namespace std::chrono_literals;
  const auto now = std::chrono::steady_clock::now();
  if (is_interrupted_ || now - last_ < 100ms) return !is_interrupted_;
  last_ = now;
  const py::gil_scoped_acquire gil;
  is_interrupted_ = PyErr_CheckSignals() != 0;
  return !is_interrupted_;
}

void SignalWatch::rethrow() const {
  if (is_interrupted_) throw py::error_already_set();
}

}  // namespace proximity_server::python
