// Lanes, bounds and limits must not change an answer: the answers about many states are those of all pairs one by one,
// which are those of a new Scene, to the last bit.
//
// PROXIMITY_BATCH_STATES: how many states of each robot are compared with all pairs one by one.
#include "chance.h"
#include "from_environment.h"
#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/model/kinematics.h"
#include "sanitized.h"
#include "scene/batch/batch_robots.h"
#include "scene/batch/exact_state.h"
#include "scene/batch/same_answer.h"
#include "scene/posed_scene.h"
#include "scene/random_states.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace proximity_server::scene::batch_skipping_test {

using namespace narrowphase;

using Eigen::Index;
using Eigen::MatrixXd;
using Kind = StateVerdict::Kind;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The answers about one state by all pairs one by one.
class Everything {
 public:
  explicit Everything(const std::shared_ptr<const SceneModel>& model)
      : batch_(std::make_shared<const BatchModel>(model)), exact_(batch_) {}

  void place(const MatrixXd& states, Index state) {
    exact_.place(states, state);
    all_.clear();
    for (int pair = 0; pair < pairs(); ++pair) {
      const PairProximity proximity = exact_.proximity(pair);
      if (proximity.result.status != Status::Unknown) all_.push_back(proximity);
    }
    sorted_ = all_;
    sortByRank(sorted_);
  }

  /// Whether all pairs have poses.
  bool isPlaced() { return exact_.isPlaced(); }

  const std::vector<PairProximity>& sorted() const { return sorted_; }
  std::vector<PairProximity> closest(std::size_t k) const { return firstOf(sorted_, k); }
  /// The pair that sets the level.
  PairProximity deciding(const LevelThresholds& thresholds) const { return decidingOf(all_, thresholds); }
  std::vector<PairProximity> below(double distance) {
    std::vector<PairProximity> found;
    for (int pair = 0; pair < pairs(); ++pair)
      if (const PairProximity proximity = exact_.proximity(pair, distance);
          proximity.result.status != Status::Unknown && !(proximity.result.lower_bound > distance))
        found.push_back(proximity);
    sortByRank(found);
    return found;
  }

  /// Whether a verdict is right; of several pairs below the distance any may be named.
  bool agrees(const StateVerdict& verdict, double distance) {
    if (verdict.kind == Kind::Above) return verdict.pair == -1 && below(distance).empty();
    return verdict.kind == Kind::Below && verdict.pair >= 0 && verdict.pair < pairs() &&
           !(exact_.proximity(verdict.pair, distance).result.lower_bound > distance);
  }

 private:
  int pairs() const { return static_cast<int>(batch_->candidates.size()); }

  std::shared_ptr<const BatchModel> batch_;
  ExactState exact_;
  std::vector<PairProximity> all_, sorted_;
};

class BatchOf : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    model_ = robotNamed(GetParam());
    if (!model_) GTEST_SKIP() << GetParam() << " is not found, or not loaded under a sanitizer";
  }
  const RobotModel& robot() const { return model_->robot; }

  std::shared_ptr<const SceneModel> model_;
};

// --- what the answers are

TEST_P(BatchOf, PairsOneByOneHaveTheAnswersOfANewScene) {
  const MatrixXd states = variousStates(robot(), repeats(100), 1);
  const auto batch = std::make_shared<const BatchModel>(model_);
  ExactState exact(batch);
  const PosedScene fresh(model_);
  for (Index i = 0; i < states.rows(); ++i) {
    exact.place(states, i);
    const BodyPoses poses = forwardKinematics(robot(), positionsOf(states, i));
    for (const double threshold : {kInfinity, 0.2, 0.0, -0.05}) {
      Question question;
      question.threshold = threshold;
      PosedScene scene = fresh.forAnotherThread();
      scene.update(poses);
      for (int pair = static_cast<int>(batch->candidates.size()) - 1; pair >= 0;
           --pair) {  // in another order than all()
        const PairProximity found = exact.proximity(pair, threshold);
        const PairProximity expected = scene.proximity(batch->candidates[pair], question);
        const bool is_beyond = expected.result.lower_bound > threshold;
        ASSERT_TRUE(is_beyond ? found.result.lower_bound > threshold : areSame(found, expected))
            << "state " << i << ", pair " << pair << ", threshold " << threshold;
      }
    }
  }
}

