#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <semaphore.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace proximity_server::node {

/// Runs the callbacks of services in threads of its own. It has as many threads as there have been unfinished requests
/// at the same time, so that a request that takes long, or waits for tf, delays no other. It is not suited for topics:
/// the callback of a subscriber that is busy asks to be called again later, and no thread of this queue does that.
class RequestQueue : public ros::CallbackQueueInterface {
 public:
  /// The queue never has more threads than this; further requests wait.
  static constexpr std::size_t kMaxThreads = 64;

  /// The threads of this queue have the niceness of the calling thread plus `niceness`, see nice(2).
  explicit RequestQueue(int niceness);
  /// All services that use the queue must be destroyed before it.
  ~RequestQueue() override;

  void addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t owner_id) override;
  void removeByID(std::uint64_t owner_id) override { waiting_.removeByID(owner_id); }

 private:
  void startThread();
  void work();

  const int niceness_;
  ros::CallbackQueue waiting_;
  // addCallback() runs in the thread that receives transforms and publishes levels. So it shares no lock with the
  // threads of requests: one that has lost its processor would hold up that thread. And this is no condition variable:
  // before glibc 2.41, to notify one may wait until a thread that was woken earlier gets a processor.
  sem_t untaken_;  // counts callbacks that no thread has taken yet
  std::atomic<bool> is_stopping_{false};
  std::atomic<std::size_t> unfinished_count_{0};  // callbacks that wait or run
  std::atomic<std::size_t> thread_count_{0};      // size of threads_
  std::mutex mutex_;                              // guards threads_, whose size changes in startThread() only
  std::vector<std::thread> threads_;
};

/// Wraps a function as a callback for a callback queue.
ros::CallbackInterfacePtr callbackOf(std::function<void()> function);

/// A copy of the node handle whose callbacks go into `queue`.
ros::NodeHandle withQueue(ros::NodeHandle nh, ros::CallbackQueueInterface& queue);

}  // namespace proximity_server::node
