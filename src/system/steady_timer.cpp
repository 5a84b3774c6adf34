#include "system/steady_timer.h"

#include <utility>

namespace proximity_server::system {

SteadyTimer::SteadyTimer(std::function<void()> begin, std::function<void()> tick)
    : tick_(std::move(tick)), thread_([this, begin = std::move(begin)] {
        begin();
        run();
      }) {}

SteadyTimer::~SteadyTimer() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ends_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void SteadyTimer::start(double period) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    period_ = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(period));
    next_ = Clock::now() + period_;
  }
  changed_.notify_one();
}

void SteadyTimer::stop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  period_ = {};
}

void SteadyTimer::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!ends_) {
    if (period_ == Clock::duration()) {
      changed_.wait(lock);
      continue;
    }
    if (Clock::now() < next_) {
      changed_.wait_until(lock, next_);
      continue;  // checks again after any wake-up
    }
    next_ += period_ * (1 + (Clock::now() - next_) / period_);
    lock.unlock();
    tick_();
    lock.lock();
  }
}

}  // namespace proximity_server::system
