#pragma once

#include "system/child_process.h"

#include <sys/time.h>

#include <csignal>
#include <cstddef>
#include <cstring>
#include <functional>
#include <string>
#include <type_traits>
#include <vector>

namespace proximity_server::tools {

/// How a question ended that was asked in a child process.
enum class ChildEnd : unsigned char {
  Answered,
  Threw,    ///< an exception
  Aborted,  ///< the process ended: a failed assertion, a segmentation fault
  Endless   ///< more processor time than the limit
};

/// SIGPROF ends this process after so much processor time from now on; 0: it does not.
inline void limitProcessorTime(int seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = seconds;
  setitimer(ITIMER_PROF, &timer, nullptr);
}

/// Asks for all answers one after the other in a child process, which has the memory of this one as it is now.
/// A question that ends the child is passed over: the next one is asked in a new child.
///
/// Questions are numbered from 0; an answer that does not come stays as it is. `ask` must not start threads. Its
/// standard output and error go nowhere. A child ends when its parent does.
/// Failure: throws std::system_error if there is no pipe or no process.
template <typename Answer>
std::vector<ChildEnd> askInChildren(std::vector<Answer>& answers,
                                    const std::function<void(std::size_t question, Answer& answer)>& ask,
                                    int limit_in_seconds) {
  static_assert(std::is_trivially_copyable_v<Answer>);
  std::vector<ChildEnd> ends;
  const auto work = [&](const system::SendMessage& send) {
    for (std::size_t question = ends.size(); question < answers.size(); ++question) {
      Answer answer{};
      ChildEnd end = ChildEnd::Answered;
      limitProcessorTime(limit_in_seconds);
      try {
        ask(question, answer);
      } catch (...) {
        answer = {};
        end = ChildEnd::Threw;
      }
      limitProcessorTime(0);
      std::string message(1 + sizeof answer, static_cast<char>(end));
      std::memcpy(message.data() + 1, &answer, sizeof answer);
      send(message);
    }
  };
  const auto receive = [&](const std::string& message) {
    std::memcpy(&answers[ends.size()], message.data() + 1, sizeof(Answer));
    ends.push_back(static_cast<ChildEnd>(message[0]));
  };
  while (ends.size() < answers.size()) {
    const int signal = system::messagesOfChild(work, receive);
    if (ends.size() < answers.size()) ends.push_back(signal == SIGPROF ? ChildEnd::Endless : ChildEnd::Aborted);
  }
  return ends;
}

}  // namespace proximity_server::tools
