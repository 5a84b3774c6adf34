#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

namespace proximity_server::node {

/// How many requests of a queue may compute at the same time.
struct RequestLimit {
  /// By default the number of processors. Evidence for 2 of them, with 16 clients that ask without pause, where 99 % of
  /// the levels are at most 3.5 ms old: with one request fewer it is 3.2 ms, but those that take long are half as many;
  /// without a limit it is 8.8 ms (2026-11).
  std::size_t at_once = std::max(1U, std::thread::hardware_concurrency());
  /// A request that runs for longer does not count any more, so that it delays no other one by more than this.
  std::chrono::steady_clock::duration counts_for = std::chrono::milliseconds(10);
};

/// Runs the callbacks of services in threads of its own, in the order in which they come.
///
/// 1. A request begins as soon as fewer than RequestLimit::at_once others count: they run, do not wait (RequestWait),
///    and began not longer ago than RequestLimit::counts_for. So many clients that ask without pause do not make many
///    threads compete for the processors with the monitor, and yet no request waits for one that takes long.
/// 2. A thread that has finished a request takes the next one. While requests wait, another thread watches: it begins
///    one when a request stops to count.
///
/// It is not suited for topics: the callback of a subscriber that is busy asks to be called again later, and no thread
/// of this queue does that.
class RequestQueue : public ros::CallbackQueueInterface {
 public:
  /// The queue never has more threads than this; further requests wait.
  static constexpr std::size_t kMaxThreads = 64;

  /// The threads of this queue have the niceness of the calling thread plus `niceness`, see nice(2).
  explicit RequestQueue(int niceness, const RequestLimit& limit = {});
  /// All services that use the queue must be destroyed before it.
  ~RequestQueue() override;

  void addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t owner_id) override;
  void removeByID(std::uint64_t owner_id) override { waiting_.removeByID(owner_id); }

 private:
  friend class RequestWait;
  using Clock = std::chrono::steady_clock;
  using Lock = std::unique_lock<std::mutex>;

  void work();
  void runNext(Lock& lock);
  bool mayBegin();
  void wakeThreadIfNeeded();
  void stopCounting(Clock::time_point begin);

  const int niceness_;
  const RequestLimit limit_;
  ros::CallbackQueue waiting_;
  std::mutex mutex_;  // guards the members below; no thread holds it while it runs a request
  std::condition_variable wake_;
  bool is_stopping_ = false;
  bool is_watched_ = false;                    // true if a thread waits until a request stops to count
  std::size_t untaken_count_ = 0;              // callbacks that no thread has taken yet
  std::size_t idle_count_ = 0;                 // threads that run no request
  std::multiset<Clock::time_point> counting_;  // beginnings of the requests that count
  std::vector<std::thread> threads_;
};

/// While it exists, the request that this thread runs does not count, because it waits for something and computes
/// nothing. Without effect in a thread that is not of a RequestQueue.
class RequestWait {
 public:
  RequestWait();
  ~RequestWait();
  RequestWait(const RequestWait&) = delete;
  RequestWait& operator=(const RequestWait&) = delete;
};

/// Wraps a function as a callback for a callback queue.
ros::CallbackInterfacePtr callbackOf(std::function<void()> function);

/// A copy of the node handle whose callbacks go into `queue`.
ros::NodeHandle withQueue(ros::NodeHandle nh, ros::CallbackQueueInterface& queue);

}  // namespace proximity_server::node
