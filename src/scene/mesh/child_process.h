#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string>

namespace proximity_server::scene {

/// The limits on a child process.
struct ProcessLimits {
  std::size_t memory;                   ///< [byte] on top of what this process uses
  std::chrono::seconds processor_time;  ///< that the child computes
  std::chrono::seconds time;            ///< until its answer is here
  std::size_t answer;                   ///< [byte]
};

/// What `work` returns when a child process does it: a copy of this one, made by fork(), that may crash, loop or run
/// out of memory while this one lives. It has no descriptor of ours but the pipe of its answer, neither our standard
/// streams nor our signal handlers, and nothing that it does to memory is seen here. When the call ends, the child is
/// gone.
///
/// Thread safe, and legal in a process of many threads, of which the child has the calling one only. So `work` must
/// need no lock that another thread may hold at that moment: nothing of ours, no logging, no name look-up. What it may
/// do rests on glibc, whose fork() leaves malloc and stdio usable, and which unwinds exceptions without a lock (2.35).
/// Where a lock is held after all, e.g. that of std::locale::global(), the call ends by `time`.
///
/// Failure: throws std::runtime_error saying what `work` threw, or how the child ended: "it takes more than 1024 MiB of
///          memory", "it crashes: Segmentation fault"; std::system_error where no child can be made.
std::string answerOfChild(const std::function<std::string()>& work, const ProcessLimits& limits);

}  // namespace proximity_server::scene
