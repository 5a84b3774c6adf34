// Threads at work on one robot with meshes at the same time; ./dev test --sanitize thread looks for races between them.
#include "laws/question_laws.h"
#include "laws/scene_questions.h"
#include "sanitized.h"
#include "scene/example_robots.h"
#include "scene/random_states.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace proximity_server::scene::shared_scene_test {

/// The demo's robot, loaded anew, in states that are always the same.
laws::Cell demoCell() {
  laws::Cell cell{demoModel(), {}, {}};
  cell.objects = std::make_shared<const Objects>(cell.model);
  Chance chance(1);
  for (int i = 0; i < 6; ++i) {
    const std::vector<double> positions = randomPositions(cell.model->robot, chance);
    cell.states.push_back({positions, forwardKinematics(cell.model->robot, positions), {}});
  }
  return cell;
}

TEST(SharedScene, ThreadsAtOnceGetTheBitsThatEachWouldGetAlone) {
  const laws::Cell cell = demoCell();
  EXPECT_TRUE(laws::isTheSameInOtherThreads<laws::Closest>(cell));
  EXPECT_TRUE(laws::isTheSameInOtherThreads<laws::Below>(cell));
  EXPECT_TRUE(laws::isTheSameInOtherThreads<laws::All>(cell));
  EXPECT_TRUE(laws::isTheSameInOtherThreads<laws::OnePair>(cell));
  EXPECT_TRUE(laws::isTheSameInOtherThreads<laws::OfContact>(cell));
  EXPECT_TRUE(laws::isTheSameInOtherThreads<laws::OfMinimumOfMotion>(cell));
}

TEST(SharedScene, ModelsAreLoadedByEightThreadsAtOnce) {
#ifdef PROXIMITY_ADDRESS_SANITIZED
  GTEST_SKIP() << kNoForkBesideThreads;
#endif
  const auto answers = [] {
    const laws::Cell cell = demoCell();
    return laws::answersOf(laws::Asked<laws::All>(cell), cell);
  };
  const std::vector<laws::Answer> expected = answers();
  std::vector<std::vector<laws::Answer>> together(8);
  std::vector<std::thread> threads;
  for (auto& own : together) threads.emplace_back([&] { own = answers(); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& own : together) EXPECT_TRUE(laws::haveTheSameBits(own, expected));
}

}  // namespace proximity_server::scene::shared_scene_test
