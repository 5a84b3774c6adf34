#pragma once

#include "proximity_server/scene/query/deadline.h"

#include <atomic>
#include <functional>
#include <optional>

namespace proximity_server::python {

/// Ends a long question, or loading, at Ctrl-C, and a question when its time is over.
class SignalWatch {
 public:
  /// `time_budget`: [s] from now on. Throws std::invalid_argument for one that is negative or not a number.
  explicit SignalWatch(std::optional<double> time_budget = std::nullopt);

  /// For the searches of the question.
  const scene::Deadline& deadline() const { return deadline_; }

  /// For loading, see scene::MeshOptions::stop.
  const std::atomic<bool>* stop() const { return &is_interrupted_; }

  /// True after a handler of Python has raised an exception. Nobody waits for the answer then.
  bool isInterrupted() const { return is_interrupted_; }

  /// Releases the GIL and runs `work` in another thread, while this one lets Python handle signals.
  /// Failure: throws what `work` throws, or the exception of a handler of Python, with the GIL.
  void run(const std::function<void()>& work);

 private:
  void runWithoutGil(const std::function<void()>& work);

  std::atomic<bool> is_interrupted_{false};
  scene::Deadline deadline_;
};

}  // namespace proximity_server::python
