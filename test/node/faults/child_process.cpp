#include "node/faults/child_process.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <system_error>
#include <thread>

namespace proximity_server::node {
namespace {

/// Between two looks at a process that runs.
constexpr std::chrono::milliseconds kLook{5};

/// Between fork and exec only calls that are safe in a signal handler: other threads may have held locks.
[[noreturn]] void become(char* const* arguments) {
  execvp(arguments[0], arguments);
  _exit(127);
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& command) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_ = fork();
  if (pid_ < 0) throw std::system_error(errno, std::generic_category(), command.front());
  if (pid_ == 0) become(arguments.data());
}

ChildProcess::~ChildProcess() {
  signal(SIGKILL);
  hasEndedWithin(std::chrono::hours(1));
}

void ChildProcess::signal(int number) {
  if (!has_ended_) kill(pid_, number);
}

bool ChildProcess::hasEndedWithin(std::chrono::milliseconds patience) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  int status = 0;
  while (!has_ended_) {
    has_ended_ = waitpid(pid_, &status, WNOHANG) == pid_;
    if (has_ended_) {
      exit_code_ = WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
    } else if (std::chrono::steady_clock::now() >= deadline) {
      break;
    } else {
      std::this_thread::sleep_for(kLook);
    }
  }
  return has_ended_;
}

std::size_t ChildProcess::residentMemory() const {
  std::ifstream statm("/proc/" + std::to_string(pid_) + "/statm");
  std::size_t total = 0, resident = 0;
  if (has_ended_ || !(statm >> total >> resident)) return 0;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace proximity_server::node
