#pragma once

#include <chrono>

namespace proximity_server::python {

/// Lets Python handle its signals now and then while the GIL is released, so that Ctrl-C ends a long question.
class SignalWatch {
 public:
  /// False once a handler has raised an exception, which is then pending in Python. For the thread that released the GIL.
  bool goesOn();

  /// With the GIL: throws what is pending.
  void rethrow() const;

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
  bool is_interrupted_ = false;
};

}  // namespace proximity_server::python
