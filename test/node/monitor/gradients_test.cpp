// Gradients of the monitor's messages and of the services: those of the scene, to the last bit.
#include <gtest/gtest.h>
#include <ros/serialization.h>

#include <cmath>
#include <fstream>
#include <optional>
#include <random>
#include <sstream>

#include "node/monitor/monitor.h"
#include "node/monitor/slider_robot.h"
#include "node/services/pair_questions.h"
#include "node/tf/joint_frames.h"
#include "sanitized.h"

namespace proximity_server::node {
namespace {

std::string bytesOf(const Proximity& message) {
  std::string bytes(ros::serialization::serializationLength(message), '\0');
  ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()),
                                     static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

/// The robot of the demo in random states within its limits, asked about in this process.
class GradientsOfTheDemo : public testing::Test {
 protected:
  GradientsOfTheDemo() {
    monitor_.follow(robot_);
    settings_.gradients = true;
  }

  static std::string demo(const std::string& file) {
    std::ifstream stream(PROXIMITY_SOURCE_DIR "/config/demo/" + file);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }
  static Config configOfDemo() {
    Config config;
    config.mesh_roots = {PROXIMITY_SOURCE_DIR "/.."};
    config.model.mesh_cache = "";
    config.allowed_mesh_roots = {};
    return config;
  }

  PoseSnapshot randomPoses() {
    PoseSnapshot snapshot;
    snapshot.stamp = ros::Time(1000.0);
    std::vector<double> positions;
    for (const scene::Joint& joint : robot_->robotModel().joints) {
      const double range = std::isfinite(joint.upper - joint.lower) ? joint.upper - joint.lower : 6.0;
      const double lowest = std::isfinite(joint.lower) ? joint.lower : -3.0;
      positions.push_back(lowest + range * std::uniform_real_distribution<>(0.0, 1.0)(random_));
    }
    snapshot.poses = scene::forwardKinematics(robot_->robotModel(), positions);
    return snapshot;
  }

  /// What query_pairs says in these poses.
  StateProximity ask(std::uint8_t mode, const PoseSnapshot& snapshot) {
    QueryPairsRequest request;
    request.mode = mode;
    request.threshold = mode == QueryPairsRequest::BELOW_THRESHOLD ? settings_.threshold : 0.0;
    request.want_gradient = true;
    const RequestedPairs pairs = pairsOf(*robot_, request);
    const ScenePool::Lease scene = pairs.borrowScene();
    scene->update(snapshot.poses);
    std::optional<Gradients> gradients = gradientsOf(*robot_, pairs, request);
    return askPairs(*robot_, *scene, {snapshot.poses, snapshot.status}, pairs, request, questionOf(*robot_, request),
                    gradients);
  }

