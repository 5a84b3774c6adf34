#pragma once

#include <ros/node_handle.h>

#include <functional>
#include <memory>
#include <mutex>
#include <utility>

namespace proximity_server::node {

/// Calls a function at a rate [Hz] of wall time, between start() and stop().
///
/// After stop() it neither runs nor begins to. roscpp alone does not promise that: the callback of a ros::WallTimer may
/// run in a thread of a spinner after stop() has returned, and then it publishes on what is gone.
class Ticker {
 public:
  Ticker(const ros::NodeHandle& nh, double rate, std::function<void()> function) : state_(std::make_shared<State>()) {
    state_->function = std::move(function);
    const auto tick = [state = state_](const ros::WallTimerEvent&) {
      const std::lock_guard<std::mutex> lock(state->mutex);
      if (state->is_running) state->function();
    };
    timer_ = nh.createWallTimer(ros::WallDuration(1.0 / rate), tick, /*oneshot=*/false, /*autostart=*/false);
  }
  ~Ticker() { stop(); }
  Ticker(const Ticker&) = delete;
  Ticker& operator=(const Ticker&) = delete;

  void start() {
    set(true);
    timer_.start();
  }
  void stop() {
    timer_.stop();
    set(false);
  }

 private:
  struct State {
    std::mutex mutex;
    bool is_running = false;
    std::function<void()> function;
  };

  void set(bool is_running) {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    state_->is_running = is_running;
  }

  std::shared_ptr<State> state_;  // the callback may outlive this
  ros::WallTimer timer_;
};

}  // namespace proximity_server::node
