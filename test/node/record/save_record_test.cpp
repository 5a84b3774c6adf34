// The service of a running node.
#include "node/diagnosis.h"
#include "node/gantry.h"

#include <std_srvs/Trigger.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace proximity_server::node::save_record_test {

TEST(SaveRecord, WritesABagAndTellsItsName) {
  connectedGantry(1).hold({1.0, 0.0, 0.0});
  const std::string begin = "/tmp/proximity_save_record/proximity_server/proximity_server_";
  const auto response = call<std_srvs::TriggerResponse>("/proximity_server/save_record", std_srvs::TriggerRequest());
  EXPECT_TRUE(response.success) << response.message;
  ASSERT_EQ(response.message.find(begin), 0u) << response.message;
  EXPECT_GT(std::filesystem::file_size(response.message), 10000u);
  const auto status = Diagnosis("proximity_server: record").next();
  ASSERT_TRUE(status);
  EXPECT_EQ(status->message, "recorded");
  const auto programs = std::filesystem::path(NODE_EXECUTABLE).parent_path();
  const std::string replay = programs / "replay", clearance = programs / "clearance";
  EXPECT_EQ(std::system((replay + " --replay " + response.message).c_str()), 0) << "the states of a running node";
  // FCL and the tools are optional.
  const bool has_fcl = std::system((clearance + " --help | grep -q fcl").c_str()) == 0;
  const std::string second_opinion = replay + " --second-opinion fcl --replay " + response.message;
  EXPECT_TRUE(!has_fcl || std::system(second_opinion.c_str()) == 0);
  if (std::filesystem::exists(clearance)) {
    const std::string report = replay + " --report /tmp/proximity_save_record/stop.html --replay " + response.message;
    EXPECT_EQ(std::system(report.c_str()), 0);
    EXPECT_GT(std::filesystem::file_size("/tmp/proximity_save_record/stop.html"), 10000u);
    EXPECT_TRUE(std::filesystem::exists("/tmp/proximity_save_record/stop_files/1/robot.urdf"));
  }
  std::filesystem::remove_all("/tmp/proximity_save_record");
  connectedGantry(1).release();
}

}  // namespace proximity_server::node::save_record_test
