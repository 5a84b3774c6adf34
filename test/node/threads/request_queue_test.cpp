// The threads of a request queue.
#include "node/threads/request_queue.h"

#include "node/patience.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <future>
#include <iterator>
#include <thread>
#include <vector>

namespace proximity_server::node::request_queue_test {

constexpr std::chrono::hours kForever{1};

int nicenessOfThisThread() { return getpriority(PRIO_PROCESS, 0); }

// Regression: each thread added the niceness to that of the thread that started it. A thread of the queue that sends an
// answer also reads the next request of the connection, and starts a thread for it: the fourth had the lowest priority.
TEST(RequestQueue, AThreadThatAThreadOfTheQueueStartsHasTheNicenessOfTheQueue) {
  const int ours = nicenessOfThisThread();
  if (ours > 9) GTEST_SKIP() << "we are as nice as can be";
  RequestQueue queue(5);
  std::promise<int> first, second;
  queue.addCallback(callbackOf([&] {
                      std::future<int> of_second = second.get_future();
                      queue.addCallback(callbackOf([&] { second.set_value(nicenessOfThisThread()); }), 1);
                      first.set_value(of_second.get());  // this thread is busy, so that another one runs it
                    }),
                    1);
  EXPECT_EQ(first.get_future().get(), ours + 5);
}

std::ptrdiff_t threadsOfThisProcess() {
  using Entries = std::filesystem::directory_iterator;
  return std::distance(Entries("/proc/self/task"), Entries());
}

TEST(RequestQueue, RequestsThatWaitHaveAThreadEachAndNoMore) {
  constexpr int kAdders = 4, kRequestsOfEach = 8, kRequests = kAdders * kRequestsOfEach;
  for (int round = 0; round < 20; ++round) {
    const std::ptrdiff_t before = threadsOfThisProcess();
    RequestQueue queue(0, {1, kForever});
    std::promise<void> all_run;
    std::atomic<int> running{0}, ended{0};
    // Each waits until all run, so that the test does not end if one has no thread.
    const auto request = [&, released = all_run.get_future().share()] {
      if (++running == kRequests) all_run.set_value();
      const RequestWait request_wait;
      released.wait();
      ++ended;
    };
    std::vector<std::thread> adders;
    for (int adder = 0; adder < kAdders; ++adder) {
      adders.emplace_back([&] {
        for (int i = 0; i < kRequestsOfEach; ++i) queue.addCallback(callbackOf(request), 1);
      });
    }
    for (std::thread& adder : adders) adder.join();
    while (ended < kRequests) std::this_thread::yield();
    EXPECT_LE(threadsOfThisProcess(), before + kRequests + 1);  // one of them may watch
  }
}

/// Requests that compute until they are told to end.
class Computations {
 public:
  void addTo(RequestQueue& queue, int count) {
    for (int i = 0; i < count; ++i) {
      queue.addCallback(callbackOf([this] {
                          ++begun_;
                          while (!may_end_) std::this_thread::yield();
                        }),
                        1);
    }
  }
  void endAll() { may_end_ = true; }
  bool haveBegun(int count) const {
    return holdsWithin(kPatience, [&] { return begun_ == count; });
  }
  int begun() const { return begun_; }

 private:
  std::atomic<int> begun_{0};
  std::atomic<bool> may_end_{false};
};

TEST(RequestQueue, NoMoreRequestsThanTheLimitComputeAtOnce) {
  Computations computations;
  RequestQueue queue(0, {2, kForever});
  computations.addTo(queue, 8);
  EXPECT_TRUE(computations.haveBegun(2));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(computations.begun(), 2);
  computations.endAll();
  EXPECT_TRUE(computations.haveBegun(8));
}

TEST(RequestQueue, ARequestThatTakesLongDelaysNoOther) {
  Computations computations;
  RequestQueue queue(0, {1, std::chrono::milliseconds(1)});
  computations.addTo(queue, 8);
  EXPECT_TRUE(computations.haveBegun(8));
  computations.endAll();
}

TEST(RequestQueue, RequestsBeginInTheirOrder) {
  constexpr int kRequests = 100;
  std::vector<int> order;  // one thread at a time uses it
  std::promise<void> last;
  RequestQueue queue(0, {1, kForever});
  for (int i = 0; i < kRequests; ++i) {
    queue.addCallback(callbackOf([&, i] {
                        order.push_back(i);
                        if (i == kRequests - 1) last.set_value();
                      }),
                      1);
  }
  last.get_future().wait();
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  EXPECT_EQ(order.size(), static_cast<std::size_t>(kRequests));
}

}  // namespace proximity_server::node::request_queue_test
