#include "tools/program/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <utility>

namespace proximity_server::tools {
namespace {

/// With commas: 12,345,678.
std::string grouped(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, ",");
  return text;
}

std::string duration(double seconds) {
  if (seconds < 120.0) return grouped(static_cast<std::uint64_t>(std::ceil(seconds))) + " s";
  if (seconds < 7200.0) return grouped(static_cast<std::uint64_t>(std::ceil(seconds / 60.0))) + " min";
  return grouped(static_cast<std::uint64_t>(std::ceil(seconds / 3600.0))) + " h";
}

}  // namespace

ProgressBar::ProgressBar(std::chrono::milliseconds pause) : is_terminal_(isatty(STDERR_FILENO) != 0), pause_(pause) {}

ProgressBar::~ProgressBar() { clear(); }

void ProgressBar::clear() {
  if (is_terminal_ && !shown_.empty()) std::cerr << "\r\033[K" << std::flush;
  shown_.clear();
}

void ProgressBar::show(const std::string& what, double done) {
  constexpr std::size_t kWidth = 40;
  const double fraction = std::clamp(done, 0.0, 1.0);
  const auto filled = static_cast<std::size_t>(fraction * kWidth);
  const std::string percent = std::to_string(static_cast<int>(100.0 * fraction)) + " %";
  show(what + " [" + std::string(filled, '#') + std::string(kWidth - filled, '.') + "] " + percent);
  const Clock::time_point now = Clock::now();
  if (is_terminal_ || now - told_ < pause_) return;
  told_ = now;
  std::cerr << what << ": " << percent << std::endl;
}

void ProgressBar::show(const std::string& line) {
  if (!is_terminal_ || line == shown_) return;
  shown_ = line;
  std::cerr << '\r' << line << "\033[K" << std::flush;
}

AnswerCounter::AnswerCounter(std::string what, std::optional<std::uint64_t> total)
    : what_(std::move(what)), total_(total) {}

void AnswerCounter::count(std::uint64_t answers) {
  count_ += answers;
  if (!bar_.isTerminal()) return;
  const Clock::time_point now = Clock::now();
  if (now - shown_ < std::chrono::milliseconds(200)) return;
  shown_ = now;
  bar_.show(countText(what_, count_, total_, std::chrono::duration<double>(now - begin_).count()));
}

std::string countText(const std::string& what, std::uint64_t count, const std::optional<std::uint64_t>& total,
                      double seconds) {
  const double rate = static_cast<double>(count) / std::max(seconds, 1e-9);
  std::string text = grouped(count) + (total ? " of " + grouped(*total) : "") + " " + what + ", " +
                     grouped(static_cast<std::uint64_t>(std::lround(rate))) + " a second";
  if (total && count > 0 && *total >= count)
    text += ", " + duration(static_cast<double>(*total - count) / rate) + " left";
  return text;
}

}  // namespace proximity_server::tools
