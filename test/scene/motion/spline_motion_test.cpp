#include "proximity_server/scene/motion/motion_search.h"

#include "allocations.h"
#include "chance.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "proximity_server/scene/objects/object_editor.h"
#include "sanitized.h"
#include "scene/example_robots.h"
#include "scene/files.h"
#include "scene/posed_scene.h"
#include "scene/random_objects.h"
#include "scene/random_states.h"
#include "scene/small_robots.h"
#include "scene/two_arms.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <vector>

namespace proximity_server::scene::spline_motion_test {

using narrowphase::Status;

constexpr double kTolerance = 1e-6;  // [m] the default

// Two cubes of edge 1 on the x axis, about (left, 0, 0) and (4 + right, 0, 0): the gap is 3 + right - left.
const std::string kCarts =
    urdfOf(link("rail") + link("l", box("1 1 1")) + link("r", box("1 1 1")) + slider("left", "rail", "l", "1 0 0") +
           slider("right", "rail", "r", "1 0 0", "4 0 0"));

/// The carts while the left one goes from 0 to 2.5 in a second, and arrives with a velocity.
class Carts : public testing::Test {
 protected:
  SplineSegment arrivingWith(double velocity) const {
    const RobotModel& robot = model_->robot;
    return {robot,
            {0.0, byJoint(robot, {}), byJoint(robot, {})},
            {1.0, byJoint(robot, {{"left", 2.5}}), byJoint(robot, {{"left", velocity}})}};
  }
  /// The way at a time, in powers of the time: with the velocity v it is (7.5 - v) t^2 + (v - 5) t^3.
  static double way(double velocity, double time) { return ((7.5 - velocity) + (velocity - 5.0) * time) * time * time; }
  static double farthest(double velocity) { return way(velocity, 2.0 * (7.5 - velocity) / (3.0 * (5.0 - velocity))); }
  /// When the way is reached first.
  static double timeOf(double velocity, double length) {
    double low = 0.0, high = 2.0 * (7.5 - velocity) / (3.0 * (5.0 - velocity));
    for (int i = 0; i < 100; ++i) {
      const double middle = 0.5 * (low + high);
      (way(velocity, middle) < length ? low : high) = middle;
    }
    return low;
  }
  Motion exactly(const SplineSegment& segment) const { return Motion(model_->robot, segment); }
  Motion tube(const SplineSegment& segment, double error) const {
    return Motion(model_->robot, segment, std::vector<double>(model_->robot.joints.size(), error));
  }

