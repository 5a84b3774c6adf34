#include "tools/second_opinion/child_answers.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <system_error>

namespace proximity_server::tools {
namespace {

using Answer = std::function<void(std::size_t, void*)>;

/// The processor time after which SIGPROF ends this process, counted from now.
void limitProcessorTime(int seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = seconds;
  setitimer(ITIMER_PROF, &timer, nullptr);
}

void beQuiet() {
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  const int nowhere = open("/dev/null", O_WRONLY);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO})
    if (nowhere >= 0) dup2(nowhere, stream);
  for (const int signal : {SIGABRT, SIGPROF, SIGSEGV, SIGFPE, SIGPIPE}) std::signal(signal, SIG_DFL);
}

bool writeAll(int pipe, const unsigned char* bytes, std::size_t size) {
  for (std::size_t done = 0; done < size;) {
    const ssize_t written = write(pipe, bytes + done, size - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    done += static_cast<std::size_t>(written);
  }
  return true;
}

/// False at the end of what was written, whole or not.
bool readAll(int pipe, unsigned char* bytes, std::size_t size) {
  for (std::size_t done = 0; done < size;) {
    const ssize_t got = read(pipe, bytes + done, size - done);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    done += static_cast<std::size_t>(got);
  }
  return true;
}

/// The life of a child. A message is the end of a question and the bytes of its answer.
[[noreturn]] void live(int pipe, std::size_t first, std::size_t count, std::size_t bytes, const Answer& answer,
                       int limit) {
  beQuiet();
  std::vector<unsigned char> message(1 + bytes);
  for (std::size_t question = first; question < count; ++question) {
    std::memset(message.data(), 0, message.size());
    limitProcessorTime(limit);
    try {
      // The answer is made where it is aligned.
      std::vector<std::max_align_t> room((bytes + sizeof(std::max_align_t) - 1) / sizeof(std::max_align_t));
      std::memset(room.data(), 0, room.size() * sizeof(std::max_align_t));
      answer(question, room.data());
      std::memcpy(message.data() + 1, room.data(), bytes);
      message[0] = static_cast<unsigned char>(ChildEnd::Answered);
    } catch (...) {
      message[0] = static_cast<unsigned char>(ChildEnd::Threw);
    }
    limitProcessorTime(0);
    if (!writeAll(pipe, message.data(), message.size())) break;
  }
  _exit(0);  // no destructors: all belongs to the parent
}

[[noreturn]] void fail(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

/// How a child ended that did not answer its question.
ChildEnd endOf(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFSIGNALED(status) && WTERMSIG(status) == SIGPROF ? ChildEnd::Endless : ChildEnd::Aborted;
}

}  // namespace

std::vector<ChildEnd> answerInChildren(std::size_t count, std::size_t bytes, unsigned char* answers,
                                       const Answer& answer, int limit_in_seconds) {
  std::vector<ChildEnd> ends;
  ends.reserve(count);  // nothing may throw while there is a child
  std::vector<unsigned char> message(1 + bytes);
  while (ends.size() < count) {
    int ends_of_pipe[2];
    if (pipe2(ends_of_pipe, O_CLOEXEC) != 0) fail("a pipe to another library");
    const pid_t child = fork();
    if (child == 0) {
      close(ends_of_pipe[0]);  // so that writing ends the child once the parent is gone
      live(ends_of_pipe[1], ends.size(), count, bytes, answer, limit_in_seconds);
    }
    close(ends_of_pipe[1]);
    if (child < 0) {
      close(ends_of_pipe[0]);
      fail("a process for another library");
    }
    while (ends.size() < count && readAll(ends_of_pipe[0], message.data(), message.size())) {
      std::memcpy(answers + ends.size() * bytes, message.data() + 1, bytes);
      ends.push_back(static_cast<ChildEnd>(message[0]));
    }
    close(ends_of_pipe[0]);
    const ChildEnd end = endOf(child);
    if (ends.size() < count) ends.push_back(end);
  }
  return ends;
}

}  // namespace proximity_server::tools
