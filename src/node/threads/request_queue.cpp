#include "node/threads/request_queue.h"

#include <sys/resource.h>
#include <boost/make_shared.hpp>

#include <algorithm>
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

}  // namespace

// On Linux each thread has a niceness of its own.
RequestQueue::RequestQueue(int niceness) : niceness_(getpriority(PRIO_PROCESS, 0) + niceness) {
  sem_init(&untaken_, 0, 0);
}

RequestQueue::~RequestQueue() {
  waiting_.disable();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopping_ = true;
  }
  for (std::size_t i = 0; i < threads_.size(); ++i) sem_post(&untaken_);
  for (std::thread& thread : threads_) thread.join();
  sem_destroy(&untaken_);
}

void RequestQueue::addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t owner_id) {
  waiting_.addCallback(callback, owner_id);
  if (++unfinished_count_ > thread_count_) startThread();
  sem_post(&untaken_);
}

void RequestQueue::startThread() {
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool has_enough = threads_.size() >= std::min(unfinished_count_.load(), kMaxThreads);
  if (is_stopping_ || has_enough) return;
  threads_.emplace_back([this] { work(); });
  thread_count_ = threads_.size();
}

void RequestQueue::work() {
  // Every user may raise the niceness. It is set as an absolute value, because a thread of this queue may start another
  // one (when it reads the next request of a connection), and that one inherits the raised niceness.
  setpriority(PRIO_PROCESS, 0, niceness_);
  while (true) {
    if (sem_wait(&untaken_) != 0) continue;  // a signal interrupted it
    if (is_stopping_) return;
    waiting_.callOne();  // does nothing if the callback was removed
    --unfinished_count_;
  }
}

ros::CallbackInterfacePtr callbackOf(std::function<void()> function) {
  return boost::make_shared<Call>(std::move(function));
}

ros::NodeHandle withQueue(ros::NodeHandle nh, ros::CallbackQueueInterface& queue) {
  nh.setCallbackQueue(&queue);
  return nh;
}

}  // namespace proximity_server::node
