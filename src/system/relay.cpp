#include "system/relay.h"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <future>
#include <mutex>
#include <system_error>
#include <utility>

namespace proximity_server::system {
namespace {

using Call = std::function<void()>;

class Calls {
 public:
  void add(Call call) {
    const std::lock_guard lock(mutex_);
    calls_.push_back(std::move(call));
    changed_.notify_one();
  }
  void end() {
    const std::lock_guard lock(mutex_);
    has_ended_ = true;
    changed_.notify_one();
  }
  /// Waits for the next call. Returns an empty function at the end.
  Call next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return has_ended_ || !calls_.empty(); });
    if (calls_.empty()) return nullptr;
    Call call = std::move(calls_.front());
    calls_.pop_front();
    return call;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Call> calls_;
  bool has_ended_ = false;
};

struct EndOfCalls {
  Calls& calls;
  ~EndOfCalls() { calls.end(); }
};

/// Starts a thread. Returns an invalid future if the system refuses to.
std::future<void> startThread(const std::function<void()>& work) {
  try {
    return std::async(std::launch::async, work);
  } catch (const std::system_error&) {
    return {};
  }
}

}  // namespace

void runRelayed(const std::function<void(const CallHere&)>& work) {
  Calls calls;
  const auto workInThread = [&] {
    const EndOfCalls end{calls};
    work([&](Call call) { calls.add(std::move(call)); });
  };
  std::future<void> done = startThread(workInThread);  // its destructor waits
  if (!done.valid()) return work([](const Call& call) { call(); });
  while (const Call call = calls.next()) call();
  done.get();
}

void runWatched(const std::function<void()>& work, const std::function<void()>& watch) {
  std::future<void> done = startThread(work);
  if (!done.valid()) return work();
  while (done.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready) watch();
  done.get();
}

}  // namespace proximity_server::system
