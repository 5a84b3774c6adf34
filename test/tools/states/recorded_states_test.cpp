#include "tools/states/recorded_states.h"

#include "scene/files.h"
#include "tools/states/arm.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace proximity_server::tools::recorded_states_test {

using namespace scene;

struct Message {
  double time;
  std::vector<std::string> names;
  std::vector<double> positions;
};

JointRecording recordingOf(const std::vector<Message>& messages) {
  JointRecording recording(arm());
  for (const Message& message : messages) recording.add(message.time, message.names, message.positions);
  return recording;
}

RecordedStates statesOf(const std::vector<Message>& messages, std::optional<double> rate = std::nullopt) {
  return RecordedStates("r.bag", recordingOf(messages), rate);
}

struct Timed {
  double time;
  Positions positions;
  bool operator==(const Timed& other) const { return time == other.time && positions == other.positions; }
};

std::vector<Timed> timedOf(RecordedStates&& states) {
  EXPECT_TRUE(states.header().has(JointColumn::Quantity::Time));
  std::vector<Timed> all;
  for (scene::TrajectoryPoint state; states.next(state);) all.push_back({state.time, state.positions});
  EXPECT_EQ(states.count(), all.size());
  return all;
}

TEST(RecordedStates, KeepWhatAMessageDoesNotName) {
  EXPECT_EQ(timedOf(statesOf({{1.0, {"lift", "elbow"}, {0.1, 0.2}}, {2.0, {"elbow"}, {0.3}}, {3.0, {"lift"}, {0.4}}})),
            (std::vector<Timed>{{1.0, at(0.2, 0.1, 0.0)}, {2.0, at(0.3, 0.1, 0.0)}, {3.0, at(0.3, 0.4, 0.0)}}));
}

TEST(RecordedStates, BeginWhereAllJointsAreKnown) {
  RecordedStates states =
      statesOf({{1.0, {"elbow"}, {0.1}}, {2.0, {"elbow"}, {0.2}}, {3.0, {"lift"}, {0.3}}, {4.0, {"elbow"}, {0.4}}});
  EXPECT_EQ(states.header().warnings,
            std::vector<std::string>{"r.bag: the states of the first 2 times are left out: joint \"lift\" "
                                     "is not known before 3 s."});
  EXPECT_EQ(timedOf(std::move(states)), (std::vector<Timed>{{3.0, at(0.2, 0.3, 0.0)}, {4.0, at(0.4, 0.3, 0.0)}}));
}

TEST(RecordedStates, AreInTheOrderOfTheirTimesAndOneForEachTime) {
  EXPECT_EQ(timedOf(statesOf(
                {{2.0, {"elbow"}, {0.2}}, {1.0, {"lift"}, {0.1}}, {1.0, {"elbow"}, {0.3}}, {2.0, {"lift"}, {0.4}}})),
            (std::vector<Timed>{{1.0, at(0.3, 0.1, 0.0)}, {2.0, at(0.2, 0.4, 0.0)}}));
}

TEST(RecordedStates, AtARateAreTheLastThatWereKnown) {
  const std::vector<Message> messages{
      {10.0, {"elbow"}, {0.0}}, {10.3, {"elbow"}, {0.3}}, {10.5, {"elbow"}, {0.5}}, {11.25, {"elbow"}, {1.25}}};
  EXPECT_EQ(timedOf(statesOf(messages, 4.0)), (std::vector<Timed>{{10.0, at(0.0, 0.0, 0.0)},
                                                                  {10.25, at(0.0, 0.0, 0.0)},
                                                                  {10.5, at(0.5, 0.0, 0.0)},
                                                                  {10.75, at(0.5, 0.0, 0.0)},
                                                                  {11.0, at(0.5, 0.0, 0.0)},
                                                                  {11.25, at(1.25, 0.0, 0.0)}}));
  EXPECT_EQ(timedOf(statesOf(messages, 0.5)), (std::vector<Timed>{{10.0, at(0.0, 0.0, 0.0)}}));
}

// 3 is not a product of 0.1 in doubles, and 1e6 Hz is finer than the times of the year 2026 are rounded.
TEST(RecordedStates, AtARateEndAtTheLastMessage) {
  for (const double begin : {0.0, 1.7e9}) {
    for (const double rate : {0.7, 10.0, 30.0, 1e3, 1e6}) {
      RecordedStates states = statesOf({{begin, {"elbow"}, {0.0}}, {begin + 0.3, {"elbow"}, {1.0}}}, rate);
      const std::uint64_t count = *states.count();
      ASSERT_GE(count, 1U);
      EXPECT_LE(begin + static_cast<double>(count - 1) / rate, begin + 0.3);
      EXPECT_GT(begin + static_cast<double>(count) / rate, begin + 0.3);
      states.skipTo(count - 1);
      EXPECT_EQ(restOf(states).size(), 1U);
    }
  }
}

