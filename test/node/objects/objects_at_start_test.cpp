#include <proximity_server/ApplyObjects.h>
#include <proximity_server/Clearance.h>
#include <proximity_server/ObjectList.h>
#include "node/diagnosis.h"
#include "node/faults/child_process.h"
#include "node/gantry.h"
#include "node/object_messages.h"
#include "scene/files.h"
#include "tools/program/run_command.h"

#include <dynamic_reconfigure/Reconfigure.h>
#include <signal.h>

#include <map>
#include <memory>
#include <optional>
#include <string>

// The objects of a node that starts come from its parameter, or from the file of its start before. The robot is that of
// gantry.urdf, with its ball at (1, 0, 0). Objects are balls of radius 0.1 m.

namespace proximity_server::node::objects_at_start_test {

const std::string kName = "/cell";

XmlRpc::XmlRpcValue ball(const std::string& id, double x, double y) {
  XmlRpc::XmlRpcValue object;
  object["id"] = id;
  object["pose"]["position"]["x"] = x;
  object["pose"]["position"]["y"] = y;
  object["primitives"][0]["type"] = "SPHERE";
  object["primitives"][0]["dimensions"][0] = 0.1;
  return object;
}

class ObjectsAtStart : public testing::Test {
 protected:
  void TearDown() override { ros::param::del(kName); }

  /// The first list of objects of a node that starts now.
  std::optional<ObjectList> start() {
    node_.reset();
    Inbox<ObjectList> inbox(ros::NodeHandle(), kName + "/objects");
    node_ = std::make_unique<ChildProcess>(std::vector<std::string>{NODE_EXECUTABLE, "__name:=cell"});
    return inbox.next();
  }

  void end(int signal) {
    node_->signal(signal);
    EXPECT_TRUE(node_->hasEndedWithin(kPatience));
    node_.reset();
  }

  /// The node advertises its services after ~objects.
  static void apply(const ObjectChange& change) {
    ApplyObjectsResponse response;
    ApplyObjectsRequest request = requestOf({change});
    EXPECT_TRUE(ros::service::waitForService(kName + "/apply_objects", ros::Duration(20.0)));
    EXPECT_TRUE(ros::service::call(kName + "/apply_objects", request, response));
    EXPECT_TRUE(response.success) << response.status.message;
  }
  static void add(const std::string& id) { apply(addBall(id, poseAt(0.0, 5.0, 0.0))); }

  bool fileHas(const std::string& id) const {
    return scene::readFile(file_).find("\"" + id + "\"") != std::string::npos;
  }

  /// The output of a node that must not start.
  static std::string refusal() {
    const auto [exit_code, output, _] = tools::runCommand("timeout 20 " NODE_EXECUTABLE " __name:=cell 2>&1");
    EXPECT_EQ(exit_code, 1) << output;
    return output;
  }

