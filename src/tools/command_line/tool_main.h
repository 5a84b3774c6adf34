#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace proximity_server::tools {

/// How a tool ends.
enum class ExitCode : int {
  Done = 0,
  BadInput = 1,       ///< also where memory, threads or the disk do not suffice
  AssertionFails = 2  ///< --assert-above of clearance
};

/// The main() of a tool: takes the options of the command line, then runs.
///
/// The name of `app` stands before every message. What is thrown, by an option or by `run`, becomes one on standard
/// error and the exit code BadInput.
/// Failure: never throws.
int runTool(CLI::App& app, int argc, char** argv, const std::function<ExitCode()>& run);

}  // namespace proximity_server::tools
