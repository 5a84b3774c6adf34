#include "scene/derivative/plane_figure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace proximity_server::scene::plane_figure_test {

using Eigen::Vector2d;

constexpr double kTolerance = 1e-9;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

PlaneFigure hullOf(const std::vector<Vector2d>& points) {
  PlaneFigure figure;
  figure.begin();
  for (const Vector2d& point : points) figure.add(point);
  figure.close();
  return figure;
}

PlaneFigure rectangle(double x0, double y0, double x1, double y1) {
  return hullOf({{x0, y0}, {x1, y1}, {x1, y0}, {x0, y1}});
}

PlaneFigure disc(double x, double y, double radius) {
  PlaneFigure figure;
  figure.becomeDisc({x, y}, radius);
  return figure;
}

double least(const PlaneFigure& a, const PlaneFigure& b, const Vector2d& slope) {
  const double value = minimumInCommon(a, b, slope, kTolerance);
  EXPECT_DOUBLE_EQ(minimumInCommon(b, a, slope, kTolerance), value);
  return value;
}

TEST(PlaneFigure, HasTheCornersOfTheHullCounterClockwise) {
  const PlaneFigure figure = hullOf({{1, 1}, {0, 0}, {0.5, 0.5}, {1, 0}, {0, 1}, {0.5, 0}, {0, 0}});
  EXPECT_EQ(figure.corners(), (std::vector<Vector2d>{{0, 0}, {1, 0}, {1, 1}, {0, 1}}));
}

TEST(PlaneFigure, MayBeAPointOrASegment) {
  EXPECT_EQ(hullOf({{2, 3}, {2, 3}}).corners(), (std::vector<Vector2d>{{2, 3}}));
  EXPECT_EQ(hullOf({{1, 1}, {3, 3}, {2, 2}}).corners(), (std::vector<Vector2d>{{1, 1}, {3, 3}}));
}

TEST(PlaneFigure, ContainsWhatIsInsideOrNear) {
  const PlaneFigure square = rectangle(0, 0, 1, 1);
  EXPECT_TRUE(square.contains({0.3, 0.6}, kTolerance));
  EXPECT_TRUE(square.contains({0.0, 1.0}, kTolerance));
  EXPECT_TRUE(square.contains({0.5, 1.0 + 0.5 * kTolerance}, kTolerance));
  EXPECT_FALSE(square.contains({0.5, 1.0 + 2.0 * kTolerance}, kTolerance));
  EXPECT_FALSE(square.contains({-3.0, 0.5}, kTolerance));
  EXPECT_TRUE(hullOf({{0, 0}, {2, 2}}).contains({1, 1}, kTolerance));
  EXPECT_FALSE(hullOf({{0, 0}, {2, 2}}).contains({1, 1.1}, kTolerance));
  EXPECT_TRUE(disc(1, 1, 0.5).contains({1.3, 1.4}, kTolerance));
  EXPECT_FALSE(disc(1, 1, 0.5).contains({1.4, 1.4}, kTolerance));
}

// Rounding may turn an edge that is as short as that any way round.
TEST(PlaneFigure, ContainsWhatIsFarFromAnEdgeOfNoLength) {
  const PlaneFigure figure = hullOf({{0, 0}, {1, 0}, {1, 1e-16}, {1, 1}, {1e-16, 1}, {0, 1}});
  EXPECT_TRUE(figure.contains({0.001, 0.999}, kTolerance));
  EXPECT_TRUE(figure.contains({0.5, 0.5}, kTolerance));
}

TEST(LeastInCommon, IsAtACornerOfOneInTheOther) {
  EXPECT_DOUBLE_EQ(least(rectangle(0, 0, 4, 4), rectangle(1, 2, 3, 3), {1, 10}), 21.0);
  EXPECT_DOUBLE_EQ(least(rectangle(0, 0, 4, 4), hullOf({{1, 1}}), {1, 1}), 2.0);
}

TEST(LeastInCommon, IsAtACrossingOfEdges) {
  // A cross: the common square is [1, 2] x [1, 2].
  EXPECT_DOUBLE_EQ(least(rectangle(0, 1, 3, 2), rectangle(1, 0, 2, 3), {1, 1}), 2.0);
  EXPECT_DOUBLE_EQ(least(hullOf({{0, 0}, {2, 2}}), hullOf({{0, 2}, {2, 0}}), {3, 0}), 3.0);
}

TEST(LeastInCommon, OfSegmentsOnOneLineIsAtAnEnd) {
  EXPECT_DOUBLE_EQ(least(hullOf({{0, 0}, {2, 1}}), hullOf({{1, 0.5}, {4, 2}}), {2, 0}), 2.0);
}

// Rounding has turned the second one, and their crossing may be anywhere.
TEST(LeastInCommon, OfSegmentsThatAreParallelWithinRoundingIsAtAnEndToo) {
  for (const double turned : {-2e-16, -1e-17, 1e-17, 2e-16})
    EXPECT_NEAR(least(hullOf({{0, 0}, {2, 0}}), hullOf({{1, -turned}, {4, turned}}), {2, 0}), 2.0, 1e-15);
}

TEST(LeastInCommon, OfADiscIsAtItsLowestPointOrAtTheCrossings) {
  EXPECT_DOUBLE_EQ(least(disc(0, 0, 1), rectangle(-2, -2, 2, 2), {3, 4}), -5.0);
  EXPECT_DOUBLE_EQ(least(disc(0, 0, 1), rectangle(0.6, -2, 2, 2), {1, 0.5}), 0.2);
  EXPECT_DOUBLE_EQ(least(disc(0, 0, 1), hullOf({{0.6, -2}, {0.6, 2}}), {0, 1}), -0.8);
  EXPECT_DOUBLE_EQ(least(disc(0, 0, 1), disc(0.5, 0, 3), {0, 1}), -1.0);
  EXPECT_NEAR(least(disc(0, 0, 1), disc(1.2, 0, 1), {0, 1}), -0.8, 1e-15);  // 3, 4, 5
  EXPECT_DOUBLE_EQ(least(disc(0, 0, 1), disc(1.2, 0, 1), {1, 0}), 0.2);
}

TEST(LeastInCommon, IsInfiniteOfFiguresThatDoNotMeet) {
  EXPECT_EQ(least(rectangle(0, 0, 1, 1), rectangle(2, 0, 3, 1), {1, 1}), kInfinity);
  EXPECT_EQ(least(disc(0, 0, 1), disc(3, 0, 1), {1, 1}), kInfinity);
  EXPECT_EQ(least(disc(0, 0, 1), disc(0.1, 0, 3), {1, 0}), -1.0);
  EXPECT_EQ(least(disc(0, 0, 1), rectangle(1, 1, 2, 2), {1, 1}), kInfinity);
}

TEST(LeastOn, IsThatOfTheWholeFigure) {
  EXPECT_DOUBLE_EQ(minimumOn(rectangle(0, 1, 3, 2), {1, -1}), -2.0);
  EXPECT_DOUBLE_EQ(minimumOn(disc(1, 1, 2), {3, 4}), -3.0);
}

}  // namespace proximity_server::scene::plane_figure_test
