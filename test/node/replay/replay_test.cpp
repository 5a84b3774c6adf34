// Records that are answered again.
#include "node/replay/replay.h"
#include "node/answers/guarantees.h"
#include "node/record/recorded_sliders.h"
#include "node/replay/record_files.h"
#include "node/robot/load_config.h"

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <cstdint>
#include <iomanip>
#include <limits>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace proximity_server::node::replay_test {

class Replayed : public RecordedSliders {
 protected:
  std::string recordOfRandomCycles(unsigned seed, int cycles) {
    start();
    std::mt19937 random(seed);
    std::uniform_real_distribution<> position(0.1, 0.3);
    for (int i = 0; i < cycles; ++i) {
      if (i == cycles / 2) {
        add(ballAt(standingAt(0.35, 0.0, 0.0)));
        know();
      }
      ++levels_[cycleAt(position(random)).level];
    }
    return stop().file;
  }
  std::map<int, int> levels_;
};

TEST_F(Replayed, HaveTheSameLevelsAndTheSameBytesTwice) {
  config_.record_on = {"invalid"};
  for (unsigned seed = 0; seed < 20; ++seed) {
    const std::string file = recordOfRandomCycles(seed, 50);
    std::ostringstream first, second;
    const ReplayResult result = replay({file, {}}, first);
    EXPECT_EQ(result.cycles, 50u);
    EXPECT_TRUE(result.agrees()) << result.first_differences[0];
    replay({file, {}}, second);
    EXPECT_EQ(first.str(), second.str());
  }
  for (const int level : {Clearance::WARN, Clearance::STOP, Clearance::COLLISION}) EXPECT_GT(levels_[level], 20);
}

TEST_F(Replayed, AreHeldByTheHysteresisOfBefore) {
  start();
  cycleAt(0.5);
  cycleAt(0.21);
  recorder_.emplace(config_, "/other");
  know();
  EXPECT_EQ(cycleAt(0.221).level, Clearance::STOP) << "the distance of 21 mm is within the hysteresis";
  std::ostringstream rows;
  EXPECT_TRUE(replay({stop().file, {}}, rows).agrees());
}

// Poses without turns are the same numbers in messages, so all bits are the same.
TEST_F(Replayed, EndGuaranteedDistancesWhereTheirTimeWasOver) {
  XmlRpc::XmlRpcValue values;
  values["joint_uncertainty"]["*"] = 0.03;
  const Config before = config_;
  config_ = configFrom(values, "node");
  config_.record_directory = before.record_directory;
  config_.record_memory = before.record_memory;
  start();
  std::vector<std::string> guaranteed;
  std::uint64_t coarse = 0;
  for (int i = 0; i < 60; ++i) {
    monitor_.endTimeAfter(i % 3 == 0 ? 0 : std::numeric_limits<std::int64_t>::max());
    const Clearance& clearance = cycleAt(0.2 + 0.002 * i);
    coarse += !endIn(clearance.status.message).empty();
    std::ostringstream number;
    number << std::setprecision(17) << clearance.deciding.guaranteed;
    guaranteed.push_back(number.str());
  }
  std::stringstream rows;
  const ReplayResult result = replay({stop().file, {}}, rows);
  EXPECT_TRUE(result.agrees()) << result.first_differences[0];
  EXPECT_EQ(result.coarse, coarse);
  EXPECT_GE(coarse, 10u);
  EXPECT_LT(coarse, 60u);
  EXPECT_EQ(result.first_coarse.size(), 10u);
  EXPECT_EQ(result.first_coarse.at(0).rfind("cycle 1: guaranteed distances are coarse: their time was over after ", 0),
            0u)
      << result.first_coarse[0];
  std::string row, field;
  std::getline(rows, row);
  for (const std::string& expected : guaranteed) {
    std::getline(rows, row);
    std::istringstream fields(row);
    for (int i = 0; i < 7; ++i) std::getline(fields, field, ',');
    EXPECT_EQ(field, expected);
  }
}

TEST_F(Replayed, TellWhatDiffersWithAnotherPadding) {
  config_.model.default_padding = 0.005;  // is in no parameter of the record
  const std::string file = recordOfRandomCycles(1, 50);
  std::ostringstream rows;
  const ReplayResult result = replay({file, {}}, rows);
  EXPECT_FALSE(result.agrees());
  EXPECT_LE(result.first_differences.size(), 10u);
  EXPECT_NE(result.first_differences.at(0).find("in the record"), std::string::npos);
}

