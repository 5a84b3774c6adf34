#include "tools/program/options.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace proximity_server::tools::options_test {

using Words = std::vector<const char*>;

/// How a program with options of each kind reads its command line.
struct Reading {
  std::optional<int> exit_code;
  std::string values;  ///< "name=text" of each option and argument, in the order in which they were read
  std::string output, errors;
};

Reading readingOf(Words words) {
  Reading reading;
  const auto note = [&](const std::string& name) {
    return [&reading, name](const std::string& text) { reading.values += name + "=" + text + ";"; };
  };
  const auto add = [&](ProgramOptions& program, const std::string& name) -> Option& {
    return program.add(name, "TEXT", "what " + name + " says", note(name));
  };
  ProgramOptions program("tool", "What it does.");
  add(program, "robot").is_required = true;
  add(program, "other");
  add(program, "--text");
  add(program, "--axis").is_repeatable = true;
  program.setHeading("Places");
  add(program, "--from");
  add(program, "--to");
  add(program, "--at");
  program.setHeading();
  add(program, "--speed").needs = "--to";
  program.atMostOneOf({"--from", "--at"});
  program.atMostOneOf({"--to", "--at"});
  program.add("--flag", "", "a flag", note("--flag"));
  int count = 3;
  addCount(program, "--count", count, 0, 10, "how many");
  program.setFooter("What else there is.");

  words.insert(words.begin(), "tool");
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  reading.exit_code = program.parse(static_cast<int>(words.size()), words.data());
  reading.output = testing::internal::GetCapturedStdout();
  reading.errors = testing::internal::GetCapturedStderr();
  return reading;
}

std::string textOf(const Words& words) {
  std::string text;
  for (const char* const word : words) text += std::string("'") + word + "' ";
  return text;
}

TEST(ProgramOptions, ReadsOptionsAndArgumentsInTheirOrder) {
  const struct {
    Words words;
    std::string values;
  } cases[] = {
      {{"r"}, "robot=r;"},
      {{"r", "o"}, "robot=r;other=o;"},
      {{"--text", "x", "r"}, "--text=x;robot=r;"},
      {{"--text=x", "r"}, "--text=x;robot=r;"},
      {{"r", "--text=a=b"}, "robot=r;--text=a=b;"},
      {{"r", "--text", ""}, "robot=r;--text=;"},
      {{"", "--text", "a b"}, "robot=;--text=a b;"},
      {{"r", "--text", "-1"}, "robot=r;--text=-1;"},
      {{"r", "--text", "-1 0 0"}, "robot=r;--text=-1 0 0;"},
      {{"r", "--text", "--flag"}, "robot=r;--text=--flag;"},
      {{"-", "--text", "-"}, "robot=-;--text=-;"},
      {{"--", "--flag", "-1"}, "robot=--flag;other=-1;"},
      {{"r", "--axis", "1", "o", "--axis=2"}, "robot=r;--axis=1;other=o;--axis=2;"},
      {{"r", "--flag", "--flag"}, "robot=r;--flag=;--flag=;"},
      {{"--from", "1", "--to", "2", "--speed", "3", "r"}, "--from=1;--to=2;--speed=3;robot=r;"},
  };
  for (const auto& [words, values] : cases) {
    const Reading reading = readingOf(words);
    EXPECT_EQ(reading.exit_code, std::nullopt) << textOf(words) << reading.errors;
    EXPECT_EQ(reading.values, values);
    EXPECT_EQ(reading.output + reading.errors, "");
  }
}

TEST(ProgramOptions, NamesWhatIsWrong) {
  const struct {
    Words words;
    std::string error;
  } cases[] = {
      {{}, "robot is required"},
      {{"r", "o", "x"}, "The following argument was not expected: x"},
      {{"r", "--txet=x"}, "The following argument was not expected: --txet=x"},
      {{"r", "--tex", "x"}, "The following argument was not expected: --tex"},
      {{"r", "--=x"}, "The following argument was not expected: --=x"},
      {{"--robot", "r"}, "The following argument was not expected: --robot"},
      {{"r", "-1"}, "The following argument was not expected: -1"},
      {{"r", "--text"}, "the required argument for option '--text' is missing"},
      {{"r", "--text="}, "the argument for option '--text' should follow immediately after the equal sign"},
      {{"r", "--flag=x"}, "option '--flag' does not take any arguments"},
      {{"r", "--text", "a", "--text", "a"}, "--text is given twice"},
      {{"r", "--count", "11"}, "--count: '11' is not a whole number from 0 to 10"},
      {{"r", "--speed", "1"}, "--speed requires --to"},
      {{"r", "--to", "1", "--at", "1"}, "--to excludes --at"},
      {{"r", "--at", "1", "--from", "1"}, "--from excludes --at"},
  };
  for (const auto& [words, error] : cases) {
    const Reading reading = readingOf(words);
    EXPECT_EQ(reading.exit_code, 1) << textOf(words);
    EXPECT_EQ(reading.errors, "tool: " + error + "\nRun with --help for more information.\n");
    EXPECT_EQ(reading.output, "");
  }
}

TEST(ProgramOptions, HelpTellsAllOfThem) {
  const auto areBlanks = [](char a, char b) { return a == ' ' && b == ' '; };
  for (const Words& words : {Words{"--help"}, Words{"-h"}, Words{"r", "--help", "--count", "11"}}) {
    Reading reading = readingOf(words);
    EXPECT_EQ(reading.exit_code, 0);
    EXPECT_EQ(reading.errors, "");
    std::string& help = reading.output;
    help.erase(std::unique(help.begin(), help.end(), areBlanks), help.end());
    EXPECT_EQ(help, R"(What it does.

Usage: tool [OPTIONS] robot [other]

Arguments:
 robot TEXT what robot says
 other TEXT what other says

Options:
 -h [ --help ] print this text
 --version print the version
 --text TEXT what --text says
 --axis TEXT what --axis says
 --speed TEXT what --speed says; needs --to
 --flag a flag
 --count NUMBER how many

Places:
 --from TEXT what --from says; not with --at
 --to TEXT what --to says; not with --at
 --at TEXT what --at says; not with --from, --to

What else there is.
)");
  }
}

TEST(ProgramOptions, PrintsTheVersion) {
  const Reading reading = readingOf({"--version"});
  EXPECT_EQ(reading.exit_code, 0);
  EXPECT_EQ(reading.output.substr(0, 25), "tool of proximity_server ");
}

TEST(ProgramOptions, APositiveNumberIsWholeWhereItsTypeIs) {
  const auto read = [](auto value, const char* text) {
    ProgramOptions program("tool", "What it does.");
    addPositive(program, "--number", value, "how much");
    program["--number"].read(text);
    return value;
  };
  EXPECT_EQ(read(7, "12"), 12);
  EXPECT_EQ(read(0.5, "1e-3"), 1e-3);
  for (const char* const text : {"0", "-1", "nan", "x", ""}) {
    EXPECT_THROW(read(7, text), std::invalid_argument) << text;
    EXPECT_THROW(read(0.5, text), std::invalid_argument) << text;
  }
  EXPECT_THROW(read(7, "1.5"), std::invalid_argument);
  EXPECT_THROW(read(7U, "4294967296"), std::invalid_argument);
}

}  // namespace proximity_server::tools::options_test
