#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>
#include <vector>

namespace proximity_server::node {

/// A program that a test starts, hurts and starts again. It does not outlive this object.
class ChildProcess {
 public:
  /// `command`: the program, searched in PATH, and its arguments. {"env", "NAME=value", ...} sets its environment.
  ///
  /// Failure: throws std::system_error where no process can be made; a program that cannot be run ends with exit
  /// code 127.
  explicit ChildProcess(const std::vector<std::string>& command);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  bool isRunning() { return !hasEndedWithin(std::chrono::milliseconds(0)); }

  /// SIGKILL, SIGSTOP, SIGCONT, ...; nothing where it has ended.
  void signal(int number);

  /// Waits for its end.
  bool hasEndedWithin(std::chrono::milliseconds patience);

  /// Its exit code, or minus the number of the signal that ended it; 0 while it runs.
  int exitCode() const { return exit_code_; }

  /// Memory [byte] that it holds in RAM; 0 where it has ended.
  std::size_t residentMemory() const;

 private:
  pid_t pid_;
  bool has_ended_ = false;
  int exit_code_ = 0;
};

}  // namespace proximity_server::node
