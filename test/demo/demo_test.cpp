#include <rosgraph_msgs/Log.h>
#include <sensor_msgs/JointState.h>

#include <cstdio>
#include <memory>

#include "node/gantry.h"

// The programs of ./dev demo beside the node, with the robot of odd_names.urdf.

namespace proximity_server::node::demo_test {

// Regression: a parameter was named after each joint, which ROS refuses with an exception.
TEST(DemoMotion, MovesJointsWhoseNamesAreNoNamesOfRos) {
  for (const std::string node : {"sweep", "script"}) {
    Inbox<sensor_msgs::JointState> inbox(ros::NodeHandle(), "/" + node + "/joint_states");
    const auto state = inbox.next();
    ASSERT_TRUE(state) << node;
    EXPECT_EQ(state->name, (std::vector<std::string>{"shoulder.pan", "elbow flex", "håndled"}));
    if (node == "script") {
      EXPECT_EQ(state->position, (std::vector<double>{0.0, 9.0, 0.0}));
    }
  }
}

/// The lines of a table that runs, which ends with its reader.
class Table {
 public:
  Table() : lines_(popen("exec timeout 40 " CLEARANCE_TABLE " clearance:=/slow/clearance", "r")) {}
  ~Table() { pclose(lines_); }

  /// The next line, or "" at the end.
  std::string next() {
    char line[512];
    return fgets(line, sizeof line, lines_) ? line : "";
  }

 private:
  FILE* lines_;
};

TEST(ClearanceTable, SaysWhatTheNodeSaidLastWhileNothingArrives) {
  ros::Publisher log = ros::NodeHandle().advertise<rosgraph_msgs::Log>("/rosout", 10);
  rosgraph_msgs::Log words;
  words.name = "/slow";
  words.msg = "Loading: link 'arm'\nand more of it";
  rosgraph_msgs::Log others = words;
  others.name = "/somebody";
  others.msg = "unheard";

  auto table = std::make_unique<Table>();
  std::string line;
  do {
    log.publish(words);
    log.publish(others);
    line = table->next();
  } while (!line.empty() && line.find("the node says") == std::string::npos);
  EXPECT_NE(line.find("nothing has arrived on /slow/clearance"), std::string::npos) << line;
  EXPECT_NE(line.find("; the node says: Loading: link 'arm'\n"), std::string::npos) << line;
}

}  // namespace proximity_server::node::demo_test
