// Many states of a robot with objects: the answers are those of a new Scene, to the last bit.
#include "laws/refusals.h"
#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "sanitized.h"
#include "scene/batch/batch_robots.h"
#include "scene/batch/same_answer.h"
#include "scene/posed_scene.h"
#include "scene/random_objects.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace proximity_server::scene::batch_objects_test {

using namespace narrowphase;

using Eigen::Index;
using Eigen::MatrixXd;
using Kind = StateVerdict::Kind;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Fixed objects of all kinds, also with half-spaces and around the robot, some that links hold, some that move with
/// links, and rules that let some of them touch.
std::shared_ptr<const Objects> someCell(const std::shared_ptr<const SceneModel>& model, unsigned seed) {
  Chance chance(seed);
  const RobotModel& robot = model->robot;
  const auto someLink = [&] { return chance.oneOf(robot.links).name; };
  std::vector<ObjectChange> changes;
  const auto add = [&](const std::string& name, const Placement& placement) {
    const std::string id = name + std::to_string(changes.size());
    const bool is_solid = chance.below(12) == 0;
    changes.emplace_back(AddObject{is_solid ? someSolid(id, placement, chance) : someObject(id, placement, chance)});
  };
  const int fixed = chance.oneOf(std::vector<int>{1, 12, 60});
  for (int i = 0; i < fixed; ++i) {
    Eigen::Isometry3d pose = chance.pose(0.0);
    pose.translation() = chance.between(0.5, 1.5) * chance.direction();
    add("fixed", Fixed{pose});
  }
  for (int i = chance.below(3); i > 0; --i)
    add("held", Attached{someLink(), {someLink(), someLink()}, chance.pose(0.2)});
  for (int i = chance.below(3); i > 0; --i) add("moved", Moving{someLink(), chance.pose(0.4)});
  ObjectRules rules;
  if (chance.below(2) == 0) rules.allowed.set("fixed0", someLink(), AllowedPairs::Rule::Allowed);
  if (chance.below(2) == 0) rules.allowed.set(someLink(), "*", AllowedPairs::Rule::Allowed);
  if (chance.below(2) == 0) rules.free_objects = ObjectRules::FreeObjects::Checked;
  if (chance.below(2) == 0) rules.base = ObjectRules::Base::StandsStill;
  return std::make_shared<const Objects>(Objects(model).withRules(rules).changed(changes));
}

std::shared_ptr<const SceneModel> modelNamed(const std::string& name) {
  return name == "Arm" ? arm() : name == "Alone" ? nothingToCheck() : robotNamed(name);
}

/// The answers of a new Scene about one state.
class NewScene {
 public:
  NewScene(const std::shared_ptr<const SceneModel>& model, const std::shared_ptr<const Objects>& objects)
      : fresh_(model) {
    fresh_.use(objects);
  }

  void place(const MatrixXd& states, Index state) {
    poses_ = forwardKinematics(fresh_.model().robot, positionsOf(states, state));
    PosedScene scene = placed();
    all_ = scene.all(scene.candidates());
    known_.clear();
    for (const PairProximity& pair : all_)
      if (pair.result.status != Status::Unknown) known_.push_back(pair);
    sorted_ = known_;
    sortByRank(sorted_);
  }

  const std::vector<PairProximity>& all() const { return all_; }
  const std::vector<PairProximity>& sorted() const { return sorted_; }
  std::vector<PairProximity> closest(std::size_t k) const { return firstOf(sorted_, k); }
  PairProximity deciding(const LevelThresholds& thresholds) const { return decidingOf(known_, thresholds); }
  std::vector<PairProximity> below(double distance) const {
    Question question;
    question.threshold = distance;
    PosedScene scene = placed();
    std::vector<PairProximity> found;
    for (const PairProximity& pair : known_)
      if (const PairProximity near = scene.proximity(pair.asked, question);
          near.result.status != Status::Unknown && !(near.result.lower_bound > distance))
        found.push_back(near);
    sortByRank(found);
    return found;
  }

 private:
  PosedScene placed() const {
    PosedScene scene = fresh_.forAnotherThread();
    setPoses(scene.state, poses_);
    return scene;
  }

  PosedScene fresh_;
  BodyPoses poses_;
  std::vector<PairProximity> all_, known_, sorted_;
};

LevelThresholds someThresholds(const SceneModel& model, const Objects* objects, unsigned seed) {
  Chance chance(seed);
  LevelThresholds thresholds;
  const auto both = [&](const auto& set) {
    const auto [stop, warn] = std::minmax({chance.between(0.0, 0.2), chance.between(0.0, 0.2)});
    set(thresholds.stop, stop);
    set(thresholds.warn, warn);
  };
  both([](PairDistances& of, double distance) { of.objects = distance; });
  for (int link = 0; link < static_cast<int>(model.robot.links.size()); ++link)
    if (chance.below(3) == 0) both([&](PairDistances& of, double distance) { of.setWithObjects(link, distance); });
  for (const int number : objects ? objects->numbers() : std::vector<int>())
    if (chance.below(10) == 0) both([&](PairDistances& of, double distance) { of.setObject(number, distance); });
  return thresholds;
}

