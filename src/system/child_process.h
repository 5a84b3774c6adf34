#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace proximity_server::system {

/// True if a child may be made while other threads run. Not with AddressSanitizer, whose malloc may stay locked in the
/// child.
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
  std::size_t memory;                       ///< [byte] in addition to the memory that this process uses
  std::chrono::seconds processor_time;      ///< the processor time of the child
  std::chrono::seconds time;                ///< the time until its answer is received
  std::size_t answer;                       ///< [byte]
  const std::atomic<bool>* stop = nullptr;  ///< if not nullptr, a flag that ends the child once it is set
};

/// Runs `work` in a child process and returns its result. The child is a copy of this process, made by fork(). It may
/// crash, loop or run out of memory without any effect on this process. The only file descriptor that it shares is the
/// pipe for its answer; it has neither the standard streams nor the signal handlers of this process. When the call
/// returns, the child has ended.
///
/// Thread-safe, and legal in a process with several threads; the child has only the calling thread. Therefore `work`
/// must not need a lock that another thread may hold at that moment: no locks of this package, no logging, no name
/// look-up. It relies on glibc, whose fork() leaves malloc and stdio usable, and which unwinds exceptions without a
/// lock (2.35). If a lock is held nevertheless, e.g. the lock of std::locale::global(), the call ends after `time`.
///
/// Failure: throws std::runtime_error with the error that `work` threw, or with how the child ended: "it takes more
///          than 1024 MiB of memory", "it crashes: Segmentation fault". Throws std::system_error if no child can be
///          made.
std::string answerOfChild(const std::function<std::string()>& work, const ProcessLimits& limits);

using SendMessage = std::function<void(std::string_view)>;

/// Runs `work` in a child process without limits; it may send any number of messages. `receive` gets each message as
/// soon as it arrives. Returns the signal that ended the child before its work was done, or 0.
/// Failure: throws std::runtime_error with the error that `work` threw; std::system_error if no child can be made; and
///          what `receive` throws.
int messagesOfChild(const std::function<void(const SendMessage&)>& work,
                    const std::function<void(const std::string&)>& receive);

}  // namespace proximity_server::system
