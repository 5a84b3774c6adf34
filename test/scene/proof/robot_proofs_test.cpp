// Boxes of joint positions of real robots. With PROXIMITY_REPEATS many more states are searched.
#include "proximity_server/scene/proof/prove_apart.h"
#include "scene/example_robots.h"
#include "scene/posed_scene.h"
#include "scene/proof/random_boxes.h"
#include "scene/random_states.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

namespace proximity_server::scene::robot_proofs_test {

/// No state of some boxes is closer than what is proven.
void searchStatesOfBoxes(const std::shared_ptr<const SceneModel>& model, int count, Chance& chance) {
  PosedScene scene(model);
  int outcomes[3] = {0, 0, 0}, states = 0;
  for (int i = 0; i < count; ++i) {
    std::vector<double> radii(model->robot.joints.size());
    const double most = chance.decades(-2, 0);
    for (double& radius : radii) radius = chance.below(4) == 0 ? 0.0 : chance.between(0.0, most);
    const JointBox box = boxAbout(model->robot, randomPositions(model->robot, chance), radii);
    std::vector<ShapeRefPair> pairs;
    for (int k = 0; k < 12; ++k) pairs.push_back(chance.oneOf(scene.candidates().list()));
    ProofQuestion question;
    question.most_boxes = 40;
    question.tightness = 0.5;
    for (const PairProof& proof : proveApart(model, pairs, box, question)) {
      ++outcomes[static_cast<int>(proof.outcome)];
      double closest = proof.closest_upper_bound;
      for (int s = 0; s < repeats(12); ++s, ++states) {
        scene.update(forwardKinematics(model->robot, someStateIn(model->robot, box, chance)));
        closest = std::min(closest, scene.proximity(proof.pair).result.upper_bound);
      }
      ASSERT_GE(closest, proof.lower_bound)
          << i << ": " << nameOf(proof.pair.a, model->robot) << ", " << nameOf(proof.pair.b, model->robot);
    }
  }
  testing::Test::RecordProperty("states_of_" + model->robot.name, states);
  EXPECT_GT(outcomes[static_cast<int>(ProofOutcome::Proven)], count);
}

TEST(RobotProofs, NoStateOfTheDemoRobotIsCloser) {
  Chance chance(3);
  searchStatesOfBoxes(demoModel(), repeats(20), chance);
}

TEST(RobotProofs, NoStateOfAnExampleRobotIsCloser) {
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) GTEST_SKIP() << kExampleRobotsMissing;
  Chance chance(4);
  for (const ExampleRobot& robot : robotsToTest()) {
    SCOPED_TRACE(robot.name);
    searchStatesOfBoxes(modelOf(robot, resolve, quickLoading()), repeats(20), chance);
  }
}

}  // namespace proximity_server::scene::robot_proofs_test
