#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace proximity_server::tools {

/// A line at the bottom of a terminal that shows progress. If standard error is not a terminal, shares are printed there
/// line by line, one in `pause`.
class ProgressBar {
 public:
  explicit ProgressBar(std::chrono::milliseconds pause = std::chrono::seconds(10));
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
  using Clock = std::chrono::steady_clock;

  bool is_terminal_;
  std::string shown_;
  std::chrono::milliseconds pause_;
  Clock::time_point told_ = Clock::now();
};

/// Shows on a terminal how many answers there are, how fast they come, and how long the others will take.
class AnswerCounter {
 public:
  /// `what` are they: "states". Without a total the time that is left is not known.
  AnswerCounter(std::string what, std::optional<std::uint64_t> total);

  void count(std::uint64_t answers);

  /// Removes the line.
  void clear() { bar_.clear(); }

 private:
  using Clock = std::chrono::steady_clock;

  std::string what_;
  std::optional<std::uint64_t> total_;
  std::uint64_t count_ = 0;
  Clock::time_point begin_ = Clock::now(), shown_ = begin_;
  ProgressBar bar_;
};

/// "1,234 of 5,000 states, 200 a second, 19 s left"; without a total "1,234 states, 200 a second".
std::string countText(const std::string& what, std::uint64_t count, const std::optional<std::uint64_t>& total,
                      double seconds);

}  // namespace proximity_server::tools
