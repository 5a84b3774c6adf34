#pragma once

#include "tools/program/run_command.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>

namespace proximity_server::tools {

/// Runs the executable; shapes stand in quotes, as in a shell.
inline CommandResult explainCommand(const std::string& arguments) { return runCommandApart(EXPLAIN " " + arguments); }

/// The answer with all digits.
inline nlohmann::json explainJson(const std::string& arguments) {
  const CommandResult result = explainCommand(arguments + " --format json");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  return nlohmann::json::parse(result.output);
}

inline bool says(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

// The worked examples of src/narrowphase/README.md.
constexpr const char* kFourSteps =
    R"('hull 7 5 6 0  4 -4 0  7 1 0  1 2 0  4 1 0  2 -1 0  6 -3 0' 'hull 1 0 0 0' --first-direction '0 1 0')";
constexpr const char* kPolygons = R"('hull 4 0 0 0  3 -1 0  4 2 0  1 3 0' 'hull 3 7 1 0  9 4 0  6 4 0')";
constexpr const char* kOctahedron =
    R"('hull 6 4 0 0  -3 0 0  0 3 0  0 -4 0  0 0 2  0 0 -3' 'sphere 0.5' --xyz '-0.3 0.6 0.2')";

}  // namespace proximity_server::tools
