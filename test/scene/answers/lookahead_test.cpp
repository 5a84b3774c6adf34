#include "proximity_server/scene/answers/lookahead.h"

#include "allocations.h"
#include "proximity_server/scene/answers/assessment.h"
#include "scene/small_robots.h"
#include "scene/solids.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::scene::lookahead_test {

using Certainty = FollowedSplines::Certainty;

/// Two balls of radius 0.1 m on rails along x, at 0 m and 1 m; their stop distance is 0.1 m. "left" may go to 0.75 m.
class TwoSliders : public testing::Test {
 protected:
  TwoSliders() {
    thresholds_.stop = PairDistances(0.1, 0.1);
    LookaheadQuestion& question = lookahead_.question();
    question.search = &search_;
    question.duration = 2.0;
    question.most_search_time = 60.0;
    question.start = forwardKinematics(model_->robot, Positions{0.0, 0.0});
    question.velocities = {0.0, 0.0};
    question.commanded = &commanded_;
    commanded_.positions = commanded_.tracking_error = {0.0, 0.0};
  }

  static std::shared_ptr<const SceneModel> sliders() {
    return modelOf(robotOf(urdfOf(link("rail") + link("left", ball("0.1")) + link("right", ball("0.1", "1 0 0")) +
                                  joint("l", "prismatic", "rail", "left", axis("1 0 0") + limits("-2", "0.75")) +
                                  slider("r", "rail", "right", "1 0 0"))));
  }

  /// A joint follows a spline that goes from rest to rest, over a time from 0 on.
  void follow(double goal, double duration, Certainty certainty = Certainty::Followed, int joint = 0) {
    auto splines = std::make_shared<JointSplines>();
    const Positions none{0.0, 0.0};
    splines->segments.emplace_back(model_->robot, TrajectoryPoint{0.0, none, none},
                                   TrajectoryPoint{duration, {goal, goal}, none});
    splines->inexact_before = none;
    commanded_.followed.push_back({splines, {joint}, 0.0, 0.0, 0.0, certainty});
  }

  const ContactAhead& find() { return lookahead_.find(pairs_, thresholds_.stop, stated_); }

  const std::shared_ptr<const SceneModel> model_ = sliders();
  const std::vector<ShapeRefPair> pairs_{{1, 2}};
  MotionSearch search_{model_};
  LevelThresholds thresholds_;
  std::vector<std::optional<double>> stated_{0.0, 0.0};
  CommandedMotion commanded_;
  Lookahead lookahead_;
};

/// The time at which a cubic from rest to rest has gone a share of its way.
double timeOfShare(double share) {
  double low = 0.0, high = 1.0;
  while (high - low > 1e-15) {
    const double middle = 0.5 * (low + high);
    (middle * middle * (3.0 - 2.0 * middle) < share ? low : high) = middle;
  }
  return low;
}

TEST_F(TwoSliders, KeepTheirVelocitiesUntilALimit) {
  lookahead_.question().velocities = {1.0, 0.0};  // 0.7 m to the contact, 0.75 m to the limit
  EXPECT_NEAR(find().time_to_contact, 0.7, 1e-5);
  EXPECT_LE(find().time_free, find().time_to_contact);
  lookahead_.question().velocities = {1.0, 0.2};  // at the limit after 0.75 s, and then the distance is 0.2 m
  const ContactAhead& ahead = find();
  EXPECT_FALSE(ahead.found.contact);
  EXPECT_EQ(ahead.time_free, 2.0);
  ASSERT_EQ(ahead.limits.stops.size(), 1U);
  EXPECT_NEAR(2.0 * ahead.limits.stops[0].time, 0.75, 1e-12);
  lookahead_.question().velocities = {1.0, -0.02};  // the contact is at 0.7 - 0.02 t
  EXPECT_NEAR(find().time_to_contact, 0.7 / 1.02, 1e-5);
  lookahead_.question().velocities = {0.0, std::numeric_limits<double>::max()};
  EXPECT_EQ(find().problem, "a velocity times the lookahead is not finite");
  lookahead_.question().velocities = {0.0, 0.0};
  EXPECT_EQ(find().problem, "");
}

