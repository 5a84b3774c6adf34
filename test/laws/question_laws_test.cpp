// The laws of questions about a robot in a state, for each question.
#include "laws/question_laws.h"

#include "laws/scene_questions.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "sanitized.h"
#include "scene/random_objects.h"
#include "scene/random_states.h"

#include <gtest/gtest.h>

#include <type_traits>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace proximity_server::scene::laws {

/// An arm in random states, with objects of all kinds: a mesh and a ball that moves with a link, a held tool, and fixed ones
/// unless they are left out.
Cell armAmongObjects(int states, bool with_fixed_objects = true) {
  Cell cell;
  cell.model = arm();
  Chance chance(61);
  std::vector<ObjectChange> changes{
      AddObject{makeObject("ball", {{narrowphase::Sphere{0.1}}}, Moving{"base", at(0.7, 0.2, 0.5)})},
      AddObject{makeObject("tool", {{narrowphase::Box{{0.02, 0.03, 0.2}}}}, Attached{"hand", {}, at(0, 0, 0.3)})},
      AddObject{someSolid("solid", Moving{"fore", at(0.4, 0, 0)}, chance)}};
  if (with_fixed_objects)
    for (int i = 0; i < 6; ++i)
      changes.push_back(AddObject{someObject("object " + std::to_string(i), Fixed{chance.pose(0.8)}, chance)});
  cell.objects = std::make_shared<const Objects>(Objects(cell.model).changed(changes));
  State state(cell.model);
  state.set(cell.objects, carriersOnLinks(*cell.objects));
  for (int i = 0; i < states; ++i) {
    const std::vector<double> positions = randomPositions(cell.model->robot, chance);
    setPositions(state, positions);
    cell.states.push_back({positions, state.poses(), state.frames()});
  }
  return cell;
}

const Cell& cellOf(int states) {
  static const Cell all = armAmongObjects(repeats(60));
  static std::map<int, Cell> parts;
  Cell& part = parts[states];
  if (part.states.empty()) {
    part = all;
    part.states.resize(std::min(part.states.size(), static_cast<std::size_t>(states)));
  }
  return part;
}

struct NameOf {
  template <class Q>
  static std::string GetName(int) {
    return Q::kName;
  }
};

using testing::Types;

/// All questions.
template <class Q>
class LawsOf : public testing::Test {};
using All_ = Types<Minimum, Closest, Below, First, All, OnePair, OfPoints, OfRays, OfGradients, OfRows, OfFreeMotion,
                   OfGuaranteed, OfAssessment, OfContact, OfMinimumOfMotion, OfVelocityScale, OfSeparation,
                   BatchMinimum, BatchMinimumWithin, BatchDeciding, BatchClosest, BatchBelow, BatchVerdict>;
TYPED_TEST_SUITE(LawsOf, All_, NameOf);

TYPED_TEST(LawsOf, IsTheSameInOtherThreads) { EXPECT_TRUE(isTheSameInOtherThreads<TypeParam>(cellOf(12))); }
TYPED_TEST(LawsOf, IsTheSameAskedAgain) { EXPECT_TRUE(isTheSameAskedAgain<TypeParam>(cellOf(12))); }
TYPED_TEST(LawsOf, IsUnknownWithoutAPose) {
  const Cell& cell = cellOf(3);
  EXPECT_TRUE(isUnknownWithoutAPose<TypeParam>(cell, bodyOf(cell.model->robot, "fore")));
}

/// Those that take no memory from the heap once they have their room. The narrowphase of motions does.
template <class Q>
class MemoryOf : public testing::Test {};
using WithoutMotions =
    Types<Minimum, Closest, Below, First, All, OnePair, OfGradients, OfRows, OfFreeMotion, OfGuaranteed, OfAssessment,
          BatchMinimum, BatchMinimumWithin, BatchDeciding, BatchClosest, BatchBelow, BatchVerdict>;
