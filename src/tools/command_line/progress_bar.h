#pragma once

#include <string>

namespace proximity_server::tools {

/// A line at the bottom of a terminal that says how far something is; nothing where standard error is none.
class ProgressBar {
 public:
  ProgressBar();
  ~ProgressBar();  ///< takes the line away
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// `done` goes from 0 to 1.
  void show(const std::string& what, double done);

 private:
  bool is_terminal_;
  std::string shown_;
};

}  // namespace proximity_server::tools
