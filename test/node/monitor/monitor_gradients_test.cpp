// Gradients of the monitor's messages and of the services: those of the scene, to the last bit.
#include "node/monitor/monitor.h"
#include "node/monitor/slider_robot.h"
#include "node/services/pair_questions.h"
#include "node/tf/joint_frames.h"
#include "sanitized.h"
#include "scene/example_robots.h"

#include <gtest/gtest.h>
#include <ros/serialization.h>

#include <cmath>
#include <deque>
#include <fstream>
#include <optional>
#include <random>
#include <sstream>

namespace proximity_server::node::monitor_gradients_test {

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
    config.model.mesh_cache = scene::cachedLoading().mesh_cache;
    return config;
  }

  std::vector<double> randomPositions() {
    std::vector<double> positions;
    for (const scene::Joint& joint : robot_->robotModel().joints) {
      const bool is_limited = std::isfinite(joint.lower) && std::isfinite(joint.upper);
      const double lowest = is_limited ? joint.lower : -3.0, highest = is_limited ? joint.upper : 3.0;
      positions.push_back(std::uniform_real_distribution<>(lowest, highest)(random_));
    }
    return positions;
  }
  PoseSnapshot posesAt(const std::vector<double>& positions) const {
    PoseSnapshot snapshot;
    snapshot.stamp = ros::Time(1000.0);
    snapshot.poses = scene::forwardKinematics(robot_->robotModel(), positions);
    return snapshot;
  }
  PoseSnapshot randomPoses() { return posesAt(randomPositions()); }

  /// The answer of query_pairs in these poses, with a scene that no other question has used.
  StateProximity ask(std::uint8_t mode, const PoseSnapshot& snapshot) {
    QueryPairsRequest request;
    request.mode = mode;
    request.threshold = mode == QueryPairsRequest::BELOW_THRESHOLD ? settings_.threshold : 0.0;
    request.want_gradient = true;
    const RequestedPairs pairs = pairsOf(*robot_, request);
    PosedScenes& scenes = *used_.emplace_back(pairs.borrowScenes());
    scenes.state.set(snapshot.poses);
    return askPairs(*robot_, scenes, {snapshot.poses, snapshot.status}, pairs, request, questionOf(*robot_, request),
                    /*guaranteed=*/nullptr);
  }

  /// The gradient for the points and the normal of a message.
  std::vector<double> gradientFor(const Proximity& message) {
    scene::PairProximity pair;
    pair.asked = {robot_->robotModel().findLink(message.a.link), robot_->robotModel().findLink(message.b.link)};
    pair.result.status = narrowphase::Status::Converged;
    pair.result.has_points = message.points_valid;
    pair.result.point_a = vector(message.point_a);
    pair.result.point_b = vector(message.point_b);
    pair.result.normal = vector(message.normal);
    Eigen::VectorXd row(state_.degreesOfFreedom().size());
    EXPECT_TRUE(scene::gradient(state_, pair, row));
    return {row.data(), row.data() + row.size()};
  }
  template <class Message>
  static Eigen::Vector3d vector(const Message& message) {
    return {message.x, message.y, message.z};
  }

  static std::shared_ptr<const Robot> loaded() {
    static const auto robot = std::make_shared<const Robot>(demo("robot.urdf"), demo("robot.srdf"), configOfDemo());
    return robot;
  }

  std::shared_ptr<const Robot> robot_ = loaded();
  Monitor monitor_;
  MonitorSettings settings_;
  std::mt19937 random_{20};
  scene::State state_{robot_->sharedModel()};
  std::vector<ScenePool::Lease> used_;  ///< kept, so that no scene is lent twice
};

