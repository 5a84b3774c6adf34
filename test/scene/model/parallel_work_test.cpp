#include "scene/model/parallel_work.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

namespace proximity_server::scene::parallel_work_test {

using Tell = std::function<void(const std::string&)>;

const auto kNobody = [](int, const std::string&) {};

TEST(ParallelWork, EachNumberIsDoneOnce) {
  for (const int threads : {0, 1, 3, 50}) {
    std::vector<std::atomic<int>> done(20);
    workInParallel(
        20, threads, [&](int i, const Tell&) { ++done[static_cast<std::size_t>(i)]; }, kNobody);
    for (const auto& count : done) EXPECT_EQ(count, 1);
  }
}

TEST(ParallelWork, NothingToDoReturns) {
  workInParallel(
      0, 4, [](int, const Tell&) { ADD_FAILURE(); }, kNobody);
}

TEST(ParallelWork, IsToldByTheCallingThreadInTheOrderOfEach) {
  const std::thread::id caller = std::this_thread::get_id();
  std::vector<std::vector<std::string>> told(10);
  workInParallel(
      10, 4,
      [](int, const Tell& tell) {
        tell("begins");
        tell("ends");
      },
      [&](int i, const std::string& text) {
        EXPECT_EQ(std::this_thread::get_id(), caller);
        told[static_cast<std::size_t>(i)].push_back(text);
      });
  for (const auto& texts : told) EXPECT_EQ(texts, (std::vector<std::string>{"begins", "ends"}));
}

TEST(ParallelWork, WhatTheListenerThrowsEndsItAfterTheWorkThatHasBegun) {
  std::atomic<int> begun{0}, ended{0};
  const auto work = [&](int, const Tell& tell) {
    ++begun;
    tell("here");
    ++ended;
  };
  EXPECT_THROW(workInParallel(1000000, 2, work, [](int, const std::string&) { throw std::runtime_error("enough"); }),
               std::runtime_error);
  EXPECT_EQ(begun, ended);
  EXPECT_GE(begun, 1);
}

}  // namespace proximity_server::scene::parallel_work_test