  const std::shared_ptr<const SceneModel> model_ = modelOf(kCarts);
  const std::vector<ShapeRefPair> pair_ = {pairOf(*model_, "l", "r")};
  MotionSearch scene_{model_};
};

TEST_F(Carts, OvershootTouchesAlthoughThePointsAndTheStraightWayAreClear) {
  const SplineSegment segment = arrivingWith(-8.0);
  const RobotMotion straight = RobotMotion::between(model_->robot, segment.at(0.0), segment.at(1.0));
  ASSERT_NEAR(MotionSearch(model_).minimum(pair_, straight).upper_bound, 0.5, 1e-6);
  const RobotTimeOfContact contact = scene_.timeOfContact(pair_, exactly(segment));
  EXPECT_EQ(contact.status, Status::Converged);
  ASSERT_TRUE(contact.contact);
  const double first = timeOf(-8.0, 3.0);
  EXPECT_LE(contact.t_free, first);
  EXPECT_NEAR(contact.t_contact, first, 1e-6);
  EXPECT_EQ(contact.state, segment.at(contact.t_contact));
  const RobotMinimum minimum = scene_.minimum(pair_, exactly(segment));
  EXPECT_LE(minimum.lower_bound, 3.0 - farthest(-8.0));
  EXPECT_GE(minimum.upper_bound, 3.0 - farthest(-8.0) - 1e-12);
  EXPECT_LE(minimum.upper_bound - minimum.lower_bound, kTolerance);
}

TEST_F(Carts, OvershootThatStopsShortIsProvenFree) {
  const SplineSegment segment = arrivingWith(-4.0);
  const RobotTimeOfContact contact = scene_.timeOfContact(pair_, exactly(segment));
  EXPECT_EQ(contact.status, Status::Converged);
  EXPECT_FALSE(contact.contact);
  EXPECT_EQ(contact.t_free, 1.0);
  const RobotMinimum minimum = scene_.minimum(pair_, exactly(segment));
  EXPECT_EQ(minimum.status, Status::Converged);
  EXPECT_LE(minimum.lower_bound, 3.0 - farthest(-4.0));
  EXPECT_NEAR(minimum.upper_bound, 3.0 - farthest(-4.0), kTolerance);
  EXPECT_LE(minimum.upper_bound - minimum.lower_bound, kTolerance);
}

TEST_F(Carts, GrazingIsToldFromContact) {
  MotionQuestion question;
  for (const double beside : {3e-6, -3e-6}) {
    question.contact_distance = 3.0 - farthest(-4.0) - beside;
    const RobotTimeOfContact contact = scene_.timeOfContact(pair_, exactly(arrivingWith(-4.0)), question);
    EXPECT_EQ(contact.status, Status::Converged);
    EXPECT_EQ(contact.contact, beside < 0.0);
  }
}

TEST_F(Carts, TubeTakesTheTrackingErrorsOfBothJointsOff) {
  const RobotMinimum minimum = scene_.minimum(pair_, tube(arrivingWith(-4.0), 0.05));
  const double nearest = 3.0 - farthest(-4.0) - 0.1;
  EXPECT_EQ(minimum.status, Status::Converged);
  EXPECT_LE(minimum.lower_bound, nearest);
  EXPECT_GE(minimum.lower_bound, nearest - kTolerance);
  EXPECT_NEAR(minimum.upper_bound, nearest, kTolerance);  // a corner of the tube
  ASSERT_EQ(minimum.state.size(), 2U);
  EXPECT_NEAR(3.0 + minimum.state[1] - minimum.state[0], nearest, 1e-6);
}

TEST_F(Carts, TubeTouchesBeforeTheSpline) {
  const RobotTimeOfContact contact = scene_.timeOfContact(pair_, tube(arrivingWith(-8.0), 0.05));
  const double first = timeOf(-8.0, 2.9);
  EXPECT_EQ(contact.status, Status::Converged);
  ASSERT_TRUE(contact.contact);
  EXPECT_LE(contact.t_free, first);
  EXPECT_NEAR(contact.t_contact, first, 1e-6);
  EXPECT_NEAR(3.0 + contact.state[1] - contact.state[0], 0.0, 2e-6);
}

TEST_F(Carts, ContactAtTheStartIsAtTimeZero) {
  MotionQuestion question;
  question.contact_distance = 3.5;
  const RobotTimeOfContact contact = scene_.timeOfContact(pair_, exactly(arrivingWith(0.0)), question);
  ASSERT_TRUE(contact.contact);
  EXPECT_EQ(contact.t_contact, 0.0);
  EXPECT_EQ(contact.t_free, 0.0);
}

TEST_F(Carts, DeadlineLeavesTheAnswerOpen) {
  MotionQuestion question;
  question.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  const RobotTimeOfContact contact = scene_.timeOfContact(pair_, exactly(arrivingWith(-8.0)), question);
  EXPECT_EQ(contact.status, Status::IterationLimit);
  EXPECT_FALSE(contact.contact);
  EXPECT_EQ(contact.t_free, 0.0);
  EXPECT_EQ(scene_.minimum(pair_, exactly(arrivingWith(-8.0)), question).status, Status::IterationLimit);
}

TEST_F(Carts, WrongTrackingErrorsAreNamed) {
  const auto error = [&](const std::vector<double>& errors) {
    return errorOf([&] { scene_.minimum(pair_, Motion(model_->robot, arrivingWith(0.0), errors)); });
  };
  EXPECT_EQ(error({0.1}), "there are 1 tracking errors for 2 joints");
  EXPECT_EQ(error({0.1, -0.1}), "the tracking error of joint 'right' is not a number from 0 on");
  EXPECT_EQ(error({0.1, std::numeric_limits<double>::quiet_NaN()}),
            "the tracking error of joint 'right' is not a number from 0 on");
}

// Without the flag, the search of this motion does not end within seconds.
TEST(AtAHighSpeed, TheFlagOfADeadlineEndsASearchThatIsUnderWay) {
  const std::shared_ptr<const SceneModel> model = modelOf(urdfOf(twoArms()));
  const RobotModel& robot = model->robot;
  const Positions zero(robot.joints.size(), 0.0), high(robot.joints.size(), 1e4);
  const SplineSegment fast(robot, {0.0, zero, high}, {1.0, zero, high});
  for (const double error : {0.0, 0.01}) {
    std::atomic<bool> stop{false};
    MotionQuestion question;
    question.deadline = Deadline(stop);
    std::thread later([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      stop = true;
    });
    const Motion motion(robot, fast, std::vector<double>(robot.joints.size(), error));
    const RobotMinimum minimum = MotionSearch(model).minimum(Candidates(model->pairs), motion, question);
    later.join();
    EXPECT_EQ(minimum.status, Status::IterationLimit);
    EXPECT_LE(minimum.lower_bound, minimum.upper_bound);
  }
}

// --- random splines

// The tip goes along y = 4 t - 4 t^2 with x = 4 t. The straight way passes sixty balls below, and the spline sixty others,
// of which the straight way stays far away.
TEST(AmongFixedObjects, TheSplineFindsThoseThatTheStraightWayDoesNotPass) {
  using namespace narrowphase;
  const std::shared_ptr<const SceneModel> model =
      modelOf(urdfOf(link("rail") + link("cart") +
                     link("tip", "<collision><geometry><sphere radius=\"0.05\"/></geometry></collision>") +
                     slider("x", "rail", "cart", "1 0 0") + slider("y", "cart", "tip", "0 1 0")));
  const Objects none(model);
  std::vector<ObjectChange> changes;
  for (int i = 0; i < 60; ++i)
    for (const bool is_below : {true, false})
      changes.emplace_back(
          AddObject{makeObject((is_below ? "below" : "above") + std::to_string(i), {{Shape(Sphere{0.05})}},
                               Fixed{is_below ? at(2.0 + 0.002 * i, -0.3, 0.0) : at(1.2, 1.2, 0.002 * i)})});
  const auto objects = std::make_shared<const Objects>(none.changed(changes));
  MotionSearch scene(model);
  scene.use(objects);
  const RobotModel& robot = model->robot;
  const SplineSegment segment(robot, {0.0, byJoint(robot, {}), byJoint(robot, {{"x", 4.0}, {"y", 4.0}})},
                              {1.0, byJoint(robot, {{"x", 4.0}}), byJoint(robot, {{"x", 4.0}, {"y", -4.0}})});
  double truth = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= 100000; ++i) {
    const double t = i / 100000.0;
    truth = std::min(truth, std::hypot(4.0 * t - 1.2, 4.0 * t - 4.0 * t * t - 1.2) - 0.1);
  }
  ASSERT_LT(truth, 0.3);
  const Candidates all(model->pairs);
  const RobotMinimum minimum = scene.minimum(all, Motion(robot, segment));
  EXPECT_EQ(minimum.status, Status::Converged);
  EXPECT_LE(minimum.lower_bound, truth);
  EXPECT_NEAR(minimum.upper_bound, truth, 1e-6);
}

