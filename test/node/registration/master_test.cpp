#include <proximity_server/Clearance.h>
#include <proximity_server/MinimumDistance.h>
#include <proximity_server/ModelInfo.h>
#include "node/answers.h"
#include "node/faults/child_process.h"
#include "node/gantry.h"

#include <netinet/in.h>
#include <ros/network.h>
#include <sys/socket.h>
#include <unistd.h>
#include <xmlrpcpp/XmlRpcClient.h>

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

// A master of its own, which dies and comes back with an empty memory while the node runs on.

namespace proximity_server::node::master_test {

// What is promised.
constexpr std::chrono::seconds kRegisteredAgain{3};  // after the master is back

const std::string kNode = "/proximity_server";
constexpr double kDistance = 0.2;  // [m] between base and ball

std::string gantryUrdf() {
  std::ifstream file(PROXIMITY_SOURCE_DIR "/test/robots/gantry.urdf");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

int freePort() {
  sockaddr_in address{};  // of any port
  address.sin_family = AF_INET;
  socklen_t size = sizeof address;
  const int probe = socket(AF_INET, SOCK_STREAM, 0);
  const bool bound = bind(probe, reinterpret_cast<sockaddr*>(&address), size) == 0 &&
                     getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size) == 0;
  EXPECT_TRUE(bound);
  close(probe);
  return ntohs(address.sin_port);
}

/// A ROS master at the address that everything in this process uses.
class Master {
 public:
  Master() { start(); }

  void start() {
    const std::string port = std::to_string(ros::master::getPort());
    process_.emplace(std::vector<std::string>{"rosmaster", "--core", "-p", port});
    EXPECT_TRUE(holdsWithin(kPatience, ros::master::check));
  }
  void die() { process_.reset(); }

 private:
  std::optional<ChildProcess> process_;
};

/// Everything that the master lists of the node: topics that it publishes, that it subscribes to, and services.
std::set<std::string> registrations() {
  XmlRpc::XmlRpcValue request, response, state;
  request[0] = ros::this_node::getName();
  std::set<std::string> result;
  if (!ros::master::execute("getSystemState", request, response, state, false)) return result;
  const char* const kinds[] = {"publishes ", "subscribes to ", "serves "};
  for (int kind = 0; kind < 3; ++kind) {
    for (int i = 0; i < state[kind].size(); ++i) {
      XmlRpc::XmlRpcValue& nodes = state[kind][i][1];
      for (int j = 0; j < nodes.size(); ++j) {
        if (std::string(nodes[j]) == kNode) result.insert(kinds[kind] + std::string(state[kind][i][0]));
      }
    }
  }
  return result;
}

/// Asks the master for an address by a method such as lookupService. Returns "" if it does not know the name.
std::string lookUp(const std::string& method, const std::string& name) {
  XmlRpc::XmlRpcValue request, response, found;
  request[0] = ros::this_node::getName();
  request[1] = name;
  return ros::master::execute(method, request, response, found, false) ? std::string(found) : "";
}

/// The port at which the master tells clients to ask a service; 0 if it does not know the service.
std::uint32_t portOf(const std::string& service) {
  std::string host;
  std::uint32_t port = 0;
  ros::network::splitURI(lookUp("lookupService", kNode + "/" + service), host, port);
  return port;
}

/// The port from which the node tells subscribers to get its topics.
std::uint32_t portOfTopics() {
  std::string host;
  std::uint32_t port = 0;
  ros::network::splitURI(lookUp("lookupNode", kNode), host, port);
  XmlRpc::XmlRpcValue request, response;
  request[0] = ros::this_node::getName();
  request[1] = kNode + "/clearance";
  request[2][0][0] = "TCPROS";
  XmlRpc::XmlRpcClient node(host.c_str(), static_cast<int>(port));
  if (!node.execute("requestTopic", request, response)) return 0;
  return static_cast<std::uint32_t>(static_cast<int>(response[2][2]));
}

bool isClear(const Clearance& message) {
  return message.level == Clearance::CLEAR && std::abs(message.minimum.distance - kDistance) <= kTolerance;
}

bool isAnswered() {
  MinimumDistanceRequest request;
  request.a = shape("base");
  request.b = shape("ball");
  MinimumDistanceResponse response;
  return ros::service::call(kNode + "/minimum_distance", request, response) && response.success;
}

/// A robot that stands still, and somebody who listens to the node.
struct Neighbours {
  Neighbours() : gantry(ros::NodeHandle()), inbox(ros::NodeHandle(), kNode + "/clearance") {
    gantry.hold({kDistance + 0.2, 0.0, 0.0});
  }
  Gantry gantry;
  Inbox<Clearance> inbox;
};

class MasterThatDies : public testing::Test {
 protected:
  MasterThatDies() {
    spinner_.start();
    ros::param::set("/robot_description", gantryUrdf());
    startNode();
    neighbours_.emplace();
  }

