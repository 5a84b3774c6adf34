#pragma once

#include <cstddef>
#include <functional>
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

/// Answers questions 0 to `count` - 1 one after the other in a child process, which has the memory of this one as it is now.
/// A question that ends the child is passed over: the next one is asked in a new child.
///
/// `answer` writes the answer of a question into so many bytes; what is not answered keeps them 0. It must not start
/// threads. Its standard output and error go nowhere. A child ends when its parent does.
/// Failure: throws std::system_error if there is no pipe or no process.
std::vector<ChildEnd> answerInChildren(std::size_t count, std::size_t bytes, unsigned char* answers,
                                       const std::function<void(std::size_t question, void* answer)>& answer,
                                       int limit_in_seconds);

/// The same with answers of one type.
template <typename Answer>
std::vector<ChildEnd> askInChildren(std::vector<Answer>& answers,
                                    const std::function<void(std::size_t question, Answer& answer)>& ask,
                                    int limit_in_seconds) {
  static_assert(std::is_trivially_copyable_v<Answer>);
  return answerInChildren(
      answers.size(), sizeof(Answer), reinterpret_cast<unsigned char*>(answers.data()),
      [&](std::size_t question, void* answer) { ask(question, *static_cast<Answer*>(answer)); }, limit_in_seconds);
}

}  // namespace proximity_server::tools
