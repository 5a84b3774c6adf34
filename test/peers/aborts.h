#pragma once

#include <csetjmp>
#include <csignal>
#include <exception>
#include <optional>

namespace proximity_server::peers {

inline sigjmp_buf after_abort;
inline volatile std::sig_atomic_t abort_is_expected = 0;

inline void jumpOutOfAbort(int) {
  if (abort_is_expected) siglongjmp(after_abort, 1);
}

/// From now on an abort() inside of answerOf() ends the question, not the program.
inline void surviveAborts() {
  struct sigaction action {};
  action.sa_handler = jumpOutOfAbort;
  action.sa_flags = SA_NODEFER;  // the jump does not restore the mask
  sigaction(SIGABRT, &action, nullptr);
}

/// Returns what ask() returns, or nullopt if it throws or aborts: FCL's packages are built with assertions, which fail
/// on some pairs and would end the program. The jump leaks what the library held.
template <typename Ask>
auto answerOf(const Ask& ask) -> std::optional<decltype(ask())> {
  if (sigsetjmp(after_abort, 0) != 0) {
    abort_is_expected = 0;
    return std::nullopt;
  }
  abort_is_expected = 1;
  std::optional<decltype(ask())> answer;
  try {
    answer = ask();
  } catch (const std::exception&) {
    answer = std::nullopt;
  }
  abort_is_expected = 0;
  return answer;
}

}  // namespace proximity_server::peers
