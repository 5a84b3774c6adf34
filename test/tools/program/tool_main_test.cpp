#include "tools/program/tool_main.h"

#include "tools/program/options.h"

#include <gtest/gtest.h>

#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

namespace proximity_server::tools::tool_main_test {

struct End {
  int exit_code;
  std::string errors;
};

/// How a tool ends that does this, called with an option --name or another one.
End endOf(const std::function<ExitCode()>& run, std::string option = "--name=x") {
  ProgramOptions program("tool", "what it does");
  std::string name;
  program.addText("--name", "NAME", name, "a name");
  std::string tool = "tool";
  char* arguments[] = {tool.data(), option.data()};
  testing::internal::CaptureStderr();
  const int exit_code = runTool(program, 2, arguments, run);
  return {exit_code, testing::internal::GetCapturedStderr()};
}

template <typename Exception>
End endOfThrowing(const Exception& exception) {
  return endOf([&]() -> ExitCode { throw exception; });
}

TEST(ToolMain, ReturnsWhatTheToolReturns) {
  EXPECT_EQ(endOf([] { return ExitCode::Done; }).exit_code, 0);
  EXPECT_EQ(endOf([] { return ExitCode::AssertionFails; }).exit_code, 2);
}

TEST(ToolMain, UsageErrorsEndWithOneAndAMessage) {
  const End end = endOf([] { return ExitCode::Done; }, "--nmae=x");
  EXPECT_EQ(end.exit_code, 1);
  EXPECT_EQ(end.errors,
            "tool: The following argument was not expected: --nmae=x\nRun with --help for more information.\n");
}

TEST(ToolMain, WhateverIsThrownEndsWithOneAndAMessage) {
  const auto expect = [](const End& end, const std::string& errors) {
    EXPECT_EQ(end.exit_code, 1);
    EXPECT_EQ(end.errors, errors);
  };
  expect(endOfThrowing(std::invalid_argument("file: cannot be read")), "tool: file: cannot be read\n");
  expect(endOfThrowing(std::runtime_error("no thread")), "tool: no thread\n");
  expect(endOfThrowing(std::bad_alloc()), "tool: not enough memory\n");
  expect(endOfThrowing(std::length_error("vector::reserve")), "tool: the input is too large to be held in memory\n");
  expect(endOfThrowing(std::system_error(std::make_error_code(std::errc::too_many_files_open))),
         "tool: the system refuses: Too many open files\n");
}

// Regression: a name of 50 MB in a file came back whole.
TEST(ToolMain, WhatIsLongIsCut) {
  const std::string name(1000000, 'x');
  EXPECT_LT(endOfThrowing(std::invalid_argument("there is no link '" + name + "'")).errors.size(), 1000U);
  EXPECT_LT(endOf([] { return ExitCode::Done; }, "--" + name).errors.size(), 1000U);
}

}  // namespace proximity_server::tools::tool_main_test
