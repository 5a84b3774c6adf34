#include "tools/second_opinion/judgement.h"

#include "proximity_server/narrowphase/signed_distance.h"
#include "sanitized.h"
#include "tools/second_opinion/single_piece.h"

#include <gtest/gtest.h>

namespace proximity_server::tools::judgement_test {

using namespace narrowphase;

using Eigen::Vector3d;

constexpr double kTolerance = 1e-5;  // [m]

OtherOpinion otherOf(const SignedDistance& answer) {
  OtherOpinion other;
  other.answer = {OtherAnswer::Kind::Distance, answer.distance, {}, {}};
  for (int i = 0; i < 3; ++i) {
    other.answer.point_a[i] = answer.point_a[i];
    other.answer.point_b[i] = answer.point_b[i];
  }
  return other;
}

/// An answer that is wrong by `error` in all of its numbers, and no more than that.
SignedDistance movedBy(double error, SignedDistance answer) {
  for (double* number : {&answer.distance, &answer.lower_bound, &answer.upper_bound}) *number += error;
  return answer;
}

Ruling rulingOf(const PairCase& pair, const SignedDistance& ours, const OtherOpinion& other, double padding = 0.0) {
  const SinglePieces pieces(pair);
  const PlacedPieces a = pieces.a(), b = pieces.b();
  return judge({a, b, padding, ours, other}, kTolerance).ruling;
}

// A box of 1 m and a ball of radius 0.5 m, 1 m apart along x; and 0.25 m deep.
const PairCase kApart{"apart", Box{{1, 1, 1}}, Sphere{0.5}, at(2, 0, 0)};
const PairCase kDeep{"deep", Box{{1, 1, 1}}, Sphere{0.5}, at(0.75, 0, 0)};

SignedDistance answerTo(const PairCase& pair) { return signedDistance(pair.a, pair.b, pair.a_T_b); }

TEST(Judge, EqualValuesAgreeWithinTheTolerance) {
  for (const PairCase& pair : {kApart, kDeep})
    for (const double error : {0.0, 0.9e-5, -0.9e-5})
      EXPECT_EQ(rulingOf(pair, answerTo(pair), otherOf(movedBy(error, answerTo(pair)))), Ruling::Agrees);
}

TEST(Judge, AValueOutsideOfWhatIsProvenIsWrong) {
  for (const PairCase& pair : {kApart, kDeep}) {
    EXPECT_EQ(rulingOf(pair, answerTo(pair), otherOf(movedBy(-0.01, answerTo(pair)))), Ruling::BelowLower);
    EXPECT_EQ(rulingOf(pair, answerTo(pair), otherOf(movedBy(0.03, answerTo(pair)))), Ruling::AboveUpper);
  }
}

// The other library is right here, and its numbers alone are no proof: the axis and the points are.
TEST(Judge, FindsAnAnswerOfOursThatIsMadeWrong) {
  for (const PairCase& pair : {kApart, kDeep}) {
    const SignedDistance right = answerTo(pair);
    for (const double error : {0.03, -0.03})
      EXPECT_EQ(rulingOf(pair, movedBy(error, right), otherOf(right)), Ruling::OursRefuted) << pair.name << error;
  }
}

TEST(Judge, FindsAnAnswerOfRandomSolidsThatIsMadeWrong) {
  int judged = 0;
  for (const PairCase& pair : pairsInEveryState(solidShapes(), repeats(2), 23)) {
    const SignedDistance right = answerTo(pair);
    if (!(right.distance > 1e-3)) continue;
    ++judged;
    for (const double error : {1e-4, -1e-4})
      EXPECT_EQ(rulingOf(pair, movedBy(error, right), otherOf(right)), Ruling::OursRefuted) << describe(pair);
    EXPECT_EQ(rulingOf(pair, right, otherOf(movedBy(1e-4, right))), Ruling::AboveUpper) << describe(pair);
    EXPECT_EQ(rulingOf(pair, right, otherOf(movedBy(-1e-4, right))), Ruling::BelowLower) << describe(pair);
  }
  if (!kIsSanitized) {
    EXPECT_GT(judged, 30);
  }
}

TEST(Judge, AnOverlapWithoutDepthIsAnyValueUpToZero) {
  OtherOpinion overlap;
  overlap.answer.kind = OtherAnswer::Kind::Overlap;
  EXPECT_EQ(rulingOf(kDeep, answerTo(kDeep), overlap), Ruling::Agrees);
  EXPECT_EQ(rulingOf(kApart, answerTo(kApart), overlap), Ruling::BelowLower);
}

TEST(Judge, ThePaddingOfAPairIsTakenOffTheOtherValueToo) {
  const SignedDistance ours = movedBy(-0.1, answerTo(kApart));
  EXPECT_EQ(rulingOf(kApart, ours, otherOf(answerTo(kApart)), 0.1), Ruling::Agrees);
  EXPECT_EQ(rulingOf(kApart, ours, otherOf(ours), 0.1), Ruling::BelowLower);
}

TEST(Judge, WhatWasNotAnsweredIsNoDifference) {
  OtherOpinion failed;
  failed.end = ChildEnd::Aborted;
  EXPECT_EQ(rulingOf(kApart, answerTo(kApart), failed), Ruling::Failed);
  EXPECT_EQ(rulingOf(kApart, answerTo(kApart), OtherOpinion{}), Ruling::NotAsked);
}

TEST(Judge, NotANumberIsAFailure) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(rulingOf(kApart, answerTo(kApart), otherOf(movedBy(nan, answerTo(kApart)))), Ruling::Failed);
}

// The inside of a closed mesh lies between its pieces: our overlap is deeper than that of any two pieces.
TEST(Judge, AnOverlapWithTheInsideOfAMeshIsNotRefutedByItsPieces) {
  const SinglePieces pieces(kDeep);
  PlacedPieces a = pieces.a();
  const PlacedPieces b = pieces.b();
  const SignedDistance ours = movedBy(-0.2, answerTo(kDeep));
  const OtherOpinion other = otherOf(answerTo(kDeep));
  EXPECT_EQ(judge({a, b, 0.0, ours, other}, kTolerance).ruling, Ruling::OursRefuted);
  a.has_interior = true;
  EXPECT_EQ(judge({a, b, 0.0, ours, other}, kTolerance).ruling, Ruling::Inside);
}

}  // namespace proximity_server::tools::judgement_test
