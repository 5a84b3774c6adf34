#include "tools/program/tool_main.h"

#include "system/number_text.h"
#include "tools/program/options.h"

#include <signal.h>

#include <csignal>
#include <exception>
#include <iostream>
#include <new>
#include <stdexcept>
#include <system_error>

namespace proximity_server::tools {
namespace {

/// Prints an error message. It flushes standard output first, so that the message comes last. Allocates nothing.
int fail(const std::string& tool, const char* message, const char* more = "") {
  std::cout << std::flush;
  std::cerr << tool << ": " << message << more << std::endl;
  return static_cast<int>(ExitCode::BadInput);
}

/// Lets a closed pipe end the program, as it ends others. APR, which log4cxx of Debian 11 starts before main(), blocks
/// its signal.
void unblockBrokenPipe() {
  sigset_t broken_pipe;
  sigemptyset(&broken_pipe);
  sigaddset(&broken_pipe, SIGPIPE);
  pthread_sigmask(SIG_UNBLOCK, &broken_pipe, nullptr);
}

}  // namespace

int runTool(ProgramOptions& program, int argc, char** argv, const std::function<ExitCode()>& run) {
  std::ios::sync_with_stdio(false);
  unblockBrokenPipe();
  std::signal(SIGXFSZ, SIG_IGN);  // so that a file which may not grow further is named like one on a full disk
  const std::string& tool = program.program();
  try {
    if (const std::optional<int> exit_code = program.parse(argc, argv)) return *exit_code;
    program.claimFiles();
    return static_cast<int>(run());
  } catch (const std::bad_alloc&) {
    return fail(tool, "not enough memory");
  } catch (const std::length_error&) {  // thrown by containers of the standard library
    return fail(tool, "the input is too large to be held in memory");
  } catch (const std::system_error& error) {
    return fail(tool, "the system refuses: ", error.what());
  } catch (const std::exception& error) {
    return fail(tool, system::readable(error.what()).c_str());
  }
}

}  // namespace proximity_server::tools
