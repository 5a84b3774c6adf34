#pragma once

#include "scene/files.h"
#include "tools/program/run_command.h"
#include "tools/robot/two_sliders.h"
#include "tools/text/csv.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

namespace proximity_server::tools {

using namespace scene;

class Clearance : public ::testing::Test {
 protected:
  /// With the two sliders and the given states; `arguments` stand behind them.
  CommandResult run(const std::string& states, const std::string& arguments) {
    files_.write("s.csv", states);
    return runCommandApart(CLEARANCE " " + urdf_ + " --states " + files_.path("s.csv") + " " + arguments);
  }

  TemporaryFiles files_;
  std::string urdf_ = files_.write("robot.urdf", kTwoSliders);
};

inline bool says(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

inline std::vector<std::vector<std::string>> rowsOf(const std::string& csv) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream stream(csv);
  for (std::string line; std::getline(stream, line);) rows.push_back(csvFields(line));
  return rows;
}

}  // namespace proximity_server::tools
