#include "system/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <vector>

namespace proximity_server::system {
namespace {

using Clock = std::chrono::steady_clock;

[[noreturn]] void failWithErrno(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

/// Precedes each message: its kind and its length.
struct Head {
  enum Kind : std::size_t { Message, End, Refusal };
  Kind kind;
  std::size_t size;  ///< [byte]
};

// --- in the child

constexpr int kOutOfMemory = 3;  // exit code
constexpr int kOutput = 3;       // the only descriptor of the child, after the standard ones

/// close_range() needs Linux 5.9 and glibc 2.34.
void closeAbove(int last) {
  std::error_code error;
  std::vector<int> open;
  for (std::filesystem::directory_iterator all("/proc/self/fd", error), end; !error && all != end;
       all.increment(error)) {
    open.push_back(std::stoi(all->path().filename()));
  }
  for (const int descriptor : open)
    if (descriptor > last) close(descriptor);
}

void keepOnly(int output) {
  dup2(output, kOutput);
  closeAbove(kOutput);
  close(STDIN_FILENO);
  open("/dev/null", O_RDWR);
  dup2(STDIN_FILENO, STDOUT_FILENO);
  dup2(STDIN_FILENO, STDERR_FILENO);
}

void forgetSignalHandlers() {
  for (int number = 1; number < NSIG; ++number) signal(number, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
}

void lowerLimit(decltype(RLIMIT_CPU) resource, rlim_t soft, rlim_t hard) {
  rlimit limit{};
  getrlimit(resource, &limit);
  limit = {std::min(soft, limit.rlim_cur), std::min(hard, limit.rlim_max)};
  if (setrlimit(resource, &limit) != 0) failWithErrno("setrlimit");
}

/// [byte] The memory that RLIMIT_DATA counts.
rlim_t dataInUse() {
  std::ifstream statm("/proc/self/statm");
  rlim_t size, resident, shared, text, library, data;  // in pages
  if (!(statm >> size >> resident >> shared >> text >> library >> data)) {
    throw std::runtime_error("its memory cannot be limited: /proc/self/statm cannot be read");
  }
  return data * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

void setLimits(const ProcessLimits& limits) {
  const rlim_t data = dataInUse() + limits.memory;
  lowerLimit(RLIMIT_DATA, data, data);
  // The soft limit ends the child by SIGXCPU. That distinguishes it from a child that was killed.
  const auto seconds = static_cast<rlim_t>(limits.processor_time.count());
  lowerLimit(RLIMIT_CPU, seconds, seconds + 1);
  // Ends an endless recursion, even if the stack has no limit.
  constexpr rlim_t kStack = rlim_t{64} << 20;
  lowerLimit(RLIMIT_STACK, kStack, kStack);
  std::set_new_handler([] { _exit(kOutOfMemory); });
}

void send(const char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t sent = write(kOutput, bytes, size);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) _exit(EXIT_FAILURE);
    bytes += sent;
    size -= static_cast<std::size_t>(sent);
  }
}

void send(Head::Kind kind, std::string_view text) {
  const Head head{kind, text.size()};
  send(reinterpret_cast<const char*>(&head), sizeof head);
  send(text.data(), text.size());
}

/// A child that is forked while another thread unwinds its stack has a lock that nobody releases, and hangs at its first
/// exception: with glibc before 2.35. So it has one before it says that it begins.
void sayThatItBegins() {
  try {
    throw 0;
  } catch (int) {
    send("", 1);
  }
}

/// Leaves by _exit(), because functions that are registered with atexit() belong to the parent.
[[noreturn]] void beChild(int output, const std::function<void()>& work) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // the child does not outlive the thread that waits for it
  keepOnly(output);
  forgetSignalHandlers();
  sayThatItBegins();
  try {
    lowerLimit(RLIMIT_CORE, 0, 0);
    work();
    send(Head::End, "");
  } catch (const std::bad_alloc&) {
    _exit(kOutOfMemory);
  } catch (const std::exception& error) {
    send(Head::Refusal, error.what());
  }
  _exit(EXIT_SUCCESS);
}

// --- in the parent

struct Pipe {
  Pipe() {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) failWithErrno("no pipe");
    input = ends[0];
    output = ends[1];
  }
  ~Pipe() {
    close(input);
    closeOutput();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void closeOutput() {
    if (output >= 0) close(output);
    output = -1;
  }
  int input, output;
};

class Reader {
 public:
  /// Without a deadline, it waits for ever. `stop`: see ProcessLimits.
  explicit Reader(int input, std::optional<Clock::time_point> deadline = std::nullopt,
                  const std::atomic<bool>* stop = nullptr)
      : input_(input), deadline_(deadline), stop_(stop) {}

  enum class End { Complete, TooEarly, TooLate };
  End read(char* bytes, std::size_t size) const {
    while (size > 0) {
      if (!awaitBytes()) return End::TooLate;
      const ssize_t got = ::read(input_, bytes, size);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return End::TooEarly;
      bytes += got;
      size -= static_cast<std::size_t>(got);
    }
    return End::Complete;
  }

 private:
  /// Waits until there is something to read, or until the end of the pipe. Returns false after the deadline, and
  /// once the flag is set.
  bool awaitBytes() const {
    constexpr int kPeriod = 50;  // [ms] of looking at the flag
    while (true) {
      if (stop_ && *stop_) return false;
      int left = -1;  // [ms] the time that is left
      if (deadline_)
        left = static_cast<int>(std::chrono::ceil<std::chrono::milliseconds>(*deadline_ - Clock::now()).count());
      if (deadline_ && left <= 0) return false;
      if (stop_ && (left < 0 || left > kPeriod)) left = kPeriod;
      pollfd one{input_, POLLIN, 0};
      const int ready = poll(&one, 1, left);
      if (ready > 0) return true;
      if (ready < 0 && errno != EINTR) failWithErrno("poll");
    }
  }

