#include <proximity_server/Clearance.h>
#include <proximity_server/MinimumDistance.h>
#include "node/answers.h"
#include "node/faults/running_node.h"
#include "node/gantry.h"

#include <atomic>
#include <csignal>
#include <thread>
#include <vector>

// The node is killed in the middle of calls, and roslaunch starts it again.

namespace proximity_server::node::respawn_test {

// What is promised.
constexpr std::chrono::seconds kCallEnds{5};    // after the node was killed, with or without an answer
constexpr std::chrono::seconds kBackAgain{10};  // a level and answers, from a new process

constexpr std::uint64_t kOfAge = 50;  // [cycles] a second: more than a new node has made when its first message comes
constexpr double kDistance = 0.2;     // [m] between base and ball
const std::string kNode = "/proximity_server";

bool isClear(const Clearance& message) {
  return message.level == Clearance::CLEAR && std::abs(message.minimum.distance - kDistance) <= kTolerance;
}

/// Asks without a pause, over one connection as long as it holds, until told to stop.
class Client {
 public:
  Client() : thread_([this] { run(); }) {}
  ~Client() {
    stop_ = true;
    thread_.join();
  }

  int answers() const { return answers_; }
  int failures() const { return failures_; }
  std::chrono::steady_clock::duration longestCall() const { return longest_; }

 private:
  void run() {
    while (!stop_) {
      if (!client_.isValid())
        client_ = ros::NodeHandle().serviceClient<MinimumDistance>(kNode + "/minimum_distance", true);
      call();
    }
  }

  void call() {
    MinimumDistance query;
    query.request.a = shape("base");
    query.request.b = shape("ball");
    const auto start = std::chrono::steady_clock::now();
    const bool answered = client_.call(query);
    longest_ = std::max(longest_.load(), std::chrono::steady_clock::now() - start);
    ++(answered ? answers_ : failures_);
    if (answered && query.response.success) {
      EXPECT_NEAR(query.response.pair.distance, kDistance, kTolerance);
    }
    if (answered) return;
    client_.shutdown();  // made while the master still knew the address of the dead, it would stay valid and useless
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }

  std::atomic<bool> stop_{false};
  std::atomic<int> answers_{0}, failures_{0};
  std::atomic<std::chrono::steady_clock::duration> longest_{std::chrono::steady_clock::duration::zero()};
  ros::ServiceClient client_;
  std::thread thread_;  // last: it uses all of the above
};

TEST(KilledNode, EndsTheCallsAndIsBackWithANewProcess) {
  Gantry gantry{ros::NodeHandle()};
  gantry.hold({kDistance + 0.2, 0.0, 0.0});
  Inbox<Clearance> inbox(ros::NodeHandle(), kNode + "/clearance");
  ASSERT_TRUE(inbox.next(isClear));

  Client first, second;
  for (int round = 0; round < 2; ++round) {
    const int answers = first.answers() + second.answers();
    std::uint64_t last_cycle = 0;
    ASSERT_TRUE(inbox.next([&](const Clearance& message) {
      last_cycle = message.cycle;
      return last_cycle > kOfAge && first.answers() + second.answers() > answers + 100;
    }));
    const pid_t process = processOf(kNode);
    ASSERT_GT(process, 0);
    ASSERT_EQ(kill(process, SIGKILL), 0);
    const auto killed = std::chrono::steady_clock::now();

    const auto back =
        inbox.next([&](const Clearance& message) { return message.cycle < last_cycle && isClear(message); });
    ASSERT_TRUE(back);
    EXPECT_LE(std::chrono::steady_clock::now() - killed, kBackAgain);
    EXPECT_NE(processOf(kNode), process);
  }
  const int answers = std::min(first.answers(), second.answers());
  EXPECT_TRUE(
      inbox.next([&](const Clearance&) { return std::min(first.answers(), second.answers()) > answers + 100; }));
  EXPECT_GT(first.failures() + second.failures(), 0) << "it was no test: no call was under way";
  EXPECT_LE(std::max(first.longestCall(), second.longestCall()), kCallEnds);
}

}  // namespace proximity_server::node::respawn_test
