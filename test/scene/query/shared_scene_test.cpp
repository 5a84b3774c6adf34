// Eight threads at work on one robot at the same time; ./dev test --sanitize thread looks for races between them.
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/motion_search.h"
#include "sanitized.h"
#include "scene/example_robots.h"
#include "scene/posed_scene.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <thread>

namespace proximity_server::scene::shared_scene_test {

using namespace narrowphase;

constexpr unsigned kThreads = 8;
constexpr int kStates = 6;  // of each thread

/// The scenes that all threads share.
struct SharedRobot {
  explicit SharedRobot(const std::shared_ptr<const SceneModel>& model) : scene(model), moving_scene(model) {}

  const PosedScene scene;
  const MotionSearch moving_scene;
};

std::vector<double> randomPositions(const RobotModel& robot, std::mt19937& random) {
  std::vector<double> positions;
  for (const Joint& joint : robot.joints) {
    std::uniform_real_distribution<double> range(std::max(joint.lower, -1.0), std::min(joint.upper, 1.0));
    positions.push_back(range(random));
  }
  return positions;
}

/// All numbers of the answers to all questions, of scenes that share the data of the given ones, in states that depend
/// on the seed.
std::vector<double> answers(const SharedRobot& shared, unsigned seed) {
  PosedScene scene = shared.scene.forAnotherThread();
  MotionSearch moving_scene = shared.moving_scene.forAnotherThread();
  const RobotModel& robot = scene.model().robot;
  const Candidates& pairs = scene.candidates();
  Question near;
  near.threshold = 0.1;
  std::mt19937 random(seed);
  std::vector<double> from = randomPositions(robot, random);

  std::vector<double> numbers;
  const auto add = [&](const PairProximity& pair) {
    numbers.insert(numbers.end(), {pair.result.distance, pair.result.lower_bound, pair.result.upper_bound,
                                   pair.result.normal.x(), pair.result.point_a.x(), pair.result.point_b.x()});
  };
  for (int state = 0; state < kStates; ++state) {
    const std::vector<double> to = randomPositions(robot, random);
    scene.update(forwardKinematics(robot, from));
    add(*scene.minimum(pairs));
    for (const PairProximity& pair : scene.closest(pairs, 3)) add(pair);
    for (const PairProximity& pair : scene.below(pairs, near)) add(pair);
    for (const PairProximity& pair : scene.all(pairs)) add(pair);
    add(scene.proximity(pairs[state]));
    const RobotMotion motion = RobotMotion::between(robot, from, to);
    const RobotTimeOfContact contact = moving_scene.timeOfContact(pairs, motion);
    const RobotMinimum minimum = moving_scene.minimum(pairs, motion);
    numbers.insert(numbers.end(), {contact.t_free, contact.t_contact, minimum.lower_bound, minimum.time});
    from = to;
  }
  return numbers;
}

bool sameBits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

TEST(SharedScene, EightThreadsAtOnceGetTheBitsThatEachWouldGetAlone) {
  const SharedRobot shared(demoModel());
  std::vector<std::vector<double>> alone, together(kThreads);
  for (unsigned i = 0; i < kThreads; ++i) alone.push_back(answers(shared, i));
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < kThreads; ++i) threads.emplace_back([&, i] { together[i] = answers(shared, i); });
  for (std::thread& thread : threads) thread.join();
  for (unsigned i = 0; i < kThreads; ++i) EXPECT_TRUE(sameBits(together[i], alone[i])) << "thread " << i;
  EXPECT_FALSE(sameBits(alone[0], alone[1])) << "all threads ask for the same states";
}

TEST(SharedScene, ModelsAreLoadedByEightThreadsAtOnce) {
#ifdef PROXIMITY_ADDRESS_SANITIZED
  GTEST_SKIP() << kNoForkBesideThreads;
#endif
  const SharedRobot one(demoModel());
  const std::vector<double> expected = answers(one, 1);
  std::vector<std::vector<double>> together(kThreads);
  std::vector<std::thread> threads;
  for (std::vector<double>& own : together) {
    threads.emplace_back([&own] { own = answers(SharedRobot(demoModel()), 1); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<double>& own : together) EXPECT_TRUE(sameBits(own, expected));
}

}  // namespace proximity_server::scene::shared_scene_test
