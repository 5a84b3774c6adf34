#pragma once

#include <string>

namespace proximity_server::tools {

/// A line at the bottom of a terminal that shows progress; it writes nothing if standard error is not a terminal.
class ProgressBar {
 public:
  ProgressBar();
  ~ProgressBar();  ///< removes the line
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// `done` goes from 0 to 1.
  void show(const std::string& what, double done);
  void show(const std::string& line);

  /// Removes the line until the next one is shown.
  void clear();

  bool isTerminal() const { return is_terminal_; }

 private:
  bool is_terminal_;
  std::string shown_;
};

}  // namespace proximity_server::tools
