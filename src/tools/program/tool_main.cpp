#include "tools/program/tool_main.h"

#include <CLI/CLI.hpp>

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

int parseAndRun(CLI::App& app, int argc, char** argv, const std::function<ExitCode()>& run) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    return fail(app.get_name(), error.what(), "\nRun with --help for more information.");
  }
  return static_cast<int>(run());
}

}  // namespace

int runTool(CLI::App& app, int argc, char** argv, const std::function<ExitCode()>& run) {
  std::ios::sync_with_stdio(false);
  app.set_version_flag("--version", app.get_name() + " of proximity_server " PROXIMITY_VERSION);
  std::signal(SIGXFSZ, SIG_IGN);  // so that a file which may not grow further is named like one on a full disk
  const std::string& tool = app.get_name();
  try {
    return parseAndRun(app, argc, argv, run);
  } catch (const std::bad_alloc&) {
    return fail(tool, "not enough memory");
  } catch (const std::length_error&) {  // thrown by containers of the standard library
    return fail(tool, "the input is too large to be held in memory");
  } catch (const std::system_error& error) {
    return fail(tool, "the system refuses: ", error.what());
  } catch (const std::exception& error) {
    return fail(tool, error.what());
  }
}

}  // namespace proximity_server::tools