bool isWithObject(const PairProximity& pair) { return pair.asked.a.isObject() || pair.asked.b.isObject(); }

class CellOf : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    model_ = modelNamed(GetParam());
    if (!model_) GTEST_SKIP() << GetParam() << " is not found, or not loaded under a sanitizer";
  }

  /// Various states, some of them beyond the range of the lanes.
  MatrixXd statesFor(int count, unsigned seed) const {
    MatrixXd states = variousStates(model_->robot, count, seed);
    for (Index i = 0; i < states.rows(); i += 9) states.row(i) *= i % 2 == 0 ? 1e6 : 1e3;
    return states;
  }

  std::shared_ptr<const SceneModel> model_;
};

TEST_P(CellOf, AnswersAreThoseOfANewScene) {
  constexpr double kBeside[] = {0.0, 1e-9, -1e-9, 1e-7, -1e-7, 1e-6, -1e-6, 1e-4, -1e-4, 1e-2, -1e-2};
  const int cells = repeats(60);
  SceneBatch batch(model_);
  std::int64_t states_in_all = 0, closest_objects = 0, verdicts_of_objects = 0, above = 0;
  for (int cell = 0; cell < cells && !HasFatalFailure(); ++cell) {
    const auto seed = static_cast<unsigned>(1000 + cell);
    const auto objects = someCell(model_, seed);
    const LevelThresholds thresholds = someThresholds(*model_, objects.get(), seed);
    const MatrixXd states = statesFor(20, seed);
    const int k = 1 + cell % 20;
    batch.use(objects);
    SceneBatch one = batch.forAnotherThread();
    NewScene expected(model_, objects);
    Chance chance(seed);
    const auto minima = batch.minimum(states), deciding = batch.deciding(states, thresholds);
    const StatePairs closest = batch.closest(states, k);
    for (Index i = 0; i < states.rows() && !HasFatalFailure(); ++i, ++states_in_all) {
      SCOPED_TRACE("state " + std::to_string(i) + " of cell " + std::to_string(cell));
      const auto state = static_cast<std::size_t>(i);
      expected.place(states, i);
      ASSERT_EQ(batch.pairs().size(), expected.all().size());
      for (std::size_t pair = 0; pair < expected.all().size(); ++pair) {
        ASSERT_EQ(batch.pairs()[pair].a, expected.all()[pair].asked.a);
        ASSERT_EQ(batch.pairs()[pair].b, expected.all()[pair].asked.b);
      }
      if (expected.sorted().empty()) {
        EXPECT_EQ(minima[state].result.status, Status::Unknown);
        continue;
      }
      ASSERT_TRUE(areSameLists({minima[state]}, expected.closest(1)));
      ASSERT_TRUE(areSameLists({deciding[state]}, {expected.deciding(thresholds)}));
      ASSERT_TRUE(areSameLists(ofState(closest, i), expected.closest(static_cast<std::size_t>(k))));
      const int near = chance.below(static_cast<int>(std::min<std::size_t>(8, expected.sorted().size())));
      const double distance = expected.sorted()[near].result.distance + chance.oneOf(kBeside);
      const auto below = expected.below(distance);
      ASSERT_TRUE(areSameLists(one.below(states.row(i), distance).pairs, below)) << distance;
      const StateVerdict verdict = one.anyBelow(states.row(i), distance).front();
      ASSERT_EQ(verdict.kind, below.empty() ? Kind::Above : Kind::Below) << distance;
      const auto isNamed = [&](const PairProximity& pair) {
        const ShapeRefPair& named = batch.pairs()[verdict.pair];
        return pair.asked.a == named.a && pair.asked.b == named.b;
      };
      ASSERT_TRUE(below.empty() || std::any_of(below.begin(), below.end(), isNamed)) << distance;
      closest_objects += isWithObject(minima[state]);
      verdicts_of_objects += verdict.pair >= static_cast<int>(batch.candidates().size());
      above += verdict.kind == Kind::Above;
    }
  }
  if (!kIsSanitized) {
    EXPECT_GT(closest_objects, states_in_all / 20);
    EXPECT_GT(verdicts_of_objects, states_in_all / 20);
    EXPECT_GT(above, states_in_all / 100);
  }
}

