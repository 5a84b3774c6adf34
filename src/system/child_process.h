#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace proximity_server::system {

/// Whether a child may be made while other threads run: not with AddressSanitizer, whose malloc may stay locked in the child.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool kMayForkBesideThreads = false;
#elif !defined(__has_feature)
inline constexpr bool kMayForkBesideThreads = true;
#elif __has_feature(address_sanitizer)
inline constexpr bool kMayForkBesideThreads = false;
#else
inline constexpr bool kMayForkBesideThreads = true;
#endif

/// The limits on a child process.
struct ProcessLimits {
  std::size_t memory;                   ///< [byte] on top of what this process uses
  std::chrono::seconds processor_time;  ///< that the child computes
  std::chrono::seconds time;            ///< until its answer is here
  std::size_t answer;                   ///< [byte]
};

/// Runs `work` in a child process and returns its result. The child is a copy of this process, made by fork(). It may
/// crash, loop or run out of memory without any effect on this process. Of the file descriptors it has only the pipe of
/// its answer; it has neither the standard streams nor the signal handlers of this process. When the call returns, the
/// child has ended.
///
/// Thread-safe, and legal in a process with several threads, of which the child has only the calling one. Therefore
/// `work` must not need a lock that another thread may hold at that moment: no locks of this package, no logging, no
/// name look-up. It relies on glibc, whose fork() leaves malloc and stdio usable, and which unwinds exceptions without
/// a lock (2.35). If a lock is held nevertheless, e.g. that of std::locale::global(), the call ends after `time`.
///
/// Failure: throws std::runtime_error saying what `work` threw, or how the child ended: "it takes more than 1024 MiB of
///          memory", "it crashes: Segmentation fault"; std::system_error where no child can be made.
std::string answerOfChild(const std::function<std::string()>& work, const ProcessLimits& limits);

using SendMessage = std::function<void(std::string_view)>;

/// The same without limits, for work that sends any number of messages. `receive` gets each as soon as it is here.
/// Returns the signal that ended the child before its work, or 0.
/// Failure: throws std::runtime_error saying what `work` threw; std::system_error where no child can be made; and what `receive`
///          throws.
int messagesOfChild(const std::function<void(const SendMessage&)>& work,
                    const std::function<void(const std::string&)>& receive);

}  // namespace proximity_server::system