/// Distances beside that of some pair, so that a bound which is wrong by a millionth of a metre gives a wrong answer.
TEST_P(BatchOf, AnswersAsAllPairsOneByOneDo) {
  constexpr int kBatch = 500;
  constexpr double kBeside[] = {0.0, 1e-9, -1e-9, 1e-7, -1e-7, 1e-6, -1e-6, 1e-5, -1e-5, 1e-4, -1e-4, 1e-3, -1e-3};
  const bool is_slow = model_->pairs.checked.size() > 200 || std::string("Solids") == GetParam();
  const auto count = fromEnvironment("PROXIMITY_BATCH_STATES", repeats(is_slow ? 200 : 2000));
  SceneBatch batch(model_), one(model_);
  Everything everything(model_);
  Chance random(2);
  std::int64_t overlaps = 0, listed = 0, compared = 0;
  for (unsigned part = 0; compared < count; ++part) {
    const MatrixXd states =
        variousStates(robot(), static_cast<int>(std::min<std::int64_t>(kBatch, count - compared)), 100 + part);
    const int k = 1 + static_cast<int>(part % 7);
    const auto minima = batch.minimum(states);
    const StatePairs closest = batch.closest(states, k);
    for (Index i = 0; i < states.rows(); ++i, ++compared) {
      SCOPED_TRACE("state " + std::to_string(i) + " of part " + std::to_string(part));
      everything.place(states, i);
      ASSERT_TRUE(areSameLists({minima[i]}, everything.closest(1)));
      ASSERT_TRUE(areSameLists(ofState(closest, i), everything.closest(static_cast<std::size_t>(k))));
      const std::size_t near = random() % 2 == 0 ? 0 : random() % std::min<std::size_t>(8, everything.sorted().size());
      const double distance = everything.sorted()[near].result.distance + kBeside[random() % std::size(kBeside)];
      const auto below = everything.below(distance);
      ASSERT_TRUE(areSameLists(one.below(states.row(i), distance).pairs, below)) << distance;
      const StateVerdict verdict = one.anyBelow(states.row(i), distance).front();
      ASSERT_TRUE(everything.agrees(verdict, distance)) << distance << ", pair " << verdict.pair;
      overlaps += minima[i].result.distance < 0.0;
      listed += static_cast<std::int64_t>(below.size());
    }
  }
  if (!kIsSanitized) {
    EXPECT_GT(overlaps, 0);
    EXPECT_GT(listed, count / 4);
  }
}

/// Thresholds of some pairs: a part of them is always near, and a part is to keep far apart.
LevelThresholds randomThresholds(const SceneModel& model, unsigned seed) {
  Chance random(seed);
  std::uniform_real_distribution<double> distance(0.0, 0.2);
  LevelThresholds thresholds;
  for (const ShapeRefPair& pair : Candidates(model.pairs)) {
    if (random() % 3 != 0) continue;
    const auto [stop, warn] = std::minmax({distance(random), distance(random)});
    thresholds.stop.setPair(pair.a.link(), pair.b.link(), stop);
    thresholds.warn.setPair(pair.a.link(), pair.b.link(), warn);
  }
  return thresholds;
}

TEST_P(BatchOf, DecidingPairIsThatOfAllPairsOneByOne) {
  const MatrixXd states = variousStates(robot(), repeats(600), 11);
  SceneBatch batch(model_);
  Everything everything(model_);
  const LevelThresholds thresholds = randomThresholds(*model_, 12);
  const auto minima = batch.minimum(states);
  const auto& deciding = batch.deciding(states, thresholds);
  int others = 0;
  for (Index i = 0; i < states.rows(); ++i) {
    everything.place(states, i);
    const auto state = static_cast<std::size_t>(i);
    ASSERT_TRUE(areSameLists({deciding[state]}, {everything.deciding(thresholds)})) << "state " << i;
    others += !areSame(deciding[state], minima[state]);
  }
  // Something overlaps in every state of Solids.
  if (!kIsSanitized && std::string("Solids") != GetParam()) {
    EXPECT_GT(others, states.rows() / 50);
  }
}

