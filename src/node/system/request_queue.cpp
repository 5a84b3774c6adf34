#include "node/system/request_queue.h"

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

}  // namespace

RequestQueue::RequestQueue(int niceness) : niceness_(niceness) {}

RequestQueue::~RequestQueue() {
  waiting_.disable();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void RequestQueue::addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t owner_id) {
  waiting_.addCallback(callback, owner_id);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (ends_) return;
    ++waiting_count_;
    if (++open_ > threads_.size() && threads_.size() < kMaxThreads) threads_.emplace_back([this] { work(); });
  }
  changed_.notify_one();
}

void RequestQueue::work() {
  // On Linux this sets the niceness of the calling thread alone; every user may raise it.
  setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + niceness_);
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ends_ || waiting_count_ > 0; });
    if (ends_) return;
    --waiting_count_;
    lock.unlock();
    waiting_.callOne();  // does nothing if the callback was removed
    lock.lock();
    --open_;
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
