#include "node/threads/request_queue.h"

#include <sys/resource.h>
#include <boost/make_shared.hpp>

#include <utility>

namespace proximity_server::node {
namespace {

class Call : public ros::CallbackInterface {
 public:
  explicit Call(std::function<void()> function) : function_(std::move(function)) {}
  CallResult call() override {
    function_();
    return Success;
  }

 private:
  std::function<void()> function_;
};

/// The request that a thread runs.
struct RunningRequest {
  RequestQueue* queue = nullptr;  // nullptr: none
  std::chrono::steady_clock::time_point begin;
};
thread_local RunningRequest running;

}  // namespace

// On Linux each thread has a niceness of its own.
RequestQueue::RequestQueue(int niceness, const RequestLimit& limit)
    : niceness_(getpriority(PRIO_PROCESS, 0) + niceness), limit_(limit) {}

RequestQueue::~RequestQueue() {
  waiting_.disable();
  {
    const Lock lock(mutex_);
    is_stopping_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void RequestQueue::addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t owner_id) {
  waiting_.addCallback(callback, owner_id);
  const Lock lock(mutex_);
  ++untaken_count_;
  wakeThreadIfNeeded();
}

/// One thread that wakes up suffices: it calls this again when it begins a request.
void RequestQueue::wakeThreadIfNeeded() {
  if (is_stopping_ || untaken_count_ == 0 || (is_watched_ && !mayBegin())) return;
  if (idle_count_ > 0) {
    wake_.notify_one();
  } else if (threads_.size() < kMaxThreads) {
    ++idle_count_;
    threads_.emplace_back([this] { work(); });
  }
}

void RequestQueue::work() {
  // Every user may raise the niceness. It is set as an absolute value, because a thread of this queue may start another
  // one, and that one inherits the raised niceness.
  setpriority(PRIO_PROCESS, 0, niceness_);
  Lock lock(mutex_);
  while (!is_stopping_) {
    if (untaken_count_ > 0 && mayBegin()) {
      runNext(lock);
    } else if (untaken_count_ > 0 && !is_watched_) {
      is_watched_ = true;
      wake_.wait_until(lock, *counting_.begin() + limit_.counts_for);
      is_watched_ = false;
    } else {
      wake_.wait(lock);
    }
  }
}

void RequestQueue::runNext(Lock& lock) {
  running = {this, Clock::now()};
  --untaken_count_;
  --idle_count_;
  counting_.insert(running.begin);
  wakeThreadIfNeeded();
  lock.unlock();
  waiting_.callOne();  // does nothing if the callback was removed
  lock.lock();
  stopCounting(running.begin);
  ++idle_count_;
  running = {};
}

/// Forgets the requests that do not count any more.
bool RequestQueue::mayBegin() {
  counting_.erase(counting_.begin(), counting_.upper_bound(Clock::now() - limit_.counts_for));
  return counting_.size() < limit_.at_once;
}

void RequestQueue::stopCounting(Clock::time_point begin) {
  const auto found = counting_.find(begin);  // not there if it has run for so long that it does not count
  if (found != counting_.end()) counting_.erase(found);
}

RequestWait::RequestWait() {
  if (!running.queue) return;
  const RequestQueue::Lock lock(running.queue->mutex_);
  running.queue->stopCounting(running.begin);
  running.queue->wakeThreadIfNeeded();
}

RequestWait::~RequestWait() {
  if (!running.queue) return;
  const RequestQueue::Lock lock(running.queue->mutex_);
  running.begin = RequestQueue::Clock::now();
  running.queue->counting_.insert(running.begin);
}

ros::CallbackInterfacePtr callbackOf(std::function<void()> function) {
  return boost::make_shared<Call>(std::move(function));
}

ros::NodeHandle withQueue(ros::NodeHandle nh, ros::CallbackQueueInterface& queue) {
  nh.setCallbackQueue(&queue);
  return nh;
}

}  // namespace proximity_server::node
