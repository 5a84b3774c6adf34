// Changes that come faster than they are applied.
#include "node/objects/change_stream.h"

#include "node/object_messages.h"
#include "robots/urdf.h"

#include <gtest/gtest.h>
#include <boost/make_shared.hpp>

#include <future>
#include <string>
#include <vector>

namespace proximity_server::node::change_stream_test {

const std::string kBall = robots::urdfOf(robots::link("ball", robots::ball("0.1")));

ObjectChange moveTo(const std::string& id, double x) { return node::moveTo(id, poseAt(x, 0.0, 0.0)); }

/// A triangle, read as a mesh.
ObjectChange addMesh(const std::string& id) {
  ObjectChange result = change(ObjectChange::ADD, id);
  result.meshes.resize(1);
  result.meshes[0].vertices.resize(3);
  result.meshes[0].vertices[1].x = result.meshes[0].vertices[2].y = 1.0;
  result.meshes[0].triangles.resize(1);
  for (std::uint32_t k = 0; k < 3; ++k) result.meshes[0].triangles[0].vertex_indices[k] = k;
  return result;
}

boost::shared_ptr<const ObjectChanges> message(const std::vector<ObjectChange>& changes) {
  return boost::make_shared<ObjectChanges>(messageOf(changes));
}

/// A stream whose first change, the object "first", is being applied until release() is called.
class BusyStream : public testing::Test {
 protected:
  void SetUp() override {
    stream_.enqueue(message({addBall("first")}));
    is_busy_.get_future().wait();
  }
  void TearDown() override { release(); }

  void release() {
    if (!is_released_) released_.set_value();
    is_released_ = true;
  }

  /// When all that was taken is applied or left out.
  void finish() {
    stream_.enqueue(message({addBall("last")}));
    release();
    is_finished_.get_future().wait();
  }

  std::vector<std::string> refusals() const { return refusals_; }

  std::shared_ptr<const Robot> robot_ = std::make_shared<const Robot>(kBall, "", Config());
  int changes_ = 0;  ///< of the robot's objects
  ObjectStore store_{robot_, 7, nullptr, [this](const Robot&) { onChange(); }};

 private:
  void onChange() {
    if (++changes_ == 1) {
      is_busy_.set_value();
      released_.get_future().wait();
    }
    if (robot_->objects().get().all->find("last") >= 0) is_finished_.set_value();
  }

  std::promise<void> is_busy_, released_, is_finished_;
  bool is_released_ = false;
  std::vector<std::string> refusals_;

 protected:
  ChangeStream stream_{store_, [this](const std::string& reason) { refusals_.push_back(reason); }};
};

// Before, each of a thousand messages made the next objects of the robot, and let the monitor take them.
TEST_F(BusyStream, AppliesAllThatWaitsInOneChangeInItsOrder) {
  for (int i = 1; i <= 1000; ++i) stream_.enqueue(message({moveTo("first", i)}));
  finish();
  EXPECT_EQ(changes_, 2);
  const auto objects = robot_->objects().get().all;
  EXPECT_EQ(std::get<scene::Fixed>(objects->object(objects->find("first"))->placement).world_T_object.translation().x(),
            1000.0);
  EXPECT_TRUE(refusals().empty());
}

TEST_F(BusyStream, LeavesOutOnlyTheMessagesThatAreToBlame) {
  for (int i = 0; i < 100; ++i) {
    stream_.enqueue(message({addBall("object" + std::to_string(i))}));
    stream_.enqueue(message({moveTo("missing" + std::to_string(i), 1.0)}));
  }
  finish();
  EXPECT_EQ(refusals().size(), 100u);
  EXPECT_EQ(store_.list().objects.size(), 102u);
}

TEST_F(BusyStream, AppliesAMessageWithAMeshAloneSoThatNoOtherWaitsForIt) {
  stream_.enqueue(message({addBall("before")}));
  stream_.enqueue(message({addMesh("mesh")}));
  stream_.enqueue(message({addBall("after")}));
  finish();
  EXPECT_EQ(changes_, 4);
  EXPECT_EQ(store_.list().objects.size(), 5u);
}

TEST_F(BusyStream, RefusesMessagesBeyondTheirLimit) {
  const auto moved = message({moveTo("first", 1.0)});
  for (std::size_t i = 0; i < ChangeStream::kMaxMessages + 3; ++i) stream_.enqueue(moved);
  ASSERT_EQ(refusals().size(), 3u);
  EXPECT_NE(refusals()[0].find("too many changes wait"), std::string::npos);
}

TEST_F(BusyStream, RefusesMessagesBeyondTheirBytes) {
  ObjectChange many = change(ObjectChange::REPLACE, "map");
  many.boxes.resize(1);
  many.boxes[0].centres.resize(1000000);  // 24 MB
  many.boxes[0].sizes.resize(1);
  const auto large = message({many});
  for (int i = 0; i < 4; ++i) stream_.enqueue(large);
  EXPECT_EQ(refusals().size(), 2u) << "64 MB may wait";
}

}  // namespace proximity_server::node::change_stream_test
