// Many states at once: the answers are those of a Scene that has seen no other state.
#include "proximity_server/scene/batch/scene_batch.h"

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/query/scene.h"
#include "scene/batch/batch_robots.h"
#include "scene/batch/same_answer.h"
#include "scene/files.h"
#include "scene/small_robots.h"
#include "scene/solids.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <memory>
#include <random>

namespace proximity_server::scene::scene_batch_test {

std::shared_ptr<const SceneModel> threeSpheres() {
  return modelOf(onRail({{"x", ball("0.1")}, {"y", ball("0.1")}, {"z", ball("0.1")}}));
}

TEST(SceneBatch, AnswersAboutEachState) {
  SceneBatch batch(threeSpheres());
  Eigen::MatrixXd states(3, 3);
  states << 0.0, 1.0, 3.0,  //
      0.0, 1.0, 1.15,       //
      0.0, std::numeric_limits<double>::quiet_NaN(), 1.0;
  const auto& minima = batch.minimum(states);
  ASSERT_EQ(minima.size(), 3u);
  EXPECT_NEAR(minima[0].result.distance, 0.8, 1e-12);
  EXPECT_NEAR(minima[1].result.distance, -0.05, 1e-12);
  EXPECT_EQ(minima[2].result.status, narrowphase::Status::Unknown);

  const auto& verdicts = batch.anyBelow(states, 0.1);
  EXPECT_EQ(verdicts[0].kind, StateVerdict::Kind::Above);
  EXPECT_EQ(verdicts[1].kind, StateVerdict::Kind::Below);
  EXPECT_EQ(batch.candidates()[verdicts[1].pair].a.link(), minima[1].asked.a.link());
  EXPECT_EQ(verdicts[2].kind, StateVerdict::Kind::Unknown);

  const StatePairs& below = batch.below(states, 0.9);
  EXPECT_EQ(below.begins, (std::vector<std::size_t>{0, 1, 2 + 1, 3}));
  EXPECT_EQ(below.unknown, (std::vector<unsigned char>{0, 0, 1}));
}

// Regression: a pair without a pose was left out, so that the state was proven to be above, and the minimum that of the
// others.
TEST(SceneBatch, AStateWithAPoseThatIsNotFiniteHasNoAnswer) {
  std::string parts = link("base") + link("carriage") + slider("to_carriage", "base", "carriage", "1 0 0");
  for (const std::string name : {"x", "y", "z"})
    parts += link(name, ball("0.1")) + slider("to_" + name, name == "x" ? "carriage" : "base", name, "1 0 0");
  const auto model = modelOf(urdfOf(parts));
  SceneBatch batch(model);
  ASSERT_EQ(batch.candidates().size(), 3U);
  Eigen::MatrixXd states = Eigen::MatrixXd::Zero(2, 4);
  for (std::size_t joint = 0; joint < 4; ++joint) {
    const std::string& name = model->robot.joints[joint].name;
    const bool leads_to_x = name == "to_carriage" || name == "to_x";
    states(0, static_cast<Eigen::Index>(joint)) = leads_to_x ? 1.7e308 : name == "to_z" ? 1.0 : 0.0;
    states(1, static_cast<Eigen::Index>(joint)) = name == "to_carriage" ? 2.0 : name == "to_z" ? 1.0 : 0.0;
  }
  EXPECT_EQ(batch.minimum(states)[0].result.status, narrowphase::Status::Unknown);
  EXPECT_EQ(batch.minimum(states)[1].result.status, narrowphase::Status::Converged);
  EXPECT_EQ(batch.anyBelow(states, 0.1)[0].kind, StateVerdict::Kind::Unknown);
  EXPECT_EQ(batch.anyBelow(states, 0.1)[1].kind, StateVerdict::Kind::Above);
  EXPECT_EQ(batch.below(states, 0.1).unknown, (std::vector<unsigned char>{1, 0}));
  EXPECT_EQ(batch.closest(states, 2).unknown, (std::vector<unsigned char>{1, 0}));
  EXPECT_EQ(batch.closest(states, 2).begins, (std::vector<std::size_t>{0, 0, 2}));
}

// One ball lies wholly inside of a closed mesh, and the other one overlaps its surface: the pieces that overlap are not
// the deepest of the pair.
TEST(SceneBatch, WhatIsInsideOfASolidCountsBesidePiecesThatOverlap) {
  const TemporaryFiles files;
  const std::string solid = mesh(files.write("bracket.stl", stlOf(bracket())));
  const std::string inside = ball("0.1", "0.5 0.5 0.4"), below_it = ball("0.1", "0.5 0.5 -0.05");
  ModelOptions triangles;
  triangles.mesh_tolerance = 0.0;
  for (const bool solid_is_first : {true, false}) {
    const auto model =
        modelOf(robotOf(urdfOf(link("base") + link("1", solid_is_first ? solid : inside + below_it) +
                               link("2", solid_is_first ? inside + below_it : solid) +
                               slider("to_1", "base", "1", "0 0 1") + slider("to_2", "base", "2", "0 0 1")),
                        triangles));
    SceneBatch batch(model);
    Eigen::MatrixXd states = Eigen::MatrixXd::Zero(3, 2);  // the balls as above, higher by 0.2, and far away
    states(1, 0) = solid_is_first ? -0.2 : 0.2;
    states(2, 0) = 5.0;
    const auto& minima = batch.minimum(states);
    EXPECT_NEAR(minima[0].result.distance, -0.5, 1e-12);
    EXPECT_NEAR(minima[1].result.distance, -0.5, 1e-12);
    EXPECT_GT(minima[2].result.distance, 1.0);
    EXPECT_EQ(batch.below(states, -0.4).begins, (std::vector<std::size_t>{0, 1, 2, 2}));
    EXPECT_EQ(batch.anyBelow(states, -0.4)[0].kind, StateVerdict::Kind::Below);
    EXPECT_EQ(batch.anyBelow(states, -0.6)[0].kind, StateVerdict::Kind::Above);
  }
}

TEST(SceneBatch, RefusesStatesOfAnotherRobot) {
  SceneBatch batch(threeSpheres());
  EXPECT_THROW(batch.minimum(Eigen::MatrixXd::Zero(1, 2)), std::invalid_argument);
  EXPECT_THROW(batch.anyBelow(Eigen::MatrixXd::Zero(1, 3), std::numeric_limits<double>::quiet_NaN()),
               std::invalid_argument);
}

// --- deadlines

/// The answers of each state to all questions; a state without an answer has no pair in the list.
using AnswersOfStates = std::vector<std::vector<PairProximity>>;

LevelThresholds thresholdsOfPairs(const SceneBatch& batch) {
  LevelThresholds thresholds;
  thresholds.stop = PairDistances(0.1, 0.1);
  thresholds.warn = PairDistances(0.3, 0.3);
  thresholds.stop.setPair(batch.candidates()[0].a.link(), batch.candidates()[0].b.link(), 0.0);
  return thresholds;
}

std::vector<AnswersOfStates> answersOf(SceneBatch& batch, const Eigen::MatrixXd& states, const Deadline& deadline) {
  std::vector<AnswersOfStates> answers;
  const auto addFirst = [&](const std::vector<PairProximity>& firsts) {
    AnswersOfStates& of_states = answers.emplace_back();
    for (const PairProximity& first : firsts)
      of_states.push_back(first.result.status == narrowphase::Status::Unknown ? std::vector<PairProximity>()
                                                                              : std::vector<PairProximity>{first});
  };
  const auto addLists = [&](const StatePairs& lists) {
    AnswersOfStates& of_states = answers.emplace_back();
    for (std::size_t i = 0; i < lists.unknown.size(); ++i) {
      of_states.push_back(ofState(lists, static_cast<Eigen::Index>(i)));
      EXPECT_TRUE(of_states.back().empty() || lists.unknown[i] == 0);
      if (lists.unknown[i] == 0 && of_states.back().empty()) of_states.back().emplace_back();  // an empty list
    }
  };
  addFirst(batch.minimum(states, deadline));
  addFirst(batch.minimumWithin(states, 1e-3, deadline));
  addFirst(batch.deciding(states, thresholdsOfPairs(batch), deadline));
  addLists(batch.closest(states, 3, deadline));
  addLists(batch.below(states, 0.3, deadline));
  AnswersOfStates& verdicts = answers.emplace_back();
  for (const StateVerdict& verdict : batch.anyBelow(states, 0.1, deadline)) {
    verdicts.emplace_back();
    if (verdict.kind == StateVerdict::Kind::Unknown) continue;
    verdicts.back().emplace_back().collision_a = verdict.pair;
  }
  return answers;
}

TEST(SceneBatch, NoStateHasAnAnswerAfterTheDeadline) {
  const auto model = robotNamed("Solids");
  const Eigen::MatrixXd states = variousStates(model->robot, 300, 3);
  SceneBatch batch(model);
  const std::atomic<bool> stop{true};
  for (const Deadline& late : {Deadline(stop), Deadline(Deadline::Clock::time_point::min())})
    for (const AnswersOfStates& answers : answersOf(batch, states, late)) {
      ASSERT_EQ(answers.size(), 300U);
      for (const auto& of_state : answers) EXPECT_TRUE(of_state.empty());
    }
}

TEST(SceneBatch, ADeadlineChangesNoAnswerButLeavesItOut) {
  for (const char* const name : {"Solids", "Beads", "TwoArms"}) {
    const auto model = robotNamed(name);
    const Eigen::MatrixXd states = variousStates(model->robot, 300, 4);
    SceneBatch batch(model);
    const std::vector<AnswersOfStates> expected = answersOf(batch, states, {});
    long known = 0, unknown = 0;
    for (int i = 0; i < 50; ++i) {  // up to 25 ms, which may end in any step
      const auto deadline = Deadline::Clock::now() + std::chrono::microseconds(10 * i * i);
      const std::vector<AnswersOfStates> found = answersOf(batch, states, deadline);
      for (std::size_t question = 0; question < expected.size(); ++question)
        for (std::size_t state = 0; state < expected[question].size(); ++state) {
          if (found[question][state].empty()) {
            ++unknown;
            continue;
          }
          ++known;
          EXPECT_TRUE(areSameLists(found[question][state], expected[question][state])) << name << ", " << question;
        }
    }
    EXPECT_GT(unknown, 0);
    EXPECT_EQ(known + unknown, 50 * 300 * 6);
    const std::vector<AnswersOfStates> later = answersOf(batch, states, {});
    for (std::size_t question = 0; question < expected.size(); ++question)
      for (std::size_t state = 0; state < expected[question].size(); ++state)
        EXPECT_TRUE(areSameLists(later[question][state], expected[question][state])) << name << ", " << question;
  }
}

}  // namespace proximity_server::scene::scene_batch_test
