#include "python/signal_watch.h"

#include "system/durations.h"
#include "system/relay.h"

#include <pybind11/pybind11.h>

#include <stdexcept>

namespace proximity_server::python {

namespace py = pybind11;

SignalWatch::SignalWatch(std::optional<double> time_budget) : deadline_(is_interrupted_) {
  if (!time_budget) return;
  if (!(*time_budget >= 0.0)) throw std::invalid_argument("time_budget must be a number of seconds from 0 on");
  deadline_ = scene::Deadline(is_interrupted_, system::deadlineIn(*time_budget));
}

void SignalWatch::run(const std::function<void()>& work) {
  try {
    runWithoutGil(work);
  } catch (...) {
    if (!is_interrupted_) throw;
  }
  if (is_interrupted_) throw py::error_already_set();
}

void SignalWatch::runWithoutGil(const std::function<void()>& work) {
  const py::gil_scoped_release released;
  system::runWatched(work, [this] {
    if (is_interrupted_) return;
    const py::gil_scoped_acquire gil;
    is_interrupted_ = PyErr_CheckSignals() != 0;
  });
}

}  // namespace proximity_server::python