  scene::TemporaryFiles files_;
  const std::string file_ = files_.path("objects.yaml");
  std::unique_ptr<ChildProcess> node_;
};

TEST_F(ObjectsAtStart, OfTheParameterAreInTheFirstListAndInTheFirstClearance) {
  XmlRpc::XmlRpcValue objects;
  objects[0] = ball("part", 1.0, 0.5);
  ros::param::set(kName + "/objects", objects);
  ros::param::set(kName + "/max_tf_age", 5.0);
  connectedGantry(0).hold({1.0, 0.0, 0.0});
  Inbox<Clearance> clearance(ros::NodeHandle(), kName + "/clearance");
  const auto list = start();
  ASSERT_TRUE(list);
  ASSERT_EQ(list->objects.size(), 1u);
  EXPECT_EQ(list->objects[0].id, "part");
  EXPECT_EQ(list->revision, 0u) << "nothing was changed since the start";
  const auto known = clearance.next([](const Clearance& message) { return message.level != Clearance::INVALID; });
  ASSERT_TRUE(known);
  EXPECT_NEAR(known->object_minimum.distance, 0.3, 1e-9);
  const auto model = Diagnosis("cell: model").next();
  ASSERT_TRUE(model);
  std::map<std::string, std::string> values;
  for (const auto& entry : model->values) values[entry.key] = entry.value;
  EXPECT_EQ(values["objects"], "1");
  EXPECT_EQ(values["pairs checked with objects"], "2") << "ball and block; the base stands still";
  connectedGantry(0).release();
}

TEST_F(ObjectsAtStart, OfAParameterThatIsWrongAreRefusedByFieldAndReason) {
  XmlRpc::XmlRpcValue objects;
  objects[0] = ball("part", 1.0, 0.5);
  objects[1] = ball("other", 1.0, 0.5);
  objects[1]["padding"] = -1.0;
  ros::param::set(kName + "/objects", objects);
  const std::string output = refusal();
  EXPECT_NE(output.find("parameter /cell/objects: [1] \"other\": padding: it is negative"), std::string::npos)
      << output;
}

TEST_F(ObjectsAtStart, AreThoseOfTheStartBeforeEvenIfThatWasKilled) {
  ros::param::set(kName + "/objects_file", file_);
  const auto first = start();
  ASSERT_TRUE(first);
  EXPECT_TRUE(first->objects.empty());
  add("part");
  ASSERT_TRUE(holdsWithin(kPatience, [&] { return fileHas("part"); })) << scene::readFile(file_);
  end(SIGKILL);
  const auto second = start();
  ASSERT_TRUE(second);
  ASSERT_EQ(second->objects.size(), 1u);
  EXPECT_EQ(second->objects[0].id, "part");
  EXPECT_EQ(second->objects[0].pose.position.y, 5.0);
  EXPECT_NE(second->node_start, first->node_start);
}

TEST_F(ObjectsAtStart, AreAllKeptIfTheNodeIsAskedToEnd) {
  ros::param::set(kName + "/objects_file", file_);
  ASSERT_TRUE(start());
  for (int i = 0; i < 20; ++i) add("part" + std::to_string(i));
  end(SIGINT);
  const auto second = start();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->objects.size(), 20u);
}

// A change of settings publishes ~objects too, mostly before the timer does.
TEST_F(ObjectsAtStart, AreKeptAlsoIfTheSettingsAreChangedAtOnce) {
  ros::param::set(kName + "/objects_file", file_);
  ASSERT_TRUE(start());
  ASSERT_TRUE(ros::service::waitForService(kName + "/set_parameters", ros::Duration(20.0)));
  for (const std::string id : {"a", "b", "c", "d"}) {
    add(id);
    dynamic_reconfigure::Reconfigure settings;
    ASSERT_TRUE(ros::service::call(kName + "/set_parameters", settings));
    EXPECT_TRUE(holdsWithin(kPatience, [&] { return fileHas(id); })) << scene::readFile(file_);
  }
}

TEST_F(ObjectsAtStart, OfAFileWinOverThoseOfTheParameter) {
  XmlRpc::XmlRpcValue objects;
  objects[0] = ball("part", 1.0, 0.5);
  ros::param::set(kName + "/objects", objects);
  ros::param::set(kName + "/objects_file", file_);
  const auto first = start();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->objects.size(), 1u) << "there was no file";
  EXPECT_TRUE(fileHas("part"));
  apply(change(ObjectChange::REMOVE, "part"));
  end(SIGINT);
  const auto second = start();
  ASSERT_TRUE(second);
  EXPECT_TRUE(second->objects.empty()) << "it was removed";
}

TEST_F(ObjectsAtStart, OfADamagedFileAreRefusedByFileAndLineAndNothingIsLost) {
  const std::string text = "objects:\n- id: part\n  primitives: [{type: SPHERE, dimensions: [0.1]}\n";
  files_.write("objects.yaml", text);
  ros::param::set(kName + "/objects_file", file_);
  const std::string output = refusal();
  EXPECT_NE(output.find(file_ + ", line 4: this is no YAML"), std::string::npos) << output;
  EXPECT_EQ(scene::readFile(file_), text);
}

TEST_F(ObjectsAtStart, NeedAFileThatCanBeWritten) {
  ros::param::set(kName + "/objects_file", "/nowhere/objects.yaml");
  EXPECT_NE(refusal().find("objects_file cannot be written: /nowhere/objects.yaml"), std::string::npos);
  ros::param::set(kName + "/objects_file", "objects.yaml");
  EXPECT_NE(refusal().find("parameter /cell/objects_file is 'objects.yaml', no absolute path"), std::string::npos);
}

}  // namespace proximity_server::node::objects_at_start_test