  int input_;
  std::optional<Clock::time_point> deadline_;
  const std::atomic<bool>* stop_;
};

/// Forks while all signals are blocked, because the handlers of this process must not run in the child.
pid_t forkSilently() {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const pid_t child = fork();
  const int error = errno;
  if (child != 0) pthread_sigmask(SIG_SETMASK, &before, nullptr);
  errno = error;
  return child;
}

/// A child process that does some work. It has ended and is collected when this object is destroyed.
class Child {
 public:
  explicit Child(const std::function<void()>& work) {
    id_ = forkSilently();
    if (id_ < 0) failWithErrno("no child process");
    if (id_ == 0) beChild(pipe_.output, work);
    pipe_.closeOutput();
  }
  ~Child() { end(); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  int input() const { return pipe_.input; }

  /// Waits until it begins, see sayThatItBegins(). False if it has not by then.
  bool beginsWithin(std::chrono::seconds time) const {
    char begin = 0;
    return Reader(input(), Clock::now() + time).read(&begin, 1) != Reader::End::TooLate;
  }

  /// Returns its status as waitpid() gives it; -1 if another part of the program has collected it. The kill has no
  /// effect on a child that has ended by itself.
  int end() {
    if (id_ < 0) return status_;
    kill(id_, SIGKILL);
    while (waitpid(id_, &status_, 0) < 0) {
      if (errno == EINTR) continue;
      status_ = -1;
      break;
    }
    id_ = -1;
    return status_;
  }

 private:
  Pipe pipe_;
  pid_t id_;
  int status_ = -1;
};

/// The name of a signal in English; nullptr if it has none.
const char* signalName(int number) {
#if __GLIBC_PREREQ(2, 32)
  return sigdescr_np(number);
#else
  return number > 0 && number < NSIG ? sys_siglist[number] : nullptr;  // a later glibc has no such table
#endif
}

/// Replaces a child that does not begin. Each next one has more time, in case that the machine is busy.
std::unique_ptr<Child> startChild(const std::function<void()>& work) {
  for (int patience = 1; patience <= 10; ++patience) {
    auto child = std::make_unique<Child>(work);
    if (child->beginsWithin(std::chrono::seconds(patience))) return child;
  }
  throw std::runtime_error("no child process begins its work");
}

std::string describeEnding(int status, const ProcessLimits& limits) {
  if (status == -1) return "it ends without an answer";
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) {
    return "it takes more than " + std::to_string(limits.processor_time.count()) + " s of processor time";
  }
  if (WIFSIGNALED(status)) {
    const char* name = signalName(WTERMSIG(status));
    return std::string("it crashes: ") + (name ? name : "unknown signal");
  }
  if (WEXITSTATUS(status) == kOutOfMemory) {
    return "it takes more than " + std::to_string(limits.memory >> 20) + " MiB of memory";
  }
  return "it ends without an answer, with exit code " + std::to_string(WEXITSTATUS(status));
}

/// Reads all of `bytes`. If that fails, throws an error that tells how the child ended.
void receive(char* bytes, std::size_t size, const Reader& reader, Child& child, const ProcessLimits& limits) {
  switch (reader.read(bytes, size)) {
    case Reader::End::Complete:
      return;
    case Reader::End::TooLate:
      if (limits.stop && *limits.stop) throw std::runtime_error("it is stopped");
      throw std::runtime_error("it takes longer than " + std::to_string(limits.time.count()) + " s");
    case Reader::End::TooEarly:
      throw std::runtime_error(describeEnding(child.end(), limits));
  }
}

}  // namespace

std::string answerOfChild(const std::function<std::string()>& work, const ProcessLimits& limits) {
  const auto child = startChild([&] {
    setLimits(limits);
    send(Head::Message, work());
  });
  // Read to the stated length, not to the end of the pipe: a child that another thread makes may hold the pipe open.
  const Reader reader(child->input(), Clock::now() + limits.time, limits.stop);
  Head head{};
  receive(reinterpret_cast<char*>(&head), sizeof head, reader, *child, limits);
  if (head.size > limits.answer) {
    throw std::runtime_error("its answer has " + std::to_string(head.size) + " bytes, more than " +
                             std::to_string(limits.answer));
  }
  std::string text(head.size, '\0');
  receive(text.data(), text.size(), reader, *child, limits);
  if (head.kind != Head::Message) throw std::runtime_error(text);
  return text;
}

int messagesOfChild(const std::function<void(const SendMessage&)>& work,
                    const std::function<void(const std::string&)>& receive) {
  const auto child = startChild([&] { work([](std::string_view message) { send(Head::Message, message); }); });
  const Reader reader(child->input());
  const auto readAll = [&](void* bytes, std::size_t size) {
    return reader.read(static_cast<char*>(bytes), size) == Reader::End::Complete;
  };
  for (Head head{}; readAll(&head, sizeof head);) {
    std::string text(head.size, '\0');
    if (!readAll(text.data(), text.size())) break;
    if (head.kind == Head::End) return 0;
    if (head.kind == Head::Refusal) throw std::runtime_error(text);
    receive(text);
  }
  const int status = child->end();
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

}  // namespace proximity_server::system
