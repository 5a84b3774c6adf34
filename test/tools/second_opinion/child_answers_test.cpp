#include "tools/second_opinion/child_answers.h"

#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <thread>

namespace proximity_server::tools::child_answers_test {

constexpr int kLimit = 1;  // [s]

struct Square {
  double value;
  int question;
};

TEST(ChildAnswers, ComeInTheOrderOfTheQuestions) {
  std::vector<Square> answers(10000);
  const auto ends = askInChildren<Square>(
      answers,
      [](std::size_t question, Square& answer) {
        const auto number = static_cast<double>(question);
        answer = {number * number, static_cast<int>(question)};
      },
      kLimit);
  ASSERT_EQ(ends.size(), answers.size());
  for (std::size_t i = 0; i < answers.size(); ++i) {
    EXPECT_EQ(ends[i], ChildEnd::Answered);
    EXPECT_EQ(answers[i].question, static_cast<int>(i));
    EXPECT_EQ(answers[i].value, static_cast<double>(i * i));
  }
}

TEST(ChildAnswers, AQuestionThatEndsTheChildIsPassedOver) {
  std::vector<Square> answers(6);
  const auto ends = askInChildren<Square>(
      answers,
      [](std::size_t question, Square& answer) {
        if (question == 0 || question == 3) std::abort();
        if (question == 4) throw std::logic_error("no");
        for (volatile bool is_endless = question == 1; is_endless;) {
        }
        answer = {1.0, static_cast<int>(question)};
      },
      kLimit);
  EXPECT_EQ(ends, (std::vector<ChildEnd>{ChildEnd::Aborted, ChildEnd::Endless, ChildEnd::Answered, ChildEnd::Aborted,
                                         ChildEnd::Threw, ChildEnd::Answered}));
  EXPECT_EQ(answers[2].question, 2);
  EXPECT_EQ(answers[3].value, 0.0);
  EXPECT_EQ(answers[5].question, 5);
}

// Regression: a child held the end of the pipe that its parent reads, and waited for ever once the pipe was full.
TEST(ChildAnswers, AChildEndsWhenItsParentIsKilled) {
  ASSERT_EQ(prctl(PR_SET_CHILD_SUBREAPER, 1), 0);  // the child of a child that is killed becomes ours
  const pid_t parent = fork();
  if (parent == 0) {
    std::vector<Square> answers(100000);  // more than a pipe holds
    askInChildren<Square>(
        answers,
        [&](std::size_t question, Square&) {
          if (question == 0) kill(getppid(), SIGKILL);
        },
        kLimit);
    _exit(1);
  }
  ASSERT_EQ(waitpid(parent, nullptr, 0), parent);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  pid_t child = 0;
  while ((child = waitpid(-1, nullptr, WNOHANG)) == 0 && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_GT(child, 0) << "the child lives on";
  prctl(PR_SET_CHILD_SUBREAPER, 0);
}

TEST(ChildAnswers, NoQuestionNeedsNoChild) {
  std::vector<Square> none;
  EXPECT_TRUE(askInChildren<Square>(
                  none, [](std::size_t, Square&) { std::abort(); }, kLimit)
                  .empty());
}

}  // namespace proximity_server::tools::child_answers_test
