#include "tools/second_opinion/child_answers.h"

#include <sys/time.h>

#include <csignal>
#include <cstddef>
#include <cstring>
#include <string>

#include "system/child_process.h"

namespace proximity_server::tools {
namespace {

/// The processor time after which SIGPROF ends this process, counted from now.
void limitProcessorTime(int seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = seconds;
  setitimer(ITIMER_PROF, &timer, nullptr);
}

/// The end of a question and the bytes of its answer.
std::string messageOf(const std::function<void(void*)>& answer, std::size_t bytes) {
  std::string message(1 + bytes, '\0');
  try {
    // The answer is made where it is aligned.
    std::vector<std::max_align_t> room((bytes + sizeof(std::max_align_t) - 1) / sizeof(std::max_align_t));
    std::memset(room.data(), 0, room.size() * sizeof(std::max_align_t));
    answer(room.data());
    std::memcpy(message.data() + 1, room.data(), bytes);
    message[0] = static_cast<char>(ChildEnd::Answered);
  } catch (...) {
    message[0] = static_cast<char>(ChildEnd::Threw);
  }
  return message;
}

}  // namespace

std::vector<ChildEnd> answerInChildren(std::size_t count, std::size_t bytes, unsigned char* answers,
                                       const std::function<void(std::size_t, void*)>& answer, int limit_in_seconds) {
  std::vector<ChildEnd> ends;
  const auto work = [&](const system::SendMessage& send) {
    for (std::size_t question = ends.size(); question < count; ++question) {
      limitProcessorTime(limit_in_seconds);
      const std::string message = messageOf([&](void* room) { answer(question, room); }, bytes);
      limitProcessorTime(0);
      send(message);
    }
  };
  const auto receive = [&](const std::string& message) {
    std::memcpy(answers + ends.size() * bytes, message.data() + 1, bytes);
    ends.push_back(static_cast<ChildEnd>(message[0]));
  };
  while (ends.size() < count) {
    const int signal = system::messagesOfChild(work, receive);
    if (ends.size() < count) ends.push_back(signal == SIGPROF ? ChildEnd::Endless : ChildEnd::Aborted);
  }
  return ends;
}

}  // namespace proximity_server::tools