/// A segment between random states with random velocities and accelerations.
SplineSegment randomSegment(const RobotModel& robot, Chance& chance) {
  const auto point = [&](double time) {
    TrajectoryPoint made{time, randomPositions(robot, chance), {}, {}};
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      made.velocities.push_back(chance.between(-2.0, 2.0));
      made.accelerations.push_back(chance.between(-8.0, 8.0));
    }
    return made;
  };
  TrajectoryPoint from = point(0.0), to = point(1.0);
  for (std::size_t i = 0; i < robot.joints.size(); ++i)
    to.positions[i] = from.positions[i] + 0.3 * (to.positions[i] - from.positions[i]);
  return {robot, from, to};
}

struct Counts {
  int contacts = 0, free = 0, tubes_that_may_touch = 0;
};

/// Compares the answers about random splines with many states of them.
Counts compareWithStates(const std::shared_ptr<const SceneModel>& model, const std::shared_ptr<const Objects>& objects,
                         double error, int count, unsigned seed) {
  const RobotModel& robot = model->robot;
  Chance chance(seed);
  MotionSearch splines(model);
  PosedScene states(model);
  if (objects) {
    splines.use(objects);
    states.use(objects);
  }
  const auto motionAlong = [&](const SplineSegment& segment, double tracking_error) {
    Motion motion(robot, segment, std::vector<double>(robot.joints.size(), tracking_error));
    if (objects) motion.carryObjects(framesOnLinks(*objects));
    return motion;
  };
  const auto distanceAt = [&](const Positions& positions) {
    const BodyPoses poses = forwardKinematics(robot, positions);
    setPoses(states.state, poses);
    return states.minimum(states.candidates())->result.distance;
  };
  Counts counts;
  for (int i = 0; i < count; ++i) {
    const SplineSegment segment = randomSegment(robot, chance);
    const Motion motion = motionAlong(segment, error);
    const RobotMinimum minimum = splines.minimum(states.candidates(), motion);
    const RobotTimeOfContact contact = splines.timeOfContact(states.candidates(), motion);
    EXPECT_EQ(minimum.status, Status::Converged);
    EXPECT_NEAR(distanceAt(minimum.state), minimum.upper_bound, 1e-7);
    if (error == 0.0) {
      EXPECT_LE(minimum.upper_bound - minimum.lower_bound, kTolerance);
    }
    if (contact.contact) {
      EXPECT_LE(distanceAt(contact.state), kTolerance + 1e-9);
    }
    EXPECT_TRUE(contact.contact || contact.t_free == 1.0 || (error > 0.0 && contact.status == Status::Degenerate));
    if (minimum.lower_bound > kTolerance) {
      EXPECT_EQ(contact.t_free, 1.0);
    }
    if (error > 0.0) {  // the spline itself is in its tube
      const RobotTimeOfContact own = splines.timeOfContact(states.candidates(), motionAlong(segment, 0.0));
      // Within the tolerance of the distance, the two may find different times where the spline grazes.
      const double found = contact.contact ? contact.t_contact : 1.0;
      if (own.contact && found > own.t_contact) {
        const Motion between = motionAlong(segment.between(own.t_contact, found), 0.0);
        EXPECT_GE(splines.minimum(states.candidates(), between).upper_bound, -kTolerance) << "spline " << i;
      }
    }
    counts.contacts += contact.contact;
    counts.free += contact.t_free == 1.0;
    counts.tubes_that_may_touch += contact.status == Status::Degenerate;
    for (int k = 0; k <= 300; ++k) {
      const double time = k / 300.0;
      Positions positions = segment.at(time);
      for (double& position : positions)
        position += error * (chance.happens(0.7) ? chance.eitherSign(1.0) : chance.between(-1.0, 1.0));
      const double distance = distanceAt(positions);
      EXPECT_GE(distance, minimum.lower_bound - 1e-9) << "spline " << i << " at " << time;
      EXPECT_TRUE(distance > -1e-9 || time >= contact.t_free) << "spline " << i << " at " << time;
    }
  }
  return counts;
}

