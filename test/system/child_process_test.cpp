#include "system/child_process.h"

#include "sanitized.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <future>
#include <stdexcept>
#include <thread>
#include <vector>

namespace proximity_server::system::child_process_test {

using std::chrono::seconds;

// A sanitizer ends the child itself, with an exit code of its own.
#ifdef PROXIMITY_SANITIZED
const char* const kOutOfMemory = "";
#else
const char* const kOutOfMemory = "it takes more than 64 MiB of memory";
#endif

constexpr ProcessLimits kLimits{std::size_t{64} << 20, seconds(2), seconds(60), 1000};

/// What answerOfChild() throws, "" where it throws nothing.
std::string errorOfChild(const std::function<std::string()>& work, const ProcessLimits& limits = kLimits) {
  try {
    answerOfChild(work, limits);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

std::ptrdiff_t openDescriptors() {
  const std::filesystem::directory_iterator all("/proc/self/fd");
  return std::distance(begin(all), end(all));
}

/// After each test there is no child and no descriptor that was not there before.
class ChildProcess : public ::testing::Test {
 protected:
  ~ChildProcess() override {
    EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
    EXPECT_EQ(errno, ECHILD);
    EXPECT_EQ(openDescriptors(), before_);
  }

 private:
  std::ptrdiff_t before_ = openDescriptors();
};

volatile std::size_t sink = 0;

std::string allocateForEver() {
  for (std::vector<std::vector<char>> all;; sink = all.size()) all.emplace_back(1 << 16, 'x');
}

std::string allocateAtOnce() {
  sink = std::string(std::size_t{1} << 40, 'x').size();
  return "all of it";
}

std::string computeForEver() {
  while (true) sink = sink + 1;
}

/// For ever as `sink` stays small, which the compiler cannot know.
int recurseForEver(volatile char* caller) {
  volatile char here[1024];
  here[0] = *caller;
  return sink == 123456789 ? 0 : recurseForEver(here) + here[0];
}

TEST_F(ChildProcess, AnswersWithAllBytes) {
  const std::string bytes = std::string("a\0b", 3) + std::string(997, 'x');
  EXPECT_EQ(answerOfChild([&] { return bytes; }, kLimits), bytes);
  EXPECT_EQ(answerOfChild([] { return ""; }, kLimits), "");
}

TEST_F(ChildProcess, ChangesNothingHere) {
  sink = 7;
  answerOfChild([] { return sink = 8, ""; }, kLimits);
  EXPECT_EQ(sink, 7U);
}

TEST_F(ChildProcess, SaysWhatItsWorkThrew) {
  EXPECT_EQ(errorOfChild([]() -> std::string { throw std::invalid_argument("no such thing"); }), "no such thing");
}

TEST_F(ChildProcess, SaysBySizeAndTimeWhatWasTooMuch) {
  EXPECT_NE(errorOfChild(allocateForEver).find(kOutOfMemory), std::string::npos);
  EXPECT_NE(errorOfChild(allocateAtOnce).find(kOutOfMemory), std::string::npos);
  EXPECT_EQ(errorOfChild(computeForEver, {std::size_t{64} << 20, seconds(1), seconds(600), 1000}),
            "it takes more than 1 s of processor time");
  EXPECT_EQ(errorOfChild([] { return sleep(1000), ""; }, {std::size_t{64} << 20, seconds(60), seconds(1), 1000}),
            "it takes longer than 1 s");
  EXPECT_EQ(errorOfChild([] { return std::string(1001, 'x'); }), "its answer has 1001 bytes, more than 1000");
}

TEST_F(ChildProcess, EndsOnceTheFlagIsSet) {
  std::atomic<bool> stop{false};
  const std::future<void> setter = std::async(std::launch::async, [&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    stop = true;
  });
  EXPECT_EQ(errorOfChild(computeForEver, {std::size_t{64} << 20, seconds(60), seconds(60), 1000, &stop}),
            "it is stopped");
}

TEST_F(ChildProcess, SaysHowItCrashed) {
  EXPECT_EQ(errorOfChild([] { return raise(SIGSEGV), ""; }), "it crashes: Segmentation fault");
  EXPECT_EQ(errorOfChild([] { return abort(), ""; }), "it crashes: Aborted");
  EXPECT_EQ(errorOfChild([] { return _exit(0), ""; }), "it ends without an answer, with exit code 0");
  EXPECT_EQ(errorOfChild([] { return _exit(9), ""; }), "it ends without an answer, with exit code 9");
}

TEST_F(ChildProcess, EndlessRecursionIsACrash) {
  const auto recurse = [] {
    volatile char first = 0;
    return std::to_string(recurseForEver(&first));
  };
  EXPECT_EQ(errorOfChild(recurse), "it crashes: Segmentation fault");
}

// As a library of the process may do it. Nobody then knows how the child ended, but its answer is here all the same.
TEST_F(ChildProcess, AnswersWhereEndedChildrenVanish) {
  const auto before = signal(SIGCHLD, SIG_IGN);
  EXPECT_EQ(answerOfChild([] { return "here"; }, kLimits), "here");
  EXPECT_EQ(errorOfChild([] { return _exit(9), ""; }), "it ends without an answer");
  signal(SIGCHLD, before);
}

TEST_F(ChildProcess, HasNoDescriptorOfOurs) {
  const int ours = open("/dev/null", O_RDONLY);
  const auto isOpen = [&] { return std::string(fcntl(ours + 10, F_GETFD) < 0 ? "closed" : "open"); };
  ASSERT_EQ(dup2(ours, ours + 10), ours + 10);
  EXPECT_EQ(isOpen(), "open");
  EXPECT_EQ(answerOfChild(isOpen, kLimits), "closed");
  close(ours + 10);
  close(ours);
}

TEST_F(ChildProcess, SignalsDoNotDisturbThePipe) {
  static std::atomic<int> alarms{0};
  const auto before = signal(SIGALRM, [](int) { ++alarms; });
  const itimerval often{{0, 1000}, {0, 1000}}, never{};
  setitimer(ITIMER_REAL, &often, nullptr);
  const ProcessLimits limits{std::size_t{64} << 20, seconds(10), seconds(60), 10000000};
  for (int i = 0; i < 20; ++i) EXPECT_EQ(answerOfChild([] { return std::string(8000000, 'x'); }, limits).size(), 8e6);
  setitimer(ITIMER_REAL, &never, nullptr);
  signal(SIGALRM, before);
  EXPECT_GT(alarms, 0);
}

// Other threads hold the locks of malloc, stdio and the unwinder at the moment of many of these forks.
TEST_F(ChildProcess, AnswersInAProcessOfManyBusyThreads) {
#ifdef PROXIMITY_ADDRESS_SANITIZED
  GTEST_SKIP() << kNoForkBesideThreads;
#endif
  std::atomic<bool> done{false};
  std::vector<std::thread> busy, asking;
  for (int i = 0; i < 2; ++i) {
    busy.emplace_back([&] {
      while (!done) {
        try {
          throw std::invalid_argument(std::string(100, 'x'));
        } catch (const std::invalid_argument& error) {
          sink = std::to_string(std::string(error.what()).size()).size();
        }
      }
    });
  }
  for (int i = 0; i < 4; ++i) {
    asking.emplace_back([i] {
      const auto work = [i]() -> std::string {
        try {
          throw std::invalid_argument("thread ");
        } catch (const std::invalid_argument& error) {
          return error.what() + std::to_string(i);
        }
      };
      for (int k = 0; k < 50; ++k) EXPECT_EQ(answerOfChild(work, kLimits), "thread " + std::to_string(i));
    });
  }
  for (std::thread& thread : asking) thread.join();
  done = true;
  for (std::thread& thread : busy) thread.join();
}

// --- messages

TEST_F(ChildProcess, SendsMessagesUntilItsWorkIsDone) {
  std::vector<std::string> received;
  const auto work = [](const SendMessage& send) {
    for (const char* message : {"a", "", "b"}) send(message);
    send(std::string(1000000, 'c'));
  };
  EXPECT_EQ(messagesOfChild(work, [&](const std::string& message) { received.push_back(message); }), 0);
  EXPECT_EQ(received, (std::vector<std::string>{"a", "", "b", std::string(1000000, 'c')}));
}

TEST_F(ChildProcess, MessagesBeforeACrashAreThereWithItsSignal) {
  std::vector<std::string> received;
  const auto work = [](const SendMessage& send) {
    send("before");
    raise(SIGPROF);
    send("after");
  };
  EXPECT_EQ(messagesOfChild(work, [&](const std::string& message) { received.push_back(message); }), SIGPROF);
  EXPECT_EQ(received, std::vector<std::string>{"before"});
}

TEST_F(ChildProcess, EndsWhereWorkOrReceiverThrows) {
  const auto refuse = [](const std::string& message) { throw std::runtime_error("refused: " + message); };
  const auto sendForEver = [](const SendMessage& send) {
    while (true) send("x");
  };
  const auto fail = [](const SendMessage&) { throw std::invalid_argument("no such thing"); };
  const auto errorOf = [&](const std::function<void(const SendMessage&)>& work) -> std::string {
    try {
      messagesOfChild(work, refuse);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(errorOf(sendForEver), "refused: x");
  EXPECT_EQ(errorOf(fail), "no such thing");
}

}  // namespace proximity_server::system::child_process_test