TEST_P(BatchOf, MinimumWithinAnAccuracyBoundsTheMinimum) {
  const MatrixXd states = variousStates(robot(), repeats(1000), 19);
  SceneBatch batch(model_);
  Everything everything(model_);
  const std::vector<PairProximity> minima = batch.minimum(states);
  int apart = 0, overlaps = 0;
  for (const double accuracy : {0.01, 1e-4, 1e-6, 2e-9}) {
    SCOPED_TRACE(accuracy);
    const std::vector<PairProximity>& within = batch.minimumWithin(states, accuracy);
    ASSERT_EQ(within.size(), minima.size());
    for (std::size_t i = 0; i < minima.size(); ++i) {
      const SignedDistance &truth = minima[i].result, &found = within[i].result;
      ASSERT_EQ(found.status, truth.status == Status::Unknown ? Status::Unknown : Status::Threshold) << "state " << i;
      if (truth.status == Status::Unknown) continue;
      // A distance that did not converge is ranked by its lower bound, so another pair may be below its upper bound.
      ASSERT_LE(found.lower_bound, truth.upper_bound) << "state " << i;
      ASSERT_GE(found.upper_bound, truth.lower_bound) << "state " << i;
      ASSERT_EQ(found.distance, found.upper_bound > 0.0 ? found.lower_bound : found.upper_bound);
      ASSERT_FALSE(found.has_points);
      if (truth.status == Status::Converged && truth.distance > 1e-8) {
        ASSERT_LE(found.upper_bound - found.lower_bound, accuracy + 1e-9) << "state " << i;
        ++apart;
      } else if (truth.distance < -1e-8) {
        ASSERT_TRUE(found.upper_bound <= 0.0 || found.upper_bound - found.lower_bound <= accuracy) << "state " << i;
        overlaps += found.upper_bound <= 0.0 ? 1 : 0;
      }
      if (i % 50 != 0) continue;
      everything.place(states, static_cast<Index>(i));
      for (const PairProximity& pair : everything.sorted()) {
        ASSERT_GE(pair.result.upper_bound, found.lower_bound);
        const bool is_named = pair.asked.a == within[i].asked.a && pair.asked.b == within[i].asked.b;
        ASSERT_TRUE(!is_named || pair.result.lower_bound <= found.upper_bound);
      }
    }
  }
  if (!kIsSanitized) {
    EXPECT_GT(apart + overlaps, 3000);
  }
  for (const double wrong : {0.0, -1.0, kNaN}) EXPECT_THROW(batch.minimumWithin(states, wrong), std::invalid_argument);
}

// --- what they do not depend on

class Many : public BatchOf {
 protected:
  void SetUp() override {
    BatchOf::SetUp();
    if (IsSkipped()) return;
    states_ = variousStates(robot(), repeats(1000), 3);
    states_(states_.rows() / 3, 0) = kNaN;
    states_(states_.rows() / 2, 0) = 1e6;
    SceneBatch batch(model_);
    whole_.emplace(answersOf(batch, states_));
  }
  std::vector<Index> numbers(Index first, Index count) const {
    std::vector<Index> numbers(static_cast<std::size_t>(count));
    std::iota(numbers.begin(), numbers.end(), first);
    return numbers;
  }

  static BatchAnswers answersOf(SceneBatch& batch, const States& states) {
    return {batch, states, randomThresholds(batch.model(), 15)};
  }

  MatrixXd states_;
  std::optional<BatchAnswers> whole_;
};

TEST_P(Many, AnAnswerDoesNotDependOnTheSizeOfTheBatch) {
  SceneBatch batch(model_);
  for (const Index size : {1, 7, 256, 257}) {
    for (Index first = 0; first < states_.rows(); first += size) {
      const Index count = std::min(size, states_.rows() - first);
      expectSame(answersOf(batch, states_.middleRows(first, count)), *whole_, numbers(first, count));
      ASSERT_FALSE(HasFatalFailure()) << "size " << size << ", from " << first;
    }
  }
}

TEST_P(Many, AnAnswerDoesNotDependOnTheOrderOfTheStates) {
  std::vector<Index> order = numbers(0, states_.rows());
  std::shuffle(order.begin(), order.end(), Chance(4));
  MatrixXd shuffled(states_.rows(), states_.cols());
  for (Index i = 0; i < states_.rows(); ++i) shuffled.row(i) = states_.row(order[i]);
  SceneBatch batch(model_);
  expectSame(answersOf(batch, shuffled), *whole_, order);
}

