#include "tools/pair_audit/separation_proof.h"

#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "tools/robot/two_sliders.h"

#include <gtest/gtest.h>

#include <cmath>

namespace proximity_server::tools::separation_proof_test {

using namespace scene;

// A joint at the face of a box, and a ball on an arm about it; then a wrist, a slider and a hand.
const char* const kArm = R"(<robot name="arm">
  <link name="base"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="arm"><collision><origin xyz="0.6 0 0"/><geometry><sphere radius="0.2"/></geometry></collision></link>
  <link name="wrist"><collision><geometry><cylinder radius="0.1" length="0.2"/></geometry></collision></link>
  <link name="hand"><collision><origin xyz="0.1 0 0"/><geometry><box size="0.2 0.1 0.1"/></geometry></collision></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="arm"/><origin xyz="0.5 0 0"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="bend" type="revolute"><parent link="arm"/><child link="wrist"/><origin xyz="1 0 0" rpy="0 0.3 0"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="1" effort="1" velocity="1"/></joint>
  <joint name="extend" type="prismatic"><parent link="wrist"/><child link="hand"/><origin xyz="0.2 0 0"/>
    <axis xyz="1 0 0"/><limit lower="-0.1" upper="0.3" effort="1" velocity="1"/></joint>
</robot>)";

class Robot {
 public:
  explicit Robot(const std::string& urdf) : model_(std::make_shared<SceneModel>()) {
    model_->robot = loadRobotModel(urdf, packageResolver({}));
    model_->pairs = filterPairs(model_->robot, "");
  }

  const RobotModel& model() const { return model_->robot; }
  ShapeRefPair pair(const std::string& a, const std::string& b) const {
    return {{model().findLink(a), 0}, {model().findLink(b), 0}};
  }
  std::vector<JointRange> ranges(const ShapeRefPair& pair) const {
    return rangesBetween(model(), jointRanges(model()), pair.a.link(), pair.b.link());
  }
  std::vector<double> sensitivitiesOf(const std::string& a, const std::string& b) const {
    return sensitivities(model(), ranges(pair(a, b)), pair(a, b));
  }
  SeparationProof prove(const std::string& a, const std::string& b, double near = kContactDistance) const {
    Scene scene(model_);
    return proveSeparation(scene, ranges(pair(a, b)), pair(a, b), near);
  }
  double distance(const ShapeRefPair& pair, const Positions& positions) const {
    Scene scene(model_);
    scene.update(forwardKinematics(model(), positions));
    return scene.proximity(pair).result.distance;
  }

 private:
  std::shared_ptr<SceneModel> model_;
};

TEST(Sensitivities, APrismaticJointMovesAllByAsMuchAsItMoves) {
  const Robot robot(kTwoSliders);
  EXPECT_EQ(robot.sensitivitiesOf("base", "sled, left"), std::vector<double>{1.0});
}

TEST(Sensitivities, ALeaderAddsUpWhatItsFollowersCause) {
  const Robot robot(kTwoSliders);
  EXPECT_EQ(robot.sensitivitiesOf("base", "ball"), std::vector<double>{2.0});
  EXPECT_EQ(robot.sensitivitiesOf("sled, left", "ball"), std::vector<double>{3.0});
}

// The arm's ball reaches 0.8 from the joint, the base more than 1.
TEST(Sensitivities, TheShorterSideOfARevoluteJointCounts) {
  const Robot robot(kArm);
  ASSERT_EQ(robot.sensitivitiesOf("base", "arm").size(), 1U);
  EXPECT_NEAR(robot.sensitivitiesOf("base", "arm")[0], 0.8, 1e-12);
  EXPECT_NEAR(robot.sensitivitiesOf("arm", "base")[0], 0.8, 1e-12);
}