TEST(RandomSplines, AgreeWithTheirStates) {
  const Counts counts = compareWithStates(modelOf(urdfOf(twoArms())), nullptr, 0.0, repeats(60), 3);
  if (!kIsSanitized) {
    EXPECT_GT(counts.contacts, 15);
    EXPECT_GT(counts.free, 15);
  }
}

// Splines for which the narrowphase is asked are left out: its questions about motions allocate memory.
TEST(RandomSplines, ThoseThatBoundsSettleNeedNoNewMemoryTheSecondTime) {
  if (kIsSanitized) GTEST_SKIP() << "a sanitizer allocates";
  const std::shared_ptr<const SceneModel> model = modelOf(urdfOf(twoArms()));
  const Candidates candidates(model->pairs);
  MotionSearch search(model);
  Chance chance(12);
  int free = 0;
  for (int i = 0; i < 60; ++i) {
    const Motion motion(model->robot, randomSegment(model->robot, chance).between(0.5, 0.51),
                        std::vector<double>(model->robot.joints.size(), 1e-3));
    const RobotTimeOfContact first = search.timeOfContact(candidates, motion);
    if (first.t_free < 1.0 || first.counts.queries > 0) continue;
    const long before = allocations();
    search.timeOfContact(candidates, motion);
    EXPECT_EQ(allocations(), before) << "spline " << i;
    ++free;
  }
  EXPECT_GT(free, 10);
}

