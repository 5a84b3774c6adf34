// Clouds of sensed sources as boxes, without topics. The robot has balls of radius 0.1 m at x = -1, 0 and 0.5.
#include "node/sources/cloud_boxes.h"

#include "node/monitor/slider_robot.h"
#include "scene/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace proximity_server::node::cloud_boxes_test {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

Config sensing(const Sensing& how) {
  Config config;
  TrackedSource& camera = config.tracked.emplace_back();
  camera.name = "camera";
  camera.sensing = how;
  return config;
}

std::shared_ptr<const Robot> robotWith(const Config& config) {
  return std::make_shared<const Robot>(kSliders, "", config);
}

class SeenSliders : public testing::Test {
 protected:
  explicit SeenSliders(const Sensing& how = {0.02, 0.03, {{"right", 0.05}}, 3.0})
      : robot_(robotWith(sensing(how))), boxes_(how) {}

  /// From a camera 2 m above the ball in the middle.
  std::vector<scene::ObjectShape> seen(Points points, double time = 0.0) {
    points_ = std::move(points);
    cloud_ = {};
    const Eigen::Isometry3d above(Eigen::Translation3d(0.0, 0.0, 2.0));
    return boxes_.make(robot_, *robot_->objects().get().all, {time, above, withTheRightSphereAt(*robot_, 0.5).poses},
                       points_, cloud_);
  }

  std::shared_ptr<const Robot> robot_;
  CloudBoxes boxes_;
  Points points_;
  SensedCloud cloud_;
};

TEST_F(SeenSliders, AreLeftOutWithWhatIsOutOfRange) {
  const Points on_robot{{0.0, 0.0, -1.88}, {-1.0, 0.129, -2.0}, {0.5, 0.149, -2.0}, {0.0, 0.05, -2.0}},
      beyond{{0.0, 0.0, -3.01}, {2.5, 2.5, -2.0}}, others{{0.0, 0.0, -1.86}, {-1.0, 0.131, -2.0}, {0.5, 0.151, -2.0}};
  Points all = others;
  for (const Points& more : {on_robot, beyond}) all.insert(all.end(), more.begin(), more.end());
  const std::vector<scene::ObjectShape> shapes = seen(all);
  EXPECT_EQ(cloud_.points, 9U);
  EXPECT_EQ(cloud_.out_of_range, 2U);
  EXPECT_EQ(cloud_.on_robot, 4U);
  EXPECT_EQ(cloud_.voxels, 3U);
  ASSERT_EQ(points_.size(), others.size());
  ASSERT_EQ(shapes.size(), 1U);
  const auto& boxes = std::get<scene::Boxes>(shapes[0].geometry).boxes;
  EXPECT_EQ(boxes.size(), cloud_.boxes);
  for (std::size_t i = 0; i < others.size(); ++i) {
    EXPECT_EQ(points_[i], others[i] + Vector3d(0.0, 0.0, 2.0));
    EXPECT_TRUE(std::any_of(boxes.begin(), boxes.end(), [&](const auto& box) { return box.contains(points_[i]); }));
  }
}

TEST_F(SeenSliders, LeaveNothingOfTheirOwn) {
  EXPECT_TRUE(seen({{0.0, 0.0, -1.9}, {-1.0, 0.0, -2.1}}).empty());
  EXPECT_EQ(cloud_.on_robot, 2U);
  EXPECT_EQ(cloud_.boxes, 0U);
}

TEST_F(SeenSliders, HoldWhatIsTheirOwn) {
  const RobotObjects before = robot_->objects().get();
  robot_->objects().set(
      {std::make_shared<const scene::Objects>(before.all->changed(
           {scene::AddObject{ballAt(scene::Attached{"middle", {}, standingAt(0, 0.5, 0).world_T_object})},
            scene::AddObject{ballAt(standingAt(0, -0.5, 0), "other")}})),
       before.revision + 1});
  seen({{0.0, 0.5, -1.88}, {0.0, -0.5, -1.88}});
  EXPECT_EQ(cloud_.on_robot, 1U);
  ASSERT_EQ(points_.size(), 1U);
  EXPECT_EQ(points_[0].y(), -0.5);
}

class SeenBesideKnownObjects : public SeenSliders {
 protected:
  SeenBesideKnownObjects() : SeenSliders(how()) {}
  static Sensing how() {
    Sensing how{0.02, 0.03, {}, 3.0};
    how.object_padding = {{"ball", 0.05}, {"floor", 0.02}, {"absent", 0.1}};
    return how;
  }
};