TEST_P(CellOf, MinimumWithinAnAccuracyBoundsTheMinimum) {
  int with_objects = 0, apart = 0;
  for (unsigned cell = 0; cell < static_cast<unsigned>(repeats(30)); ++cell) {
    SceneBatch batch(model_);
    batch.use(someCell(model_, 100 + cell));
    const MatrixXd states = statesFor(40, 200 + cell);
    const std::vector<PairProximity> minima = batch.minimum(states);
    for (const double accuracy : {0.01, 1e-4}) {
      const std::vector<PairProximity>& within = batch.minimumWithin(states, accuracy);
      for (std::size_t i = 0; i < minima.size(); ++i) {
        const SignedDistance &truth = minima[i].result, &found = within[i].result;
        ASSERT_EQ(found.status == Status::Unknown, truth.status == Status::Unknown);
        if (truth.status != Status::Converged) continue;
        ASSERT_LE(found.lower_bound, truth.upper_bound);
        ASSERT_GE(found.upper_bound, truth.lower_bound);
        ASSERT_TRUE(found.upper_bound <= 0.0 || found.upper_bound - found.lower_bound <= accuracy + 1e-9);
        with_objects += isWithObject(within[i]);
        apart += found.lower_bound > 0.0;
      }
    }
  }
  if (!kIsSanitized) {
    EXPECT_GT(with_objects, 30);
    EXPECT_GT(apart, 5);
  }
}

BatchAnswers answersOf(SceneBatch& batch, const States& states) {
  return {batch, states, someThresholds(batch.model(), batch.objects(), 5)};
}

TEST_P(CellOf, AnAnswerDependsOnNoOtherStateNorOnTheThreads) {
  const auto objects = someCell(model_, 7);
  MatrixXd states = statesFor(repeats(600), 8);
  const Index half = states.rows() / 2;
  states.topRows(half) = statesAlongEdges(model_->robot, static_cast<int>(half), 8);
  states(1, 0) = std::numeric_limits<double>::quiet_NaN();
  SceneBatch batch(model_);
  batch.use(objects);
  const BatchAnswers whole = answersOf(batch, states);
  std::vector<Index> order(static_cast<std::size_t>(states.rows()));
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), Chance(9));
  const auto askInParts = [&](SceneBatch asked, Index first, Index step) {
    for (Index begin = first; begin < states.rows(); begin += step) {
      const Index count = std::min<Index>(7, states.rows() - begin);
      const std::vector<Index> numbers(order.begin() + begin, order.begin() + begin + count);
      MatrixXd part(count, states.cols());
      for (Index i = 0; i < count; ++i) part.row(i) = states.row(numbers[i]);
      if (!HasFatalFailure()) expectSame(answersOf(asked, part), whole, numbers);
    }
  };
  std::thread other(askInParts, batch.forAnotherThread(), 7, 14);
  askInParts(batch.forAnotherThread(), 0, 14);
  other.join();
}

TEST_P(CellOf, ObjectsThatAreTakenAwayLeaveNothing) {
  const MatrixXd states = statesFor(50, 3);
  SceneBatch batch(model_);
  const BatchAnswers before = answersOf(batch, states);
  batch.use(someCell(model_, 4));
  EXPECT_NE(batch.pairs().size(), batch.candidates().size());
  batch.use(std::make_shared<const Objects>(model_));
  EXPECT_EQ(batch.pairs().size(), batch.candidates().size());
  std::vector<Index> all(before.minima.size());
  std::iota(all.begin(), all.end(), 0);
  expectSame(answersOf(batch, states), before, all);
}

constexpr const char* kRobots[] = {"Arm", "Alone", "Beads", "SolidsInParts", "Panda"};
INSTANTIATE_TEST_SUITE_P(Robots, CellOf, testing::ValuesIn(kRobots),
                         [](const auto& robot) { return std::string(robot.param); });

TEST(BatchWithObjects, RefusesWhatItCannotPlaceAndKeepsWhatItHad) {
  const auto model = arm();
  const auto with = [&](const Placement& placement) {
    const Object ball = makeObject("ball", {{Shape(Sphere{0.1})}}, placement);
    return std::make_shared<const Objects>(Objects(model).changed({AddObject{ball}}));
  };
  SceneBatch batch(model);
  EXPECT_EQ(batch.objects(), nullptr);
  const auto objects = with(Fixed{at(1.0, 0.0, 0.0)});
  batch.use(objects);
  EXPECT_THROW(batch.use(std::make_shared<const Objects>(arm())), std::invalid_argument);
  for (const char* const name : {"\"ball\"", "\"hnad\""})
    EXPECT_TRUE(isRefused([&] { batch.use(with(Moving{"hnad"})); }, name));
  EXPECT_EQ(batch.objects(), objects.get());
  EXPECT_EQ(batch.forAnotherThread().objects(), objects.get());
}

}  // namespace proximity_server::scene::batch_objects_test