/// Along edges the pairs of one state are likely to be those of the next one: nothing else may be taken from it.
TEST_P(Many, AnAnswerAlongEdgesIsThatOfTheStateAlone) {
  MatrixXd states = statesAlongEdges(robot(), repeats(1800), 5);
  states(20, 0) = kNaN;
  states(40, 0) = 1e6;
  SceneBatch batch(model_), other(model_);
  const BatchAnswers whole = answersOf(batch, states);
  std::vector<Index> order = numbers(0, states.rows());
  std::reverse(order.begin(), order.end());
  const MatrixXd reversed = states.colwise().reverse();
  expectSame(answersOf(other, reversed), whole, order);
  std::shuffle(order.begin(), order.end(), Chance(6));
  MatrixXd shuffled(states.rows(), states.cols());
  for (Index i = 0; i < states.rows(); ++i) shuffled.row(i) = states.row(order[i]);
  expectSame(answersOf(other, shuffled), whole, order);
  if (!kIsSanitized) {
    EXPECT_GT(states.rows(), 3 * LaneBounds::kBlock);
  }
}

TEST_P(Many, AnAnswerDoesNotDependOnTheLayoutOfTheStates) {
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> by_rows = states_;
  MatrixXd apart = MatrixXd::Constant(2 * states_.rows(), 3 * states_.cols(), kNaN);
  using Strides = Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>;
  Eigen::Map<MatrixXd, 0, Strides> every_second(apart.data(), states_.rows(), states_.cols(),
                                                Strides(3 * apart.rows(), 2));
  every_second = states_;
  SceneBatch batch(model_);
  const Eigen::Map<const MatrixXd, 0, Strides> rows_in_place(by_rows.data(), states_.rows(), states_.cols(),
                                                             Strides(1, states_.cols()));
  expectSame(answersOf(batch, rows_in_place), *whole_, numbers(0, states_.rows()));
  expectSame(answersOf(batch, every_second), *whole_, numbers(0, states_.rows()));
}

constexpr const char* kRobots[] = {"TwoArms", "Beads", "JoinedArms", "Solids", "Demo", "Panda", "Ur5", "Pr2"};
const auto nameOf = [](const testing::TestParamInfo<const char*>& robot) { return std::string(robot.param); };
INSTANTIATE_TEST_SUITE_P(Robots, BatchOf, testing::ValuesIn(kRobots), nameOf);
INSTANTIATE_TEST_SUITE_P(Robots, Many, testing::Values("TwoArms", "Beads", "Panda"), nameOf);

// --- states that are no states