TEST_F(Replayed, AreContactIfTheSurfacesOverlap) {
  start();
  cycleAt(0.5);
  cycleAt(0.19);
  const std::string text = explainEvent({stop().file, {}});
  EXPECT_EQ(text.find("collision: COLLISION: middle overlaps right by 10.0 mm"), 0u) << text;
  EXPECT_NE(text.find("contact: the surfaces"), std::string::npos) << text;
}

TEST_F(Replayed, AreNeitherFarFromAllThresholds) {
  start();
  cycleAt(0.5);
  const std::string text = explainEvent({stop().file, {}});
  EXPECT_EQ(text.find("service: CLEAR: "), 0u) << text;
  EXPECT_NE(text.find("\nclear: the pair is beyond all thresholds\n"), std::string::npos) << text;
}

TEST_F(Replayed, AreTheEnvelopeIfThePaddingDoesIt) {
  XmlRpc::XmlRpcValue values;
  values["default_padding"] = 0.01;
  const Config padded = configFrom(values, "node");
  config_.model = padded.model;
  config_.parameters = padded.parameters;
  start();
  cycleAt(0.5);
  cycleAt(0.232);
  const std::string text = explainEvent({stop().file, {}});
  EXPECT_EQ(text.find("stop: STOP: middle is 12.0 mm from right"), 0u) << text;
  EXPECT_NE(text.find("12.000 mm  distance that decided\n"), std::string::npos) << text;
  EXPECT_NE(text.find("20.000 mm  padding\n"), std::string::npos) << text;
  EXPECT_NE(text.find("32.000 mm  distance of the surfaces"), std::string::npos) << text;
  EXPECT_NE(text.find("envelope: without it the pair is beyond the threshold of 20 mm"), std::string::npos) << text;
}

TEST_F(Replayed, AreFilesForOtherTools) {
  XmlRpc::XmlRpcValue values;
  values["exclude_pairs"][0][0] = "left";
  values["exclude_pairs"][0][1] = "right";
  config_.parameters = configFrom(values, "node").parameters;
  start();
  cycleAt(0.5);
  cycleAt(0.3);
  add(ballAt(standingAt(0.35, 0.0, 0.0)));
  know();
  cycleAt(0.45);
  const std::vector<RecordFiles> written = writeFiles({stop().file, {}}, files_.path(""));
  ASSERT_EQ(written.size(), 2u) << "one for each set of objects";
  EXPECT_EQ(written[0].states, 2u);
  EXPECT_EQ(written[1].states, 1u);
  EXPECT_EQ(written[0].mesh_tolerance, config_.model.mesh_tolerance);
  const auto text = [&](const char* name) { return scene::readFile(files_.path(name)); };
  EXPECT_EQ(text("1/robot.urdf"), kSliders);
  EXPECT_NE(text("1/robot.srdf").find("<disable_collisions link1=\"left\" link2=\"right\""), std::string::npos)
      << text("1/robot.srdf");
  EXPECT_EQ(text("1/robot.srdf").find("link1=\"middle\" link2=\"right\""), std::string::npos);
  EXPECT_EQ(text("1/states.csv").find("time,\"to_left\",\"to_middle\",\"to_right\"\n1000.02,-1,0,0.5\n1000.04,"), 0u)
      << text("1/states.csv");
  EXPECT_EQ(text("1/objects.yaml").find("ball"), std::string::npos);
  EXPECT_NE(text("2/objects.yaml").find("ball"), std::string::npos);
}

TEST_F(Replayed, AreRefusedByNameIfThereIsNoRecord) {
  std::ostringstream rows;
  const auto refusal = [&](const std::string& file) { return scene::errorOf([&] { replay({file, {}}, rows); }); };
  EXPECT_EQ(refusal("/nowhere.bag").find("/nowhere.bag: "), 0u);
  EXPECT_EQ(refusal(files_.write("text.bag", "no bag")).find(files_.path("text.bag: it is no bag, or a damaged one: ")),
            0u);
}

// Regression: such a record ended the process.
TEST_F(Replayed, AreRefusedIfACycleComesBeforeWhatItNeeds) {
  const std::string file = recordOfRandomCycles(1, 3), part = files_.path("part.bag");
  for (const std::string left_out : {"objects", "poses"}) {
    {
      rosbag::Bag all(file, rosbag::bagmode::Read), some(part, rosbag::bagmode::Write);
      for (const rosbag::MessageInstance& message : rosbag::View(all))
        if (message.getTopic().find("/record/" + left_out) == std::string::npos)
          some.write(message.getTopic(), message.getTime(), message);
    }
    std::ostringstream rows;
    EXPECT_EQ(scene::errorOf([&] {
                replay({part, {}}, rows);
              }),
              part + ": cycle 1 comes before its .../record/" + left_out);
  }
}

}  // namespace proximity_server::node::replay_test
