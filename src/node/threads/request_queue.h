#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace proximity_server::node {

/// Runs the callbacks of services in threads of its own, as many as the most requests that were open at once. So a
/// request that takes long, or waits for tf, delays no other. Not for topics: the callback of a subscriber that is busy
/// asks to be called again later, and no thread here would do that.
class RequestQueue : public ros::CallbackQueueInterface {
 public:
  /// The largest number of threads; further requests wait.
  static constexpr std::size_t kMaxThreads = 64;

  /// `niceness` is added to that of the calling thread for the threads of this queue, see nice(2).
  explicit RequestQueue(int niceness);
  /// All services that use it must be destroyed before.
  ~RequestQueue() override;

  void addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t owner_id) override;
  void removeByID(std::uint64_t owner_id) override { waiting_.removeByID(owner_id); }

 private:
  void work();

  const int niceness_;
  ros::CallbackQueue waiting_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::size_t open_ = 0;           // callbacks that wait or run
  std::size_t waiting_count_ = 0;  // callbacks that no thread has taken yet
  bool ends_ = false;
  std::vector<std::thread> threads_;
};

/// Wraps a function as a callback for a callback queue.
ros::CallbackInterfacePtr callbackOf(std::function<void()> function);

/// A copy of the node handle whose callbacks go into `queue`.
ros::NodeHandle withQueue(ros::NodeHandle nh, ros::CallbackQueueInterface& queue);

}  // namespace proximity_server::node