TEST_F(GradientsOfTheDemo, AreThoseOfTheSceneForThePointsOfTheMessageToTheLastBit) {
  int pairs = 0;
  for (int i = 0; i < repeats(300); ++i) {
    const PoseSnapshot snapshot = randomPoses();
    const Clearance& clearance = monitor_.cycle(snapshot, {}, settings_);
    state_.set(snapshot.poses);
    EXPECT_EQ(clearance.minimum.gradient, gradientFor(clearance.minimum)) << i;
    EXPECT_EQ(clearance.self_minimum.gradient, gradientFor(clearance.self_minimum)) << i;
    for (const Proximity& pair : clearance.below_threshold) EXPECT_EQ(pair.gradient, gradientFor(pair)) << i;
    pairs += static_cast<int>(clearance.below_threshold.size());
  }
  if (!kIsSanitized) {
    EXPECT_GT(pairs, 1000);
  }
}

// A scene begins a search where the last one ended, which may change the last bits of points. These scenes have no
// memory.
TEST_F(GradientsOfTheDemo, AgreeWithTheServicesToTheLastBitOfTheWholeAnswer) {
  int pairs = 0;
  std::deque<Monitor> monitors;  // each keeps its scene
  for (int i = 0; i < repeats(60); ++i) {
    const PoseSnapshot snapshot = randomPoses();
    Monitor& monitor = monitors.emplace_back();
    monitor.follow(robot_);
    const Clearance& clearance = monitor.cycle(snapshot, {}, settings_);
    const StateProximity below = ask(QueryPairsRequest::BELOW_THRESHOLD, snapshot);
    ASSERT_LE(clearance.below_threshold.size(), below.pairs.size());
    for (std::size_t k = 0; k < clearance.below_threshold.size(); ++k)
      EXPECT_EQ(bytesOf(clearance.below_threshold[k]), bytesOf(below.pairs[k])) << i << ", pair " << k;
    EXPECT_EQ(bytesOf(clearance.minimum), bytesOf(ask(QueryPairsRequest::MINIMUM, snapshot).minimum)) << i;
    pairs += static_cast<int>(clearance.below_threshold.size());
  }
  if (!kIsSanitized) {
    EXPECT_GT(pairs, 200);
  }
}

TEST_F(GradientsOfTheDemo, HaveOneEntryForEachJointAndTheJointItsPosition) {
  const std::vector<double> positions = randomPositions();
  const Clearance& clearance = monitor_.cycle(posesAt(positions), {}, settings_);
  ASSERT_EQ(clearance.joint_positions.size(), positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    EXPECT_EQ(clearance.joint_names[i], robot_->robotModel().joints[i].name);
    EXPECT_NEAR(std::remainder(clearance.joint_positions[i] - positions[i], 2.0 * M_PI), 0.0, 1e-12) << i;
  }
  EXPECT_EQ(clearance.minimum.gradient.size(), positions.size());
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
  using namespace robots;
  robot_ = std::make_shared<const Robot>(
      urdfOf(link("a", ball("0.1")) + link("between") + link("b", ball("0.1")) +
             slider("slide", "a", "between", "0 1 0") + joint("fly", "floating", "between", "b", origin("0 1 0"))),
      "", Config());
  monitor_.follow(robot_);
  PoseSnapshot snapshot;
  snapshot.poses = scene::forwardKinematics(robot_->robotModel(), std::vector<double>(2, 0.0));
  const Clearance& clearance = monitor_.cycle(snapshot, {}, settings_);
  EXPECT_EQ(clearance.joint_names, (std::vector<std::string>{"slide", "fly/trans_x", "fly/trans_y", "fly/trans_z",
                                                             "fly/rot_x", "fly/rot_y", "fly/rot_z"}));
  EXPECT_EQ(clearance.joint_positions[0], 0.0);
  EXPECT_TRUE(std::isnan(clearance.joint_positions[1]));
  ASSERT_EQ(clearance.minimum.gradient.size(), 7u);
  EXPECT_EQ(std::abs(clearance.minimum.gradient[0]), 1.0);
  EXPECT_EQ(clearance.minimum.gradient[2], clearance.minimum.gradient[0]);
}

}  // namespace proximity_server::node::monitor_gradients_test
