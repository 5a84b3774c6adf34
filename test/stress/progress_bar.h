#pragma once

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <thread>

namespace proximity_server::narrowphase {

/// On a terminal: how much of the work is done. Elsewhere nothing.
class ProgressBar {
 public:
  ProgressBar(const std::atomic<std::int64_t>& done, std::int64_t total) : done_(done), total_(total) {
    if (isatty(STDERR_FILENO)) thread_ = std::thread([this] { draw(); });
  }
  ~ProgressBar() {
    ended_ = true;
    if (thread_.joinable()) thread_.join();
  }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

 private:
  void draw() const {
    constexpr int kWidth = 50;
    while (!ended_) {
      const double part = std::min(1.0, static_cast<double>(done_) / static_cast<double>(total_));
      std::fprintf(stderr, "\r[%-*.*s] %5.1f %%", kWidth, static_cast<int>(kWidth * part),
                   "##################################################", 100.0 * part);
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
    std::fprintf(stderr, "\r%*s\r", kWidth + 12, "");
  }

  const std::atomic<std::int64_t>& done_;
  std::int64_t total_;
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

}  // namespace proximity_server::narrowphase
