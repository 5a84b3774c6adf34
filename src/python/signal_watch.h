#pragma once

#include <chrono>

namespace proximity_server::python {

/// Lets Python handle signals from time to time while the GIL is released, so that Ctrl-C ends a long question.
class SignalWatch {
 public:
  /// Returns false after a handler of Python has raised an exception, which is then pending in Python. It must be
  /// called by the thread that has released the GIL.
  bool mayContinue();

  /// Throws the pending exception, if there is one. Needs the GIL.
  void rethrow() const;

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
  bool is_interrupted_ = false;
};

}  // namespace proximity_server::python
