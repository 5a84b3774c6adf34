#include "system/relay.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace proximity_server::system::relay_test {

TEST(Relay, CallsInTheCallingThreadInTheOrderOfEachOther) {
  const std::thread::id caller = std::this_thread::get_id();
  std::vector<std::string> called;
  runRelayed([&](const CallHere& callHere) {
    EXPECT_NE(std::this_thread::get_id(), caller);
    const auto tell = [&](const std::string& text) {
      callHere([&, text] {
        EXPECT_EQ(std::this_thread::get_id(), caller);
        called.push_back(text);
      });
    };
    tell("a begins");
    std::thread([&] { tell("b begins"); }).join();
    tell("a ends");
  });
  EXPECT_EQ(called, (std::vector<std::string>{"a begins", "b begins", "a ends"}));
}

TEST(Relay, WorkThatCallsNothingReturns) {
  bool is_done = false;
  runRelayed([&](const CallHere&) { is_done = true; });
  EXPECT_TRUE(is_done);
}

TEST(Relay, ThrowsWhatTheWorkThrowsAfterItsCalls) {
  int called = 0;
  const auto work = [&](const CallHere& callHere) {
    callHere([&] { ++called; });
    throw std::runtime_error("broken");
  };
  EXPECT_THROW(runRelayed(work), std::runtime_error);
  EXPECT_EQ(called, 1);
}

TEST(Relay, AfterACallThatThrowsThereIsNoOtherAndTheWorkEndsFirst) {
  int called = 0;
  bool has_ended = false;
  const auto work = [&](const CallHere& callHere) {
    for (int i = 0; i < 3; ++i) {
      callHere([&] {
        ++called;
        throw std::runtime_error("enough");
      });
    }
    has_ended = true;
  };
  EXPECT_THROW(runRelayed(work), std::runtime_error);
  EXPECT_EQ(called, 1);
  EXPECT_TRUE(has_ended);
}

TEST(Watch, IsCalledInTheCallingThreadUntilTheWorkIsDone) {
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<bool> is_watched{false};
  const auto work = [&] {
    EXPECT_NE(std::this_thread::get_id(), caller);
    while (!is_watched) std::this_thread::yield();
  };
  runWatched(work, [&] {
    EXPECT_EQ(std::this_thread::get_id(), caller);
    is_watched = true;
  });
  EXPECT_TRUE(is_watched);
}

TEST(Watch, ThrowsWhatTheWorkThrows) {
  EXPECT_THROW(runWatched([] { throw std::runtime_error("broken"); }, [] {}), std::runtime_error);
}

}  // namespace proximity_server::system::relay_test
