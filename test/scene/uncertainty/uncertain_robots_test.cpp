// Real robots whose joints are not where they are said to be. With PROXIMITY_REPEATS many more states are searched.
#include "proximity_server/scene/guaranteed/guaranteed_distances.h"
#include "scene/example_robots.h"
#include "scene/posed_scene.h"
#include "scene/random_states.h"
#include "scene/uncertainty/uncertain_states.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::scene::uncertain_robots_test {

/// All joints are off by up to the same angle [rad] or, times 0.3 m, length; sometimes some of everything is.
Uncertainty uncertaintyOf(const RobotModel& robot, double size, Chance& chance) {
  if (chance.below(3) == 0) return someUncertainty(robot, size, 0.3 * size, chance);
  Uncertainty uncertainty(robot);
  for (std::size_t i = 0; i < robot.joints.size(); ++i)
    uncertainty.positions[i] = robot.joints[i].type == Joint::Type::Prismatic ? 0.3 * size : size;
  return uncertainty;
}

/// No state within the uncertainty of some states is closer than the guaranteed distances of the closest pairs.
void searchStatesWithin(const std::shared_ptr<const SceneModel>& model, int count, Chance& chance) {
  PosedScene scene(model), within(model);
  GuaranteedDistances distances(model);
  int close = 0, pairs = 0, states = 0;
  for (int i = 0; i < count; ++i) {
    const BodyPoses poses = forwardKinematics(model->robot, randomPositions(model->robot, chance));
    const Uncertainty uncertainty = uncertaintyOf(model->robot, chance.decades(-4, -1), chance);
    scene.update(poses);
    distances.assume(uncertainty);
    for (const PairProximity& pair : std::vector<PairProximity>(scene.closest(scene.candidates(), 4))) {
      const double bound = distances.of(scene.state, pair);
      const auto in = [&](const StateWithin& state) {
        ++states;
        within.update(posesWithin(model->robot, poses, uncertainty, state));
        return within.proximity(pair.asked).result.upper_bound - swellingOf(uncertainty, pair.asked);
      };
      const double worst = std::min(smallestOfSome(8, model->robot, nullptr, chance, in),
                                    smallestOfCorners(model->robot, nullptr, chance, in));
      ASSERT_GE(worst, bound) << i << ": " << nameOf(pair.asked.a, model->robot) << ", "
                              << nameOf(pair.asked.b, model->robot);
      close += pair.result.upper_bound - worst > 0.5 * (pair.result.upper_bound - bound);
      ++pairs;
    }
  }
  testing::Test::RecordProperty("states_of_" + model->robot.name, states);
  EXPECT_GT(close, pairs / 5) << "the search comes near to the bounds";
}

/// Returns for some states the lossFactor() of the closest pair. The factors are sorted.
std::vector<double> lossesOf(const std::shared_ptr<const SceneModel>& model, double size, int count, Chance& chance) {
  PosedScene scene(model), within(model);
  GuaranteedDistances distances(model);
  std::vector<double> factors;
  Uncertainty uncertainty(model->robot);
  std::fill(uncertainty.positions.begin(), uncertainty.positions.end(), size);
  distances.assume(uncertainty);
  while (static_cast<int>(factors.size()) < count) {
    const BodyPoses poses = forwardKinematics(model->robot, randomPositions(model->robot, chance));
    scene.update(poses);
    const PairProximity pair = *scene.minimum(scene.candidates());
    if (pair.result.lower_bound <= 0.0) continue;
    const double bound = distances.of(scene.state, pair);
    factors.push_back(lossFactor(pair, bound, pair.result.distance, within, poses, uncertainty, chance));
  }
  std::sort(factors.begin(), factors.end());
  return factors;
}

void expectLittleLoss(const std::shared_ptr<const SceneModel>& model, Chance& chance) {
  const int count = repeats(60);
  for (const auto& [size, median, most] : {std::array{1e-3, 1.5, 2.0}, std::array{1.745e-2, 2.0, 3.0}}) {
    const std::vector<double> factors = lossesOf(model, size, count, chance);
    EXPECT_LE(factors[factors.size() / 2], median) << size;
    EXPECT_LE(factors[factors.size() * 99 / 100], most) << size;
  }
}

TEST(UncertainRobots, NoStateOfTheDemoRobotIsCloser) {
  Chance chance(1);
  searchStatesWithin(demoModel(), repeats(30), chance);
}

TEST(UncertainRobots, NoStateOfAnExampleRobotIsCloser) {
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) GTEST_SKIP() << kExampleRobotsMissing;
  Chance chance(2);
  for (const ExampleRobot& robot : robotsToTest()) {
    SCOPED_TRACE(robot.name);
    searchStatesWithin(modelOf(robot, resolve, quickLoading()), repeats(30), chance);
  }
}

TEST(UncertainRobots, DemoRobotLosesLittleMoreThanTheWorstStateFound) {
  Chance chance(3);
  expectLittleLoss(demoModel(), chance);
}

TEST(UncertainRobots, AnExampleRobotLosesLittleMoreThanTheWorstStateFound) {
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) GTEST_SKIP() << kExampleRobotsMissing;
  Chance chance(4);
  for (const ExampleRobot& robot : robotsToTest()) {
    SCOPED_TRACE(robot.name);
    expectLittleLoss(modelOf(robot, resolve, quickLoading()), chance);
  }
}

}  // namespace proximity_server::scene::uncertain_robots_test
