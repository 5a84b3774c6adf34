// The threads of a request queue.
#include "node/threads/request_queue.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <future>

namespace proximity_server::node::request_queue_test {

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

}  // namespace proximity_server::node::request_queue_test