TEST(BatchOfBeads, AStateThatIsNotFiniteHasNoAnswer) {
  SceneBatch batch(beads());
  MatrixXd states = randomStates(batch.model().robot, 5, 6);
  states(1, 0) = kNaN;
  states(2, 3) = kInfinity;
  states(3, states.cols() - 1) = -kInfinity;
  const auto minima = batch.minimum(states);
  const auto deciding = batch.deciding(states, randomThresholds(batch.model(), 17));
  const auto verdicts = batch.anyBelow(states, 100.0);
  const StatePairs closest = batch.closest(states, 2), below = batch.below(states, 100.0);
  for (Index i = 0; i < states.rows(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    const bool is_unknown = i >= 1 && i <= 3;
    EXPECT_EQ(minima[at].result.status == Status::Unknown, is_unknown) << i;
    EXPECT_EQ(deciding[at].result.status == Status::Unknown, is_unknown) << i;
    EXPECT_EQ(verdicts[at].kind, is_unknown ? Kind::Unknown : Kind::Below) << i;
    EXPECT_EQ(closest.unknown[at], is_unknown) << i;
    EXPECT_EQ(below.unknown[at], is_unknown) << i;
    EXPECT_EQ(ofState(closest, i).size(), is_unknown ? 0u : 2u) << i;
    EXPECT_EQ(ofState(below, i).empty(), is_unknown) << i;
  }
}

/// Beyond the range of the lanes; prismatic joints carry links as far away.
TEST(BatchOfBeads, HugePositionsHaveTheAnswersOfANewScene) {
  const auto model = beads();
  SceneBatch batch(model);
  Everything everything(model);
  MatrixXd states = randomStates(model->robot, 12, 7);
  const double factors[] = {1e3, 1e6, 1e9, 1e15, 1e100, 1e300};
  for (Index i = 0; i < states.rows(); ++i)
    for (Index j = i % 2; j < states.cols(); j += 2) states(i, j) *= factors[i / 2];
  const auto minima = batch.minimum(states);
  const StatePairs closest = batch.closest(states, 5), below = batch.below(states, 0.3);
  const auto verdicts = batch.anyBelow(states, 0.3);
  int unknown = 0;
  for (Index i = 0; i < states.rows(); ++i) {
    SCOPED_TRACE("state " + std::to_string(i));
    everything.place(states, i);
    const bool is_unknown = !everything.isPlaced();
    unknown += is_unknown ? 1 : 0;
    EXPECT_EQ(closest.unknown[i], is_unknown);
    EXPECT_EQ(below.unknown[i], is_unknown);
    if (is_unknown) {
      EXPECT_EQ(minima[i].result.status, Status::Unknown);
      EXPECT_EQ(verdicts[i].kind, Kind::Unknown);
      EXPECT_TRUE(ofState(closest, i).empty() && ofState(below, i).empty());
      continue;
    }
    if (!everything.sorted().empty()) {
      EXPECT_TRUE(areSameLists({minima[i]}, everything.closest(1)));
    } else {
      EXPECT_EQ(minima[i].result.status, Status::Unknown);
    }
    EXPECT_TRUE(areSameLists(ofState(closest, i), everything.closest(5)));
    EXPECT_TRUE(areSameLists(ofState(below, i), everything.below(0.3)));
    EXPECT_TRUE(everything.agrees(verdicts[i], 0.3));
  }
  EXPECT_GE(unknown, 1);  // at 1e300
  EXPECT_LE(unknown, 2);
}

TEST(BatchOfBeads, ThePositionOfAMimicJointIsIgnored) {
  SceneBatch batch(beads());
  const RobotModel& robot = batch.model().robot;
  MatrixXd states = randomStates(robot, 20, 8);
  const std::vector<PairProximity> before = batch.minimum(states);
  for (std::size_t j = 0; j < robot.joints.size(); ++j)
    if (robot.joints[j].mimic) states.col(static_cast<Index>(j)).setConstant(0.7);
  EXPECT_TRUE(areSameLists(batch.minimum(states), before));
}

// --- numbers at the ends

TEST(BatchOfBeads, KFromNegativeToMoreThanThereArePairs) {
  SceneBatch batch(beads());
  const MatrixXd states = randomStates(batch.model().robot, 3, 9);
  const std::size_t pairs = batch.candidates().size();
  EXPECT_THROW(batch.closest(states, 0), std::invalid_argument);
  EXPECT_THROW(batch.closest(states, -1), std::invalid_argument);
  const StatePairs all = batch.closest(states, static_cast<int>(pairs)), more = batch.closest(states, 1 << 30);
  EXPECT_EQ(all.pairs.size(), 3 * pairs);
  EXPECT_TRUE(areSameLists(more.pairs, all.pairs));
}

TEST(BatchOfBeads, EveryPairIsBelowInfinityAndNoneBelowMinusInfinity) {
  SceneBatch batch(beads());
  const MatrixXd states = randomStates(batch.model().robot, 3, 10);
  EXPECT_EQ(batch.below(states, kInfinity).pairs.size(), 3 * batch.candidates().size());
  EXPECT_TRUE(batch.below(states, -kInfinity).pairs.empty());
  EXPECT_EQ(batch.anyBelow(states, kInfinity)[0].kind, Kind::Below);
  EXPECT_EQ(batch.anyBelow(states, -kInfinity)[0].kind, Kind::Above);
}

TEST(BatchWithoutPairs, HasNoMinimumAndNothingBelow) {
  SceneBatch batch(nothingToCheck());
  ASSERT_TRUE(batch.candidates().empty());
  const MatrixXd states = MatrixXd::Constant(2, 1, 0.5);
  EXPECT_EQ(batch.minimum(states)[1].result.status, Status::Unknown);
  EXPECT_EQ(batch.minimumWithin(states, 1e-4)[1].result.status, Status::Unknown);
  EXPECT_EQ(batch.anyBelow(states, 1.0)[1].kind, Kind::Above);
  EXPECT_TRUE(batch.closest(states, 3).pairs.empty());
  EXPECT_EQ(batch.below(states, 1.0).unknown, (std::vector<unsigned char>{0, 0}));
}

TEST(BatchWithoutStates, HasNoAnswers) {
  SceneBatch batch(beads());
  const MatrixXd states(0, static_cast<Index>(batch.model().robot.joints.size()));
  EXPECT_TRUE(batch.minimum(states).empty());
  EXPECT_TRUE(batch.anyBelow(states, 1.0).empty());
  EXPECT_EQ(batch.closest(states, 3).begins, (std::vector<std::size_t>{0}));
}

}  // namespace proximity_server::scene::batch_skipping_test
