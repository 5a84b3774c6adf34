#include "tools/states/csv_states.h"

#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "scene/files.h"
#include "tools/robot/two_sliders.h"
#include "tools/states/arm.h"
#include "tools/text/csv.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

namespace proximity_server::tools::csv_states_test {

using namespace narrowphase;
using namespace scene;

const RobotModel& robot() {
  static const RobotModel model = loadRobotModel(kTwoSliders, packageResolver({}));
  return model;
}

std::vector<std::vector<double>> statesOf(const std::string& text) {
  std::istringstream stream(text);
  CsvStates states(stream, "s.csv", robot());
  std::vector<std::vector<double>> all;
  for (scene::TrajectoryPoint state; states.next(state);) all.push_back(state.positions);
  return all;
}

std::string errorIn(const std::string& text) {
  return errorOf([&] { statesOf(text); });
}

TEST(CsvStates, ReadsARowForEachState) {
  const auto states = statesOf("slide\n0.5\n-1e-1\n");
  ASSERT_EQ(states.size(), 2U);
  const BodyPoses poses = forwardKinematics(robot(), states[1]);
  const int sled = robot().links[robot().findLink("sled, left")].body;
  const int ball = robot().links[robot().findLink("ball")].body;
  EXPECT_EQ(poses[sled]->translation().x(), 2.0 - 0.1);
  EXPECT_EQ(poses[ball]->translation().x(), 5.0 - 0.2);
}

TEST(CsvStates, TakeDegreesOfWhatTurns) {
  std::istringstream turned("elbow,lift\n90deg,0.25\n"), lifted("elbow,lift\n0,10deg\n");
  CsvStates states(turned, "file", arm());
  EXPECT_EQ(restOf(states), std::vector<Positions>{at(M_PI / 2.0, 0.25, 0.0)});
  CsvStates others(lifted, "file", arm());
  EXPECT_EQ(errorOf([&] { restOf(others); }), "file, line 2: '10deg' of \"lift\", which does not turn");
}

TEST(CsvStates, TakesSpreadsheetsAsTheyAre) {
  EXPECT_EQ(statesOf("\xEF\xBB\xBF\"slide\"\r\n\r\n +0.5 \r\n"), statesOf("slide\n0.5"));
}

TEST(CsvStates, WarnsOfAColumnThatAFollowerDoesNotUse) {
  std::istringstream stream("slide,follow\n1,7\n");
  EXPECT_EQ(CsvStates(stream, "s.csv", robot()).header().warnings,
            std::vector<std::string>{"s.csv: column \"follow\" is not used: the joint follows \"slide\"."});
}

TEST(CsvStates, HaveTheRatesOfTheirColumnsAndNoOthers) {
  std::istringstream moving("elbow,lift.velocity\n0.5,0.25\n"), standing("elbow\n0.5\n");
  scene::TrajectoryPoint state;
  ASSERT_TRUE(CsvStates(moving, "s.csv", arm()).next(state));
  EXPECT_EQ(state.velocities, at(0.0, 0.25, 0.0));
  EXPECT_TRUE(state.accelerations.empty());
  EXPECT_TRUE(std::isnan(state.time));
  ASSERT_TRUE(CsvStates(standing, "s.csv", arm()).next(state));
  EXPECT_EQ(state.positions, at(0.5, 0.0, 0.0));
  EXPECT_TRUE(state.velocities.empty());
}

TEST(CsvStates, ReadsTheTimeBesideThePositions) {
  std::istringstream stream("time,slide\n1.5,0.25\n");
  CsvStates states(stream, "s.csv", robot());
  EXPECT_TRUE(states.header().has(JointColumn::Quantity::Time));
  scene::TrajectoryPoint state;
  ASSERT_TRUE(states.next(state));
  EXPECT_EQ(state.time, 1.5);
  EXPECT_EQ(state.positions, statesOf("slide\n0.25\n")[0]);
  EXPECT_EQ(errorIn("time,slide\nnan,0\n"), "s.csv, line 2: column \"time\": \"nan\" is no finite number");
  EXPECT_EQ(errorIn("time,time\n0,0\n"), "s.csv, line 1: two columns are named \"time\"");
}

TEST(CsvStates, AreTheSameFromAnyStateOn) {
  const std::string text = "slide\n0\n\n1\n  \n2\n";
  for (std::uint64_t first = 0; first <= 4; ++first) {
    std::istringstream stream(text);
    CsvStates states(stream, "s.csv", robot());
    states.skipTo(first);
    scene::TrajectoryPoint state;
    for (std::uint64_t i = first; i < 3; ++i) {
      ASSERT_TRUE(states.next(state));
      EXPECT_EQ(state.positions, statesOf("slide\n" + std::to_string(i))[0]);
    }
    EXPECT_FALSE(states.next(state));
  }
}

TEST(CsvStates, OfAFileHaveANumberAndAnIdentity) {
  const TemporaryFiles files;
  const CsvStates states(files.write("s.csv", "slide\r\n\n1\n \n2"), robot());
  EXPECT_EQ(states.count(), 2U);
  EXPECT_EQ(states.identity(), CsvStates(files.write("same.csv", "slide\r\n\n1\n \n2"), robot()).identity());
  EXPECT_NE(states.identity(), CsvStates(files.write("other.csv", "slide\r\n\n1\n \n3"), robot()).identity());
  EXPECT_EQ(CsvStates(files.write("none.csv", "slide\n"), robot()).count(), 0U);
}

TEST(CsvStates, OfAStreamHaveNeither) {
  std::istringstream stream("slide\n1\n");
  const CsvStates states(stream, "s.csv", robot());
  EXPECT_EQ(states.count(), std::nullopt);
  EXPECT_EQ(states.identity(), "");
}

// The number of the state is that in the whole file.
TEST(CsvStates, NumberWhatIsBeyondALimitFromTheFirstState) {
  std::istringstream stream("slide\n5\n0\n6\n");
  CsvStates states(stream, "s.csv", robot());
  states.skipTo(1);
  for (scene::TrajectoryPoint state; states.next(state);) {
  }
  EXPECT_EQ(
      states.limitWarning(),
      "s.csv: 1 of 2 states are beyond the limits of a joint. The first is state 2, line 4: \"slide\" is at 6 m, its "
      "limits are -1 and 2 m.");
}

TEST(CsvStates, AJointOfThatNameIsNoTime) {
  std::string urdf = kTwoSliders;
  const std::string slide = "joint name=\"slide\"", mimic = "mimic joint=\"slide\"";
  urdf.replace(urdf.find(slide), slide.size(), "joint name=\"time\"");
  urdf.replace(urdf.find(mimic), mimic.size(), "mimic joint=\"time\"");
  const RobotModel model = loadRobotModel(urdf, packageResolver({}));
  std::istringstream stream("time\n0.5\n");
  CsvStates states(stream, "s.csv", model);
  scene::TrajectoryPoint state;
  ASSERT_TRUE(states.next(state));
  EXPECT_FALSE(states.header().has(JointColumn::Quantity::Time));
  EXPECT_EQ(state.positions[model.leaderOf(0).joint], 0.5);
}

TEST(CsvStates, NamesLineAndColumnOfWhatIsWrong) {
  EXPECT_EQ(errorIn(""), "s.csv: empty; expected a header of joint names");
  EXPECT_EQ(errorIn("slid\n1\n"), "s.csv, line 1: column \"slid\": no such joint (did you mean \"slide\"?)");
  EXPECT_EQ(errorIn("weld\n1\n"), "s.csv, line 1: column \"weld\": a fixed joint has no position");
  EXPECT_EQ(errorIn("slide,slide\n1,1\n"), "s.csv, line 1: two columns are named \"slide\"");
  EXPECT_EQ(errorIn("slide\n1\n1,2\n"), "s.csv, line 3: 2 numbers for 1 columns");
  EXPECT_EQ(errorIn("slide,follow\n1\n"), "s.csv, line 2: 1 numbers for 2 columns");
  EXPECT_EQ(errorIn("slide\n\"1\n"), "s.csv, line 2: a quote does not end");
  for (const std::string number : {"nan", "inf", "1e999", "0x1", "1 2", "one", "+-1", "\"\""}) {
    const std::string shown = number == "\"\"" ? "" : number;
    EXPECT_EQ(errorIn("slide\n" + number + "\n"),
              "s.csv, line 2: column \"slide\": \"" + shown + "\" is no finite number");
  }
}

TEST(Csv, WhatIsWrittenIsReadBack) {
  const std::vector<std::string> fields{"plain", "a, b", "say \"no\"", "", " blanks ", "\"\""};
  std::string record;
  for (const std::string& field : fields) record += (record.empty() ? "" : ",") + csvField(field);
  EXPECT_EQ(csvFields(record), fields);
}

TEST(Csv, NumbersAreReadBackBitByBit) {
  for (const double value : {0.1, -1.0 / 3.0, 5e-324, 1.7976931348623157e308}) {
    EXPECT_EQ(std::strtod(shortest(value).c_str(), nullptr), value);
  }
  EXPECT_EQ(shortest(0.1), "0.1");
  EXPECT_EQ(shortest(std::numeric_limits<double>::quiet_NaN()), "nan");
}

}  // namespace proximity_server::tools::csv_states_test