  std::shared_ptr<const Robot> robot_ = std::make_shared<const Robot>(demo("robot.urdf"), demo("robot.srdf"), configOfDemo());
  Monitor monitor_;
  MonitorSettings settings_;
  std::mt19937 random_{20};
};

TEST_F(GradientsOfTheDemo, AreThoseOfTheServicesToTheLastBit) {
  int listed = 0;
  for (int i = 0; i < repeats(300); ++i) {
    const PoseSnapshot snapshot = randomPoses();
    const Clearance& clearance = monitor_.cycle(snapshot, {}, settings_);
    const StateProximity minimum = ask(QueryPairsRequest::MINIMUM, snapshot);
    EXPECT_EQ(bytesOf(clearance.minimum), bytesOf(minimum.minimum)) << i;
    EXPECT_EQ(bytesOf(clearance.self_minimum), bytesOf(minimum.minimum)) << i;
    const StateProximity below = ask(QueryPairsRequest::BELOW_THRESHOLD, snapshot);
    ASSERT_LE(clearance.below_threshold.size(), below.pairs.size());
    for (std::size_t k = 0; k < clearance.below_threshold.size(); ++k)
      EXPECT_EQ(bytesOf(clearance.below_threshold[k]), bytesOf(below.pairs[k])) << i << ", pair " << k;
    listed += static_cast<int>(clearance.below_threshold.size());
  }
  if (!kIsSanitized) EXPECT_GT(listed, 1000);
}

TEST_F(GradientsOfTheDemo, AreThoseOfTheSceneToTheLastBit) {
  scene::Scene scene(robot_->sharedModel());
  scene::Derivatives derivatives(robot_->sharedModel());
  Eigen::VectorXd row(derivatives.degreesOfFreedom().size());
  int unique = 0;
  for (int i = 0; i < repeats(300); ++i) {
    const PoseSnapshot snapshot = randomPoses();
    const Clearance& clearance = monitor_.cycle(snapshot, {}, settings_);
    scene.update(snapshot.poses);
    derivatives.update(snapshot.poses);
    const scene::PairProximity* minimum = scene.minimum(robot_->candidates());
    ASSERT_NE(minimum, nullptr);
    ASSERT_TRUE(derivatives.gradient(*minimum, row));
    EXPECT_EQ(clearance.minimum.gradient, std::vector<double>(row.data(), row.data() + row.size())) << i;
    unique += clearance.minimum.unique;
  }
  if (!kIsSanitized) EXPECT_GT(unique, 100);
}

TEST_F(GradientsOfTheDemo, HaveOneEntryForEachJointAndTheJointItsPosition) {
  std::vector<double> positions;
  std::vector<std::string> names;
  for (const scene::Joint& joint : robot_->robotModel().joints) {
    positions.push_back(0.5 * (joint.lower + joint.upper));
    names.push_back(joint.name);
  }
  PoseSnapshot snapshot;
  snapshot.poses = scene::forwardKinematics(robot_->robotModel(), positions);
  const Clearance& clearance = monitor_.cycle(snapshot, {}, settings_);
  EXPECT_EQ(clearance.joint_names, names);
  ASSERT_EQ(clearance.joint_positions.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) EXPECT_NEAR(clearance.joint_positions[i], positions[i], 1e-12) << i;
  EXPECT_EQ(clearance.minimum.gradient.size(), names.size());
}

TEST_F(GradientsOfTheDemo, AddNothingToAMessageThatIsNotAskedForThem) {
  const PoseSnapshot snapshot = randomPoses();
  monitor_.cycle(snapshot, {}, settings_);
  settings_.gradients = false;
  const Clearance& clearance = monitor_.cycle(snapshot, {}, settings_);
  EXPECT_TRUE(clearance.joint_names.empty());
  EXPECT_TRUE(clearance.joint_positions.empty());
  EXPECT_TRUE(clearance.minimum.gradient.empty());
  EXPECT_TRUE(clearance.self_minimum.gradient.empty());
  for (const Proximity& pair : clearance.below_threshold) EXPECT_TRUE(pair.gradient.empty());
}

// --- on paper: three sliding spheres

class GradientsOfSliders : public MonitorOfSliders {
 protected:
  GradientsOfSliders() { settings_.gradients = true; }
  std::vector<double> toObject(const scene::Placement& placement) {
    add(ballAt(placement));
    const std::size_t frames = monitor_.frames().names.size();
    return cycle(std::vector(frames, std::optional(Eigen::Isometry3d::Identity()))).object_minimum.gradient;
  }
};

TEST_F(GradientsOfSliders, AreTheSignsOfTheAxes) {
  follow("");
  const Clearance& clearance = cycle();
  EXPECT_EQ(clearance.joint_names, (std::vector<std::string>{"to_left", "to_middle", "to_right"}));
  EXPECT_EQ(clearance.joint_positions, (std::vector<double>{-1.0, 0.0, 0.5}));
  EXPECT_EQ(clearance.minimum.gradient, (std::vector<double>{0.0, -1.0, 1.0}));  // middle and right
  EXPECT_EQ(clearance.self_minimum.gradient, clearance.minimum.gradient);
  EXPECT_TRUE(clearance.object_minimum.gradient.empty());
}

TEST_F(GradientsOfSliders, OfAFixedObjectAreThoseOfTheLink) {
  follow("");
  EXPECT_EQ(toObject(standingAt(-0.5, 0.0, 0.0)), (std::vector<double>{0.0, 1.0, 0.0}));  // 0.3 m left of the middle
}

TEST_F(GradientsOfSliders, OfAnAttachedObjectAreThoseOfItsLink) {
  follow("");
  scene::Attached held{"middle"};
  held.link_T_object.translation().x() = -0.7;
  EXPECT_EQ(toObject(held), (std::vector<double>{-1.0, 1.0, 0.0}));  // to the left sphere
}

TEST_F(GradientsOfSliders, OfAnObjectInTheFrameOfALinkAreThoseOfThatLink) {
  follow("");
  EXPECT_EQ(toObject(scene::Moving{"middle", Eigen::Isometry3d(Eigen::Translation3d(-0.7, 0.0, 0.0))}),
            (std::vector<double>{-1.0, 1.0, 0.0}));
}

TEST_F(GradientsOfSliders, OfAnObjectInAnotherFrameTakeItToRest) {
  follow("");
  EXPECT_EQ(toObject(scene::Moving{"camera", Eigen::Isometry3d(Eigen::Translation3d(-0.7, 0.0, 0.0))}),
            (std::vector<double>{-1.0, 0.0, 0.0}));
}

// The frame of the answers is the middle sphere, which stands at x = 0; what is fixed there moves with it.
TEST_F(GradientsOfSliders, OfAFixedObjectInAReferenceFrameThatMovesAreThoseOfTheFrame) {
  config_.reference_frame = "middle";
  follow("");
  EXPECT_EQ(toObject(standingAt(-0.7, 0.0, 0.0)), (std::vector<double>{-1.0, 1.0, 0.0}));
}

TEST_F(GradientsOfSliders, AreEmptyAndPositionsNaNWhereNoPoseIsKnown) {
  follow("");
  PoseSnapshot snapshot = withTheRightSphereAt(*robot_, 0.5);
  snapshot.poses.back().reset();
  const Clearance& clearance = monitor_.cycle(snapshot, {}, settings_);
  EXPECT_EQ(clearance.level, Clearance::INVALID);
  EXPECT_TRUE(clearance.minimum.gradient.empty());
  ASSERT_EQ(clearance.joint_positions.size(), 3u);
  EXPECT_EQ(clearance.joint_positions[1], 0.0);
  EXPECT_TRUE(std::isnan(clearance.joint_positions[2]));
}

TEST_F(GradientsOfSliders, FollowTheNextRobot) {
  follow("");
  cycle();
  robot_ = std::make_shared<const Robot>(R"(<robot name="two"><link name="a"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
    <link name="between"/><link name="b"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
    <joint name="slide" type="prismatic"><parent link="a"/><child link="between"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
    <joint name="fly" type="floating"><parent link="between"/><child link="b"/><origin xyz="0 1 0"/></joint></robot>)", "", Config());
  monitor_.follow(robot_);
  PoseSnapshot snapshot;
  snapshot.poses = scene::forwardKinematics(robot_->robotModel(), std::vector<double>(2, 0.0));
  const Clearance& clearance = monitor_.cycle(snapshot, {}, settings_);
  EXPECT_EQ(clearance.joint_names,
            (std::vector<std::string>{"slide", "fly/trans_x", "fly/trans_y", "fly/trans_z", "fly/rot_x", "fly/rot_y", "fly/rot_z"}));
  EXPECT_EQ(clearance.joint_positions[0], 0.0);
  EXPECT_TRUE(std::isnan(clearance.joint_positions[1]));
  ASSERT_EQ(clearance.minimum.gradient.size(), 7u);
  EXPECT_EQ(std::abs(clearance.minimum.gradient[0]), 1.0);
  EXPECT_EQ(clearance.minimum.gradient[2], clearance.minimum.gradient[0]);
}

}  // namespace
}  // namespace proximity_server::node