TEST(RandomSplines, TubesContainTheirStates) {
  const Counts counts = compareWithStates(modelOf(urdfOf(twoArms())), nullptr, 0.03, repeats(60), 4);
  if (!kIsSanitized) {
    EXPECT_GT(counts.contacts, 15);
    EXPECT_GT(counts.free, 5);
  }
}

// Two boxes and a table that rest, a ball in the hand, and one that moves with the frame of the forearm.
TEST(RandomSplines, AmongObjectsAgreeWithTheirStates) {
  using namespace narrowphase;
  const std::shared_ptr<const SceneModel> model = arm();
  const Objects none(model);
  const auto objects = std::make_shared<const Objects>(none.changed({
      AddObject{makeObject("box", {{Shape(Box{{0.2, 0.2, 0.2}})}}, Fixed{at(0.6, 0.2, 0.6)})},
      AddObject{makeObject("post", {{Shape(Box{{0.1, 0.1, 2.0}})}}, Fixed{at(-0.7, 0.3, 0.0)})},
      AddObject{makeObject("table", {{HalfSpace{{0, 0, 1}}}}, Fixed{at(0.0, 0.0, -0.3)})},
      AddObject{makeObject("held", {{Shape(Sphere{0.05})}}, Attached{"hand", {}, at(0.0, 0.0, 0.35)})},
      AddObject{makeObject("carried", {{Shape(Sphere{0.05})}}, Moving{"fore", at(0.3, 0.0, 0.1)})},
  }));
  const Counts exact = compareWithStates(model, objects, 0.0, repeats(40), 7);
  compareWithStates(model, objects, 0.02, repeats(40), 8);
  if (!kIsSanitized) {
    EXPECT_GT(exact.contacts, 8);
    EXPECT_GT(exact.free, 8);
  }
}

// More fixed objects below a node of their tree than are listed one by one, and a few that matter.
TEST(RandomSplines, AmongManyObjectsAgreeWithTheirStates) {
  using namespace narrowphase;
  const std::shared_ptr<const SceneModel> model = arm();
  const Objects none(model);
  Chance chance(9);
  std::vector<ObjectChange> changes;
  for (int i = 0; i < 300; ++i) {
    const double x = chance.between(-1.2, 1.2), y = chance.between(-1.2, 1.2), z = chance.between(-1.0, 1.6);
    if (std::hypot(x, y) > 0.45 || i % 30 == 0)
      changes.emplace_back(
          AddObject{makeObject("ball" + std::to_string(i), {{Shape(Sphere{0.01})}}, Fixed{at(x, y, z)})});
  }
  const auto objects = std::make_shared<const Objects>(none.changed(changes));
  const Counts exact = compareWithStates(model, objects, 0.0, repeats(15), 10);
  compareWithStates(model, objects, 0.01, repeats(10), 11);
  if (!kIsSanitized) {
    EXPECT_GT(exact.contacts, 3);
    EXPECT_GT(exact.free, 2);
  }
}

TEST(RandomSplines, OfPandaAgreeWithTheirStates) {
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) GTEST_SKIP() << kExampleRobotsMissing;
  const std::shared_ptr<const SceneModel> panda = modelOf(kExampleRobots[0], resolve, quickLoading());
  compareWithStates(panda, nullptr, 0.0, repeats(30), 5);
  compareWithStates(panda, nullptr, 0.01, repeats(30), 6);
}

}  // namespace proximity_server::scene::spline_motion_test
