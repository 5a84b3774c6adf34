#pragma once

#include <functional>

namespace proximity_server::tools {

class ProgramOptions;

/// The exit code of a tool.
enum class ExitCode : int {
  Done = 0,
  BadInput = 1,  ///< also if memory, threads or disk space do not suffice
  /// --assert-above of clearance; of prove: a pair is not proven apart, or a certificate is wrong; of model_check: a
  /// finding; of pair_audit: a person has to decide before the folder of --setup is ready
  AssertionFails = 2,
  Refuted = 3  ///< --second-opinion of clearance
};

/// The main() of a tool: reads the options of the command line, refuses a file that would be read and written, then
/// calls `run`.
///
/// An exception of `run` becomes a message on standard error, which begins with the name of the program, and the exit
/// code BadInput.
/// Failure: never throws.
int runTool(ProgramOptions& program, int argc, char** argv, const std::function<ExitCode()>& run);

}  // namespace proximity_server::tools
