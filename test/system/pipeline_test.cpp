#include "system/pipeline.h"

#include "sanitized.h"

#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>

namespace proximity_server::system::pipeline_test {

struct Block {
  int number = -1;
  int answer = -1;
};

constexpr int kThreads = 4;

std::vector<int> firstNumbers(int count) {
  std::vector<int> numbers(static_cast<std::size_t>(count));
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

/// Work that takes another time for each block.
int slowly(int number) {
  int sum = number;
  for (int i = 0; i < (number * 7919) % 2000; ++i) sum = (sum * 31 + i) % 1000003;
  return sum;
}

/// Reads `count` numbers.
std::function<bool(Block&)> numbers(int count) {
  return [count, next = 0](Block& block) mutable {
    if (next == count) return false;
    block.number = next++;
    return true;
  };
}

const auto kAnswer = [](Block& block, int) { block.answer = slowly(block.number); };

/// What is written of `count` blocks until the error of a step, and the text of that.
struct Outcome {
  std::vector<int> written;
  std::string error;
};
Outcome outcomeOf(const PipelineSteps<Block>& steps, int threads) {
  Outcome outcome;
  PipelineSteps<Block> noted = steps;
  noted.write = [&](Block& block) {
    if (steps.write) steps.write(block);
    outcome.written.push_back(block.number);
  };
  try {
    runPipeline(noted, {threads});
  } catch (const std::runtime_error& error) {
    outcome.error = error.what();
  }
  return outcome;
}

void failAt(int number, const Block& block) {
  if (block.number == number) throw std::runtime_error("block " + std::to_string(number));
}

TEST(Pipeline, WritesEachBlockOnceAndInOrder) {
  const int count = repeats(3000);
  for (const int threads : {1, 2, kThreads, 50}) {
    const auto check = [](Block& block) { EXPECT_EQ(block.answer, slowly(block.number)); };
    EXPECT_EQ(outcomeOf({numbers(count), kAnswer, check}, threads).written, firstNumbers(count)) << threads;
  }
}

TEST(Pipeline, WithoutBlocksNothingIsWorkedOn) {
  const auto work = [](Block&, int) { ADD_FAILURE(); };
  for (const int threads : {1, kThreads}) EXPECT_TRUE(outcomeOf({numbers(0), work}, threads).written.empty());
}

TEST(Pipeline, UsesBlocksAgainAndReadsOnlyFewAhead) {
  for (const int blocks : {1, 4}) {
    std::set<const Block*> used;
    std::atomic<int> read{0}, written{0};
    const auto readOne = [&](Block& block) {
      used.insert(&block);
      EXPECT_LT(read - written, blocks * kThreads);
      return ++read <= 1000;
    };
    runPipeline<Block>({readOne, [](Block&, int) {}, [&](Block&) { ++written; }},
                       {kThreads, PipelineThreads::TooFew::Refused, blocks});
    EXPECT_EQ(written, 1000);
    EXPECT_LE(used.size(), static_cast<std::size_t>(blocks * kThreads));
  }
}

TEST(Pipeline, OneStepOfReadingAndOneOfWritingAtATimeAndNoTwoOfOneThread) {
  std::atomic<int> reading{0}, writing{0};
  std::vector<std::atomic<int>> working(kThreads);
  const auto alone = [](std::atomic<int>& busy, int number) {
    EXPECT_EQ(busy.exchange(1), 0);
    slowly(number);
    busy = 0;
  };
  const auto read = [&, next = numbers(repeats(1000))](Block& block) {
    alone(reading, block.number);
    return next(block);
  };
  const auto work = [&](Block& block, int thread) { alone(working.at(thread), block.number); };
  runPipeline<Block>({read, work, [&](Block& block) { alone(writing, block.number); }}, {kThreads});
}

TEST(Pipeline, TheCallingThreadHasTheNumberZeroAndOneThreadStartsNone) {
  const std::thread::id caller = std::this_thread::get_id();
  for (const int threads : {1, kThreads}) {
    const auto work = [&](Block&, int thread) {
      EXPECT_EQ(thread == 0, std::this_thread::get_id() == caller);
      EXPECT_LT(thread, threads);
    };
    runPipeline<Block>({numbers(100), work}, {threads});
  }
}

TEST(Pipeline, AllThreadsWorkAtTheSameTime) {
  std::mutex mutex;
  std::condition_variable changed;
  std::set<int> met;
  const auto work = [&](Block&, int thread) {
    std::unique_lock lock(mutex);
    met.insert(thread);
    changed.notify_all();
    changed.wait(lock, [&] { return met.size() == kThreads; });
  };
  runPipeline<Block>({numbers(kThreads), work}, {kThreads});
}

TEST(Pipeline, WithoutWritingABlockThatTakesLongStopsNoOther) {
  constexpr int kCount = 100;  // more than there are blocks
  std::mutex mutex;
  std::condition_variable changed;
  int done = 0;
  const auto work = [&](Block& block, int) {
    std::unique_lock lock(mutex);
    ++done;
    changed.notify_all();
    if (block.number == 0) changed.wait(lock, [&] { return done == kCount; });
  };
  runPipeline<Block>({numbers(kCount), work}, {2});
  EXPECT_EQ(done, kCount);
}

TEST(Pipeline, AnErrorOfReadingComesAfterTheBlocksBeforeIt) {
  const auto read = [next = numbers(1000)](Block& block) {
    next(block);
    failAt(20, block);
    return true;
  };
  for (const int threads : {1, kThreads}) {
    const Outcome outcome = outcomeOf({read, kAnswer}, threads);
    EXPECT_EQ(outcome.written, firstNumbers(20));
    EXPECT_EQ(outcome.error, "block 20");
  }
}

TEST(Pipeline, AnErrorOfWorkingOrWritingComesAfterTheBlocksBeforeItAndEndsTheReading) {
  for (const bool in_work : {true, false}) {
    for (const int threads : {1, kThreads}) {
      std::atomic<int> read{0};
      const auto readOne = [&](Block& block) {
        block.number = read++;
        return true;  // without an end
      };
      const auto work = [&](Block& block, int) { in_work ? failAt(10, block) : void(); };
      const auto write = [&](Block& block) { in_work ? void() : failAt(10, block); };
      const Outcome outcome = outcomeOf({readOne, work, write}, threads);
      EXPECT_EQ(outcome.written, firstNumbers(10));
      EXPECT_EQ(outcome.error, "block 10");
      EXPECT_LE(read, 10 + 4 * threads + 1);
    }
  }
}

TEST(Pipeline, OfTwoErrorsTheFirstInOrderIsThrownThoughItComesLater) {
  std::atomic<bool> has_failed{false};
  const auto work = [&](Block& block, int) {
    while (block.number == 0 && !has_failed) std::this_thread::yield();
    if (block.number == 1) has_failed = true;
    throw std::runtime_error("block " + std::to_string(block.number));
  };
  const Outcome outcome = outcomeOf({numbers(100), work}, 2);
  EXPECT_EQ(outcome.error, "block 0");
  EXPECT_TRUE(outcome.written.empty());
}

TEST(Pipeline, ReadingThatEndsItLeavesWhatWasRead) {
  std::atomic<bool> goes_on{true};
  std::atomic<int> read{0};
  const auto readOne = [&](Block& block) {
    if (!goes_on) return false;
    block.number = read++;
    return true;
  };
  const auto work = [&](Block& block, int) {
    if (block.number == 30) goes_on = false;
  };
  const Outcome outcome = outcomeOf({readOne, work}, kThreads);
  EXPECT_EQ(outcome.written, firstNumbers(read));
  EXPECT_GE(read, 31);
  EXPECT_LE(read, 31 + 4 * kThreads);
}

// --- answerInBlocks

std::vector<int> tenTimes(const std::vector<int>& items) {
  std::vector<int> answers;
  for (const int item : items) answers.push_back(10 * item);
  return answers;
}

TEST(AnswerInBlocks, AllItemsInBlocksOfOneSizeButTheLast) {
  for (const int threads : {1, kThreads}) {
    std::vector<int> handled;
    std::mutex mutex;
    std::multiset<std::size_t> sizes;
    const auto answer = [&](const std::vector<int>& items) {
      const std::lock_guard lock(mutex);
      sizes.insert(items.size());
      return tenTimes(items);
    };
    int next = 0;
    const auto read = [&](int& item) {
      item = next++;
      return item < 10;
    };
    answerInBlocks<int, int>({4, read, answer, [&](int found) { handled.push_back(found); }}, threads);
    EXPECT_EQ(handled, tenTimes(firstNumbers(10)));
    EXPECT_EQ(sizes, (std::multiset<std::size_t>{2, 4, 4}));
  }
}

TEST(AnswerInBlocks, AnErrorOfReadingComesAfterTheAnswersAboutAllItemsBeforeIt) {
  for (const int bad : {0, 4, 6}) {
    std::vector<int> handled;
    int next = 0;
    const auto read = [&](int& item) {
      if (next == bad) throw std::invalid_argument("item " + std::to_string(bad));
      item = next++;
      return true;
    };
    EXPECT_THROW(
        (answerInBlocks<int, int>({4, read, tenTimes, [&](int found) { handled.push_back(found); }}, kThreads)),
        std::invalid_argument);
    EXPECT_EQ(handled, tenTimes(firstNumbers(bad)));
  }
}

}  // namespace proximity_server::system::pipeline_test