/// The balls have a radius of 0.1 m.
TEST_F(SeenBesideKnownObjects, HasOnlyThePointsThatNoneOfThemShows) {
  const RobotObjects before = robot_->objects().get();
  robot_->objects().set({std::make_shared<const scene::Objects>(
                             before.all->changed({scene::AddObject{ballAt(standingAt(0, -0.5, 0))},
                                                  scene::AddObject{ballAt(standingAt(0, -1.5, 0), "other")}})),
                         before.revision + 1});
  seen({{0.0, -0.5, -1.851}, {0.0, -0.5, -2.0}, {0.0, -0.5, -1.849}, {0.0, -1.5, -2.0}});
  EXPECT_EQ(cloud_.on_robot, 2U);
  ASSERT_EQ(points_.size(), 2U);
  EXPECT_EQ(points_[0].z(), 2.0 - 1.849);
  EXPECT_EQ(points_[1].y(), -1.5);
}

TEST_F(SeenBesideKnownObjects, HasNoPointOfTheFloor) {
  const scene::Object floor = scene::makeObject("floor", {{scene::HalfSpace{Vector3d::UnitZ(), -0.4}}}, scene::Fixed{});
  const RobotObjects before = robot_->objects().get();
  robot_->objects().set(
      {std::make_shared<const scene::Objects>(before.all->changed({scene::AddObject{floor}})), before.revision + 1});
  seen({{0.0, 1.0, -2.381}, {0.0, 1.0, -2.379}, {0.5, -1.0, -2.5}});
  EXPECT_EQ(cloud_.on_robot, 2U);
  ASSERT_EQ(points_.size(), 1U);
  EXPECT_EQ(points_[0].z(), 2.0 - 2.379);
}

/// The voxel of a plate 3 m below the camera stays for a second.
class SeenForASecond : public SeenSliders {
 protected:
  static Sensing with(bool clearing) { return {0.02, 0.03, {}, 3.5, 1.0, clearing}; }
  explicit SeenForASecond(bool clearing = true) : SeenSliders(with(clearing)) {}

  const Vector3d plate_{0.01, 0.01, -2.99}, hand_{0.0, 0.0, -1.9}, floor_{0.0101, 0.0101, -3.2};
};

TEST_F(SeenForASecond, StaysBehindTheRobot) {
  seen({plate_});
  EXPECT_EQ(seen({hand_}, 1.0).size(), 1U);
  EXPECT_EQ(cloud_.on_robot, 1U);
  EXPECT_EQ(cloud_.voxels, 1U);
  EXPECT_EQ(cloud_.persistent, 1U);
  EXPECT_TRUE(seen({hand_}, 1.01).empty()) << "it is too old";
}

TEST_F(SeenForASecond, StaysThroughAnEmptyCloud) {
  seen({plate_});
  EXPECT_EQ(seen({}, 0.1).size(), 1U);
}

TEST_F(SeenForASecond, LeavesWhereSomethingBehindItIsSeen) {
  seen({plate_});
  seen({floor_}, 0.1);
  EXPECT_EQ(cloud_.persistent, 0U);
  seen({plate_}, 0.2);
  EXPECT_EQ(cloud_.persistent, 1U) << "the floor is hidden";
  seen({{0.0101, 0.0101, -90.0}}, 0.3);
  EXPECT_EQ(cloud_.out_of_range, 1U);
  EXPECT_EQ(cloud_.voxels, 0U) << "the way to the range is clear; then nothing is left of the floor, which is nearer";
}

class SeenWithoutClearing : public SeenForASecond {
 protected:
  SeenWithoutClearing() : SeenForASecond(false) {}
};

TEST_F(SeenWithoutClearing, StaysWhereSomethingBehindItIsSeen) {
  seen({plate_});
  seen({floor_}, 0.1);
  EXPECT_EQ(cloud_.persistent, 1U);
}

class SeenInPart : public SeenSliders {
 protected:
  SeenInPart() : SeenSliders({0.02, 0.03, {}, 3.0, 0.0, true, 4}) {}
};

TEST_F(SeenInPart, IsACloudOfTooManyPoints) {
  Points points;
  for (int i = 0; i < 9; ++i) points.emplace_back(0.1 * i, 0.5, -2.0);
  seen(points);
  EXPECT_EQ(cloud_.points, 9U);
  EXPECT_EQ(cloud_.over_limit, 6U) << "the first of each three is left";
  ASSERT_EQ(points_.size(), 3U);
  EXPECT_EQ(points_[1].x(), points[3].x());
}

TEST(SensedSource, ThatHidesWhatComesNearIsRefused) {
  const auto refusal = [](const Sensing& how) { return scene::errorOf([&] { robotWith(sensing(how)); }); };
  EXPECT_EQ(refusal({0.02, 0.065, {}, 3.0}), "");
  EXPECT_EQ(
      refusal({0.02, 0.066, {}, 3.0}),
      "sensed_stop_distance is 0.1, not above 0.101, the self padding of sensed source 'camera' plus the diagonal "
      "of its voxels");
  EXPECT_NE(refusal({0.02, 0.01, {{"left", 0.066}}, 3.0}), "");
  EXPECT_EQ(refusal({0.02, 0.01, {{"lift", 0.01}}, 3.0}),
            "parameter sensed: link_self_padding: there is no link \"lift\" (did you mean \"left\"?)");
}

}  // namespace proximity_server::node::cloud_boxes_test