  void SetUp() override {
    ASSERT_TRUE(isRegistered());
    ASSERT_TRUE(neighbours_->inbox.next(isClear));
    before_ = registrations();
    ASSERT_GT(before_.size(), 10u);
  }

  void startNode(const std::vector<std::string>& remappings = {}) {
    std::vector<std::string> command = {NODE_EXECUTABLE, "__name:=proximity_server"};
    command.insert(command.end(), remappings.begin(), remappings.end());
    node_.emplace(command);
  }
  /// As Ctrl-C does.
  void stopNode() {
    node_->signal(SIGINT);
    EXPECT_TRUE(node_->hasEndedWithin(kPatience));
  }
  /// Waits for the last that a node does when it starts: levels come earlier, when it is not yet registered as a whole.
  static bool isRegistered() { return Inbox<ModelInfo>(ros::NodeHandle(), kNode + "/model_info").next().has_value(); }

  Master master_;
  ros::NodeHandle keeps_ros_running_;
  ros::AsyncSpinner spinner_{2};
  std::optional<ChildProcess> node_;
  std::optional<Neighbours> neighbours_;
  std::set<std::string> before_;
};

TEST_F(MasterThatDies, DisturbsNobodyWhoIsConnectedAndIsRegisteredWithOnceItIsBack) {
  master_.die();
  neighbours_->inbox.clear();
  for (int n = 0; n < 50; ++n) {
    const auto message = neighbours_->inbox.next();
    ASSERT_TRUE(message);
    EXPECT_TRUE(isClear(*message)) << message->status.message;
  }

  master_.start();
  EXPECT_TRUE(holdsWithin(kRegisteredAgain, [&] { return registrations() == before_; }));
  EXPECT_TRUE(isAnswered());

  // Newcomers, who know nobody but the new master, and whom nobody else knows.
  neighbours_.reset();
  neighbours_.emplace();
  EXPECT_TRUE(neighbours_->inbox.next(isClear));
  EXPECT_TRUE(node_->isRunning());
}

using ServiceAddress = MasterThatDies;

// Regression: requests and topics shared a thread, so that many clients delayed the levels by tens of milliseconds.
TEST_F(ServiceAddress, IsAPortThatHasNoTopics) {
  const std::uint32_t port = portOf("minimum_distance");
  for (const char* const service : {"query_pairs", "reload", "set_parameters"})
    EXPECT_EQ(portOf(service), port) << service;
  EXPECT_NE(portOfTopics(), port);
  EXPECT_TRUE(isAnswered());
}

TEST_F(ServiceAddress, IsThatOfTheTopicsIfThePortIsFixed) {
  stopNode();
  const auto port = static_cast<std::uint32_t>(freePort());
  startNode({"__tcpros_server_port:=" + std::to_string(port)});
  ASSERT_TRUE(isRegistered());
  EXPECT_EQ(portOf("minimum_distance"), port);
  EXPECT_EQ(portOfTopics(), port);
  EXPECT_TRUE(holdsWithin(kPatience, isAnswered));  // as soon as it has transforms
}

TEST_F(ServiceAddress, IsForgottenWhenTheNodeEnds) {
  stopNode();
  EXPECT_EQ(registrations(), std::set<std::string>());
}

}  // namespace proximity_server::node::master_test

/// Not a rostest, whose master must live.
int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const std::string uri = "http://localhost:" + std::to_string(proximity_server::node::master_test::freePort());
  setenv("ROS_MASTER_URI", uri.c_str(), /*overwrite=*/1);
  ros::init(argc, argv, "master_test", ros::init_options::NoRosout);
  return RUN_ALL_TESTS();
}