TEST(RecordedStates, AreTheSameFromAnyStateOn) {
  std::vector<Message> messages;
  for (int i = 0; i < 50; ++i) messages.push_back({0.1 * i, {i % 3 == 0 ? "lift" : "elbow"}, {0.01 * i}});
  for (const std::optional<double> rate : {std::optional<double>(), std::optional<double>(7.0)}) {
    const std::vector<Positions> all = restOf(statesOf(messages, rate));
    ASSERT_GT(all.size(), 20U);
    for (std::size_t first = 0; first < all.size(); ++first) {
      RecordedStates states = statesOf(messages, rate);
      states.skipTo(first);
      EXPECT_EQ(restOf(states), std::vector<Positions>(all.begin() + static_cast<std::ptrdiff_t>(first), all.end()));
    }
  }
}

TEST(RecordedStates, LeaveOutWhatTheRobotDoesNotHave) {
  RecordedStates states =
      statesOf({{1.0, {"camera_pan_joint", "elbow", "base", "weld", "finger"}, {9.0, 0.5, std::nan(""), 9.0, 9.0}},
                {2.0, {"camera_pan_joint"}, {8.0}},
                {3.0, {"elbow"}, {}}});
  EXPECT_EQ(states.header().warnings,
            (std::vector<std::string>{
                "r.bag: joint \"camera_pan_joint\" is not used: no such joint.",
                "r.bag: joint \"base\" is not used: a floating or planar joint has more than one position.",
                "r.bag: joint \"weld\" is not used: a fixed joint has no position.",
                "r.bag: joint \"finger\" is not used: the joint follows \"lift\"."}));
  EXPECT_EQ(timedOf(std::move(states)), (std::vector<Timed>{{1.0, at(0.5, 0.0, 0.0)}}));
}

TEST(RecordedStates, RefuseMessagesThatMakeNoState) {
  const auto errorFor = [](const std::vector<Message>& messages) { return errorOf([&] { statesOf(messages); }); };
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(errorFor({{1.0, {"elbow"}, {0.0, 1.0}}}), "2 positions for 1 names");
  EXPECT_EQ(errorFor({{1.0, {"elbow", "elbow"}, {0.0, 1.0}}}), "joint \"elbow\" is named twice");
  EXPECT_EQ(errorFor({{1.0, {"elbow"}, {std::nan("")}}}), "joint \"elbow\": \"nan\" is no finite number");
  EXPECT_EQ(errorFor({{1.0, {"elbow"}, {-infinity}}}), "joint \"elbow\": \"-inf\" is no finite number");
  EXPECT_EQ(errorFor({}), "r.bag: no message has the position of a joint of the robot");
  EXPECT_EQ(errorFor({{1.0, {"elbow"}, {}}}), "r.bag: no message has the position of a joint of the robot");
  EXPECT_EQ(
      errorFor({{1.0, {"elbwo"}, {1.0}}}),
      "r.bag: no message has the position of a joint of the robot; joint \"elbwo\" is not used: no such joint (did you "
      "mean \"elbow\"?).");
}

TEST(RecordedStates, AreIdentifiedByTheirPositionsTimesAndRate) {
  const std::string identity = statesOf({{1.0, {"elbow"}, {0.5}}}).identity();
  EXPECT_EQ(statesOf({{1.0, {"elbow", "other"}, {0.5, 1.0}}}).identity(), identity);
  EXPECT_NE(statesOf({{1.0, {"elbow"}, {0.6}}}).identity(), identity);
  EXPECT_NE(statesOf({{1.5, {"elbow"}, {0.5}}}).identity(), identity);
  EXPECT_NE(statesOf({{1.0, {"lift"}, {0.5}}}).identity(), identity);
  EXPECT_NE(statesOf({{1.0, {"elbow"}, {0.5}}}, 1.0).identity(), identity);
}

TEST(RecordedStates, SayWhichStateIsBeyondALimitAndWhereItIs) {
  RecordedStates states = statesOf({{1.0, {"elbow"}, {0.0}}, {2.5, {"elbow"}, {4.0}}});
  EXPECT_EQ(restOf(states).size(), 2U);
  EXPECT_EQ(states.place(), "r.bag, state 1 at 2.5 s");
  EXPECT_EQ(states.limitWarning(),
            "r.bag: 1 of 2 states are beyond the limits of a joint. The first is state 1: \"elbow\" is at 4 rad, its "
            "limits are "
            "-2 and 3 rad.");
}

}  // namespace proximity_server::tools::recorded_states_test