TEST_F(TwoSliders, FollowTheirSplines) {
  lookahead_.question().velocities = {-1.0, 0.0};  // not that of the spline, which counts
  follow(1.0, 1.0);
  EXPECT_NEAR(find().time_to_contact, timeOfShare(0.7), 1e-5);
  EXPECT_TRUE(find().is_along_splines);
  commanded_.tracking_error[0] = 0.01;
  EXPECT_NEAR(find().time_free, timeOfShare(0.69), 1e-5);
  commanded_.tracking_error[0] = 0.0;
  commanded_.followed[0].ahead = 0.1;
  EXPECT_NEAR(find().time_free, timeOfShare(0.7) - 0.1, 1e-5);
  commanded_.followed[0].time = 0.2;
  EXPECT_NEAR(find().time_free, timeOfShare(0.7) - 0.3, 1e-5);
  lookahead_.question().duration = 0.1;
  EXPECT_EQ(find().time_free, 0.1);
  EXPECT_FALSE(find().found.contact);
}

TEST_F(TwoSliders, FollowSplinesOfManyPoints) {
  follow(1.0, 1.0);
  JointSplines parts = *commanded_.followed[0].splines;
  const SplineSegment whole = parts.segments[0];
  parts.segments.clear();
  for (int i = 0; i < 50; ++i) parts.segments.push_back(whole.between(0.02 * i, 0.02 * (i + 1)));
  EXPECT_NEAR(parts.largestSpeed(0, 0.4, 0.6), 1.5, 1e-3);  // that of the cubic in its middle
  EXPECT_NEAR(parts.largestSpeed(0, 0.9, 2.0), 0.54, 0.1);
  EXPECT_EQ(parts.largestSpeed(0, 1.1, 2.0), 0.0);
  commanded_.followed[0].splines = std::make_shared<JointSplines>(parts);
  EXPECT_NEAR(find().time_to_contact, timeOfShare(0.7), 1e-5);
  commanded_.followed[0].time = 0.3;
  EXPECT_NEAR(find().time_to_contact, timeOfShare(0.7) - 0.3, 1e-5);
}

/// "left" retreats, and "right", which is faster and up to 0.1 s ahead, reaches it.
TEST_F(TwoSliders, FollowSplinesWithDelaysOfTheirOwn) {
  follow(-0.5, 1.0);
  follow(-1.5, 1.0, Certainty::Followed, 1);
  commanded_.followed[1].ahead = 0.1;
  const auto share = [](double t) { return t * t * (3.0 - 2.0 * t); };
  double contact = 0.0;
  while (-1.5 * share(contact + 0.1) + 0.5 * share(contact) > -0.7) contact += 1e-6;
  EXPECT_LE(find().time_free, contact);
  EXPECT_GT(find().time_free, contact - 0.1);
}

TEST_F(TwoSliders, TakeTheEarliestContactOfAllThatMayBeFollowed) {
  follow(-1.0, 1.0, Certainty::PerhapsFollowed);
  EXPECT_EQ(find().motions, 2);
  EXPECT_FALSE(find().found.contact);
  lookahead_.question().velocities = {0.5, 0.0};
  EXPECT_NEAR(find().time_to_contact, 1.4, 1e-5);
  EXPECT_FALSE(find().is_along_splines);
  follow(1.0, 1.0, Certainty::PerhapsFollowed);
  EXPECT_EQ(find().motions, 3);
  EXPECT_NEAR(find().time_to_contact, timeOfShare(0.7), 1e-5);
  commanded_.followed[0].certainty = Certainty::Followed;  // the later one is not, as both are of the same joint
  EXPECT_EQ(find().motions, 1);
  EXPECT_FALSE(find().found.contact);
}

TEST_F(TwoSliders, AreNotSearchedInTooManyMotions) {
  for (int i = 0; i < Lookahead::kMostMotions - 1; ++i) follow(-0.1, 1.0, Certainty::PerhapsFollowed);
  EXPECT_EQ(find().motions, Lookahead::kMostMotions);
  EXPECT_EQ(find().time_free, 2.0);
  follow(-0.1, 1.0, Certainty::PerhapsFollowed);
  EXPECT_GT(find().motions, Lookahead::kMostMotions);
}

TEST_F(TwoSliders, AllocateNothingAfterTheFirstQuestions) {
  const auto allocatedBy = [&](double time) {
    if (!commanded_.followed.empty()) commanded_.followed[0].time = time;
    const long before = allocations();
    EXPECT_FALSE(find().found.contact);
    return allocations() - before;
  };
  lookahead_.question().velocities = {0.1, 0.01};
  allocatedBy(0.0);
  EXPECT_EQ(allocatedBy(0.0), 0);
  follow(0.6, 1.0);
  follow(0.6, 2.0, Certainty::Followed, 1);
  const std::vector<double> times{0.0, 0.1, 0.5, 0.9, 1.5};
  for (const double time : times) allocatedBy(time);
  for (const double time : times) EXPECT_EQ(allocatedBy(time), 0) << time;
}

}  // namespace proximity_server::scene::lookahead_test