TYPED_TEST_SUITE(MemoryOf, WithoutMotions, NameOf);

TYPED_TEST(MemoryOf, AllocatesNothingTheSecondTime) {
  if (kIsSanitized) GTEST_SKIP() << "a sanitizer allocates";
  EXPECT_TRUE(allocatesNothingAfter<TypeParam>(cellOf(40), cellOf(40).states.size(), 2));
}

/// Those that have their room after one state, as long as there are no objects.
template <class Q>
class MemoryWithoutObjectsOf : public testing::Test {};
using OfScenes = Types<Minimum, Closest, Below, First, All, OnePair, OfRows>;
TYPED_TEST_SUITE(MemoryWithoutObjectsOf, OfScenes, NameOf);

TYPED_TEST(MemoryWithoutObjectsOf, AllocatesNothingAfterTheFirstState) {
  if (kIsSanitized) GTEST_SKIP() << "a sanitizer allocates";
  Cell cell = cellOf(40);
  cell.objects = std::make_shared<const Objects>(cell.model);
  for (RobotState& state : cell.states) state.frames.clear();
  EXPECT_TRUE(allocatesNothingAfter<TypeParam>(cell, 1, 1));
}

TEST(MemoryOfPointsAndRays, AllocatesNothingAtRest) {
  if (kIsSanitized) GTEST_SKIP() << "a sanitizer allocates";
  EXPECT_TRUE(allocatesNothingAtRest<OfPoints>(cellOf(1)));
  EXPECT_TRUE(allocatesNothingAtRest<OfRays>(cellOf(1)));
}

/// Those about a State, not about positions.
template <class Q>
class PosesOf : public testing::Test {};
using OfPoses = Types<Minimum, Closest, Below, First, All, OnePair, OfPoints, OfRays, OfGradients, OfRows, OfFreeMotion,
                      OfGuaranteed, OfAssessment, OfVelocityScale, OfSeparation>;
TYPED_TEST_SUITE(PosesOf, OfPoses, NameOf);

TYPED_TEST(PosesOf, RefusesAnotherRobot) { EXPECT_TRUE(refusesAnotherRobot<TypeParam>(cellOf(1))); }

TYPED_TEST(PosesOf, MovesWithItsRobot) {
  const Cell cell = armAmongObjects(10, false);
  Chance chance(62);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(movesWithItsRobot<TypeParam>(cell, chance.pose(10.0), 1e-9));
}

/// Those with a deadline; bounds alone may decide First.
template <class Q>
class DeadlineOf : public testing::Test {};
using WithDeadline = Types<Minimum, Closest, Below, All, OnePair, OfPoints, OfRays, OfFreeMotion, OfGuaranteed,
                           OfAssessment, OfContact, OfMinimumOfMotion, OfVelocityScale, OfSeparation, BatchMinimum,
                           BatchMinimumWithin, BatchDeciding, BatchClosest, BatchBelow, BatchVerdict>;
TYPED_TEST_SUITE(DeadlineOf, WithDeadline, NameOf);

TYPED_TEST(DeadlineOf, LeavesBoundsThatHold) { EXPECT_TRUE(endsAtItsDeadline<TypeParam>(cellOf(6))); }

/// Those about pairs with a normal.
template <class Q>
class PairsOf : public testing::Test {};
using OfPairs = Types<Minimum, Closest, All, OnePair, OfContact, OfMinimumOfMotion>;
TYPED_TEST_SUITE(PairsOf, OfPairs, NameOf);

template <class Q>
constexpr bool kIsOfMotion = std::is_same_v<Q, OfContact> || std::is_same_v<Q, OfMinimumOfMotion>;

TYPED_TEST(PairsOf, AreTheSameSwapped) {
  EXPECT_TRUE(isTheSameSwapped<TypeParam>(cellOf(12), !kIsOfMotion<TypeParam>));
}

}  // namespace proximity_server::scene::laws
