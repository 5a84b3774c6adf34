#pragma once

#include "scene/files.h"
#include "tools/program/run_command.h"
#include "tools/robot/crossing_sliders.h"
#include "tools/robot/two_sliders.h"
#include "tools/text/csv.h"

#include <gtest/gtest.h>

#include <random>
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

  /// The slider at random places from `lower` to 2 m.
  static std::string wander(int count, double lower = -1.5, unsigned seed = 11) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> position(lower, 2.0);
    std::string states = "slide\n";
    for (int i = 0; i < count; ++i) states += shortest(position(random)) + "\n";
    return states;
  }

  /// Changes the robot to the crossing sliders, without the pairs that always touch: what is left can be told on paper.
  /// Returns the arguments for that.
  std::string crossingSliders() {
    urdf_ = files_.write("crossing.urdf", kCrossingSliders);
    return "--srdf " + files_.write("crossing.srdf",
                                    "<robot name='crossing sliders'>"
                                    "<disable_collisions link1='base' link2='rod'/>"
                                    "<disable_collisions link1='base' link2='tip'/></robot>");
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