// A box reaches as far as the ball around it. From "bend": 0.2 to "extend", which moves 0.3 at most, 0.1 to the centre
// of the hand and half its diagonal, sqrt(0.015). From "turn" 1 m more, which is farther than the base reaches: 0.5 to
// its centre, and half its diagonal.
TEST(Sensitivities, LinksBetweenAddUp) {
  const std::vector<double> found = Robot(kArm).sensitivitiesOf("base", "hand");
  ASSERT_EQ(found.size(), 3U);
  EXPECT_NEAR(found[0], 0.5 + std::sqrt(0.75), 1e-12);
  EXPECT_NEAR(found[1], 0.2 + 0.3 + 0.1 + std::sqrt(0.015), 1e-12);
  EXPECT_EQ(found[2], 1.0);
}

TEST(Sensitivities, NoMoveChangesTheDistanceByMore) {
  const Robot robot(kArm);
  std::mt19937_64 random(5);
  double largest_share = 0.0;
  for (const auto& [a, b] : {std::pair("base", "arm"), std::pair("base", "wrist"), std::pair("base", "hand"),
                             std::pair("arm", "hand"), std::pair("hand", "base")}) {
    const ShapeRefPair pair = robot.pair(a, b);
    const std::vector<JointRange> ranges = robot.ranges(pair);
    const std::vector<double> bounds = sensitivities(robot.model(), ranges, pair);
    for (int i = 0; i < 500; ++i) {
      const Positions from = randomPositions(robot.model(), ranges, random);
      Positions to = randomPositions(robot.model(), ranges, random);
      double allowed = 0.0;
      for (std::size_t k = 0; k < ranges.size(); ++k) {
        double& position = to[ranges[k].joint];
        position = from[ranges[k].joint] + 0.1 * (position - from[ranges[k].joint]);
        allowed += bounds[k] * std::abs(position - from[ranges[k].joint]);
      }
      const double change = std::abs(robot.distance(pair, to) - robot.distance(pair, from));
      EXPECT_LE(change, allowed + 1e-9) << a << " - " << b;
      largest_share = std::max(largest_share, change / allowed);
    }
  }
  EXPECT_GT(largest_share, 0.5);  // the bounds are not idle
}

// The ball's centre is 0.6 from the joint at the face of the base, so the two overlap wherever it is turned inwards.
TEST(SeparationProof, MeetsContact) {
  const Robot robot(kArm);
  const SeparationProof proof = robot.prove("base", "arm");
  ASSERT_TRUE(proof.near);
  EXPECT_LE(proof.lower_bound, 0.0);
  EXPECT_LE(robot.distance(robot.pair("base", "arm"), *proof.near), kContactDistance);
}

// 2.25 + slide, slide at least -1.
TEST(SeparationProof, BoundIsBelowTheSmallestDistanceAndAboveHalfOfIt) {
  const SeparationProof proof = Robot(kTwoSliders).prove("sled, left", "ball");
  EXPECT_FALSE(proof.near);
  EXPECT_LE(proof.lower_bound, 1.25);
  EXPECT_GE(proof.lower_bound, 0.625);
}

TEST(SeparationProof, BoundIsHalfWayFromTheDistanceThatIsAskedFor) {
  const SeparationProof proof = Robot(kTwoSliders).prove("sled, left", "ball", 1.2);
  EXPECT_FALSE(proof.near);
  EXPECT_LE(proof.lower_bound, 1.25);
  EXPECT_GE(proof.lower_bound, 1.225);
}

TEST(SeparationProof, MeetsAStateWithinTheDistanceThatIsAskedFor) {
  const Robot robot(kTwoSliders);
  const SeparationProof proof = robot.prove("sled, left", "ball", 1.3);
  ASSERT_TRUE(proof.near);
  EXPECT_LE(robot.distance(robot.pair("sled, left", "ball"), *proof.near), 1.3);
}

// 1 + slide is 0 at the end of the range: nothing above it is proven, whatever is spent.
TEST(SeparationProof, ContactAtTheEndOfARangeIsNotProvenAway) {
  EXPECT_LE(Robot(kTwoSliders).prove("base", "sled, left").lower_bound, kContactDistance);
}

}  // namespace proximity_server::tools::separation_proof_test
