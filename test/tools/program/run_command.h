#pragma once

#include "scene/example_robots.h"
#include "scene/files.h"

#include <stdio.h>
#include <sys/wait.h>

#include <array>
#include <stdexcept>
#include <string>

namespace proximity_server::tools {

using namespace scene;

struct CommandResult {
  int exit_code;
  std::string output;
  std::string errors;  ///< standard error, where runCommandApart() was asked
};

/// Runs a shell command; what it writes to standard error comes along where the command says 2>&1.
inline CommandResult runCommand(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) throw std::runtime_error("no shell for " + command);
  std::string output;
  std::array<char, 4096> chunk;
  for (std::size_t size = 0; (size = fread(chunk.data(), 1, chunk.size(), pipe)) > 0;)
    output.append(chunk.data(), size);
  const int status = pclose(pipe);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, output, ""};
}

/// Runs a command, and keeps standard error apart.
inline CommandResult runCommandApart(const std::string& command) {
  const TemporaryFiles files;
  CommandResult result = runCommand("{ " + command + " ; } 2> " + files.path("errors"));
  result.errors = readFile(files.path("errors"));
  return result;
}

}  // namespace proximity_server::tools
