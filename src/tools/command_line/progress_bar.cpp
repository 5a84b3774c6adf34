#include "tools/command_line/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <iostream>

namespace proximity_server::tools {

ProgressBar::ProgressBar() : is_terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() { clear(); }

void ProgressBar::clear() {
  if (is_terminal_ && !shown_.empty()) std::cerr << "\r\033[K" << std::flush;
  shown_.clear();
}

void ProgressBar::show(const std::string& what, double done) {
  if (!is_terminal_) return;
  constexpr std::size_t kWidth = 40;
  const double fraction = std::clamp(done, 0.0, 1.0);
  const auto filled = static_cast<std::size_t>(fraction * kWidth);
  show(what + " [" + std::string(filled, '#') + std::string(kWidth - filled, '.') + "] " +
       std::to_string(static_cast<int>(100.0 * fraction)) + " %");
}

void ProgressBar::show(const std::string& line) {
  if (!is_terminal_ || line == shown_) return;
  shown_ = line;
  std::cerr << '\r' << line << "\033[K" << std::flush;
}

}  // namespace proximity_server::tools
