#include "scene/model/parallel_work.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace proximity_server::scene {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kMayForkBesideThreads = false;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
constexpr bool kMayForkBesideThreads = false;  // its malloc may stay locked in the child
#else
constexpr bool kMayForkBesideThreads = true;
#endif
#else
constexpr bool kMayForkBesideThreads = true;
#endif

int usefulThreads(int count, int threads) {
  if (!kMayForkBesideThreads) return 1;
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return std::min(count, threads > 0 ? threads : cores);
}

/// What the threads share.
class Work {
 public:
  explicit Work(int count) : count_(count) {}

  /// The next number, or -1.
  int take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return next_ < count_ ? next_++ : -1;
  }
  void stop() {
    const std::lock_guard<std::mutex> lock(mutex_);
    next_ = count_;
  }

  void begin() {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++running_;
  }
  void end() {
    const std::lock_guard<std::mutex> lock(mutex_);
    --running_;
    changed_.notify_all();
  }

  using Message = std::pair<int, std::string>;
  void send(Message message) {
    const std::lock_guard<std::mutex> lock(mutex_);
    messages_.push_back(std::move(message));
    changed_.notify_all();
  }
  /// Waits for one; false where nobody is left to send any.
  bool receive(Message& message) {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return !messages_.empty() || running_ == 0; });
    if (messages_.empty()) return false;
    message = std::move(messages_.front());
    messages_.pop_front();
    return true;
  }

 private:
  const int count_;
  int next_ = 0, running_ = 0;
  std::deque<Message> messages_;
  std::mutex mutex_;
  std::condition_variable changed_;
};

/// Threads that are waited for, whatever happens.
class Threads {
 public:
  explicit Threads(Work& work) : work_(work) {}
  ~Threads() {
    work_.stop();
    for (std::thread& thread : threads_) thread.join();
  }
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

  /// False where the system gives no more.
  bool add(const std::function<void()>& task) {
    work_.begin();
    try {
      threads_.emplace_back([this, task] {
        task();
        work_.end();
      });
      return true;
    } catch (const std::system_error&) {
      work_.end();
      return false;
    }
  }

 private:
  Work& work_;
  std::vector<std::thread> threads_;
};

}  // namespace

void workInParallel(int count, int threads,
                    const std::function<void(int, const std::function<void(const std::string&)>&)>& work,
                    const std::function<void(int, const std::string&)>& told) {
  Work shared(count);
  Threads workers(shared);
  const auto task = [&] {
    for (int i = shared.take(); i >= 0; i = shared.take()) {
      work(i, [&shared, i](const std::string& text) { shared.send({i, text}); });
    }
  };
  for (int started = 0; started < usefulThreads(count, threads) && workers.add(task);) ++started;
  for (Work::Message message; shared.receive(message);) told(message.first, message.second);
  // Nothing is left for this thread unless there was no other.
  for (int i = shared.take(); i >= 0; i = shared.take()) {
    work(i, [&told, i](const std::string& text) { told(i, text); });
  }
}

}  // namespace proximity_server::scene
