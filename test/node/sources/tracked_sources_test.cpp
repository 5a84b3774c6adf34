// The objects of tracked sources, without topics: their ages, their place among other objects, and their thresholds.
#include "node/monitor/slider_robot.h"
#include "node/object_messages.h"
#include "node/objects/object_keeper.h"
#include "node/objects/object_store.h"
#include "node/sources/tracked_ages.h"
#include "scene/files.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace proximity_server::node::tracked_sources_test {

using Eigen::Vector3d;
using scene::errorOf;

TrackedSource sourceNamed(const std::string& name) {
  TrackedSource source;
  source.name = name;
  source.topic = "/seen/" + name;
  source.radius = 0.2;
  return source;
}

Config tracking(const std::vector<std::string>& names) {
  Config config;
  for (const std::string& name : names) config.tracked.push_back(sourceNamed(name));
  return config;
}

std::shared_ptr<const Robot> robotWith(const Config& config) {
  return std::make_shared<const Robot>(kSliders, "", config);
}

// ---- Ages. max_age is 0.5 s.

class AgesOfTwo : public testing::Test {
 protected:
  AgesOfTwo() { ages_.follow(*robotWith(tracking({"people", "cart"}))); }

  static ros::Time at(double seconds) { return ros::Time(1000.0 + seconds); }
  std::string statusAt(double seconds) const {
    const QueryStatus status = ages_.status(at(seconds));
    EXPECT_EQ(status.code == QueryStatus::OK, status.message.empty());
    return status.message;
  }
  std::string refusal(double stamp, double now) { return ages_.refusalOf("people", at(stamp), at(now)); }

  TrackedAges ages_;
};

TEST_F(AgesOfTwo, AreThoseOfTheFirstSourceThatIsStale) {
  EXPECT_EQ(statusAt(0.0), "tracked source 'people' on '/seen/people': no message yet");
  EXPECT_EQ(ages_.status(at(0.0)).code, QueryStatus::TF_STALE);
  ages_.accept("people", at(0.0));
  EXPECT_EQ(statusAt(0.0), "tracked source 'cart' on '/seen/cart': no message yet");
  ages_.accept("cart", at(0.25));
  EXPECT_EQ(statusAt(0.5), "");
  EXPECT_EQ(statusAt(0.625),
            "tracked source 'people' on '/seen/people': its latest message is 0.625 s old, max_age is 0.5 s");
  ages_.accept("people", at(0.625));
  EXPECT_EQ(statusAt(0.75), "");
  EXPECT_EQ(statusAt(1.0), "tracked source 'cart' on '/seen/cart': its latest message is 0.75 s old, max_age is 0.5 s");
}

TEST_F(AgesOfTwo, AreOverAtOnceAfterAMessageThatSaysNothing) {
  for (const char* name : {"people", "cart"}) ages_.accept(name, at(0.0));
  ages_.refuse("people", "it has more than 1000 points", /*is_stale=*/true);
  EXPECT_EQ(statusAt(0.125),
            "tracked source 'people' on '/seen/people': a message is left out: it has more than 1000 points");
  ages_.accept("people", at(0.125));
  EXPECT_EQ(statusAt(0.25), "");
}

TEST_F(AgesOfTwo, GoOnAfterAMessageWithoutTransforms) {
  for (const char* name : {"people", "cart"}) ages_.accept(name, at(0.0));
  ages_.refuse("people", "no frame", /*is_stale=*/false);
  EXPECT_EQ(statusAt(0.5), "");
  EXPECT_EQ(statusAt(0.625),
            "tracked source 'people' on '/seen/people': its latest message is 0.625 s old, max_age is 0.5 s; a message "
            "is left out: no frame");
}

TEST_F(AgesOfTwo, RefuseMessagesOfAnotherTime) {
  EXPECT_EQ(refusal(0.0, 0.5), "");
  EXPECT_EQ(refusal(0.0, 0.75), "it is 0.75 s old, max_age is 0.5 s");
  EXPECT_EQ(refusal(0.5, 0.0), "") << "ahead of the clock by max_age";
  EXPECT_EQ(refusal(0.75, 0.0), "its stamp is 0.75 s ahead of the clock");
  ages_.accept("people", at(0.25));
  EXPECT_EQ(refusal(0.125, 0.25), "its stamp is 0.125 s before that of the message before it");
  EXPECT_EQ(refusal(0.25, 0.25), "");
  EXPECT_NE(ages_.refusalOf("people", ros::Time(), at(0.0)), "") << "without a stamp";
}

TEST_F(AgesOfTwo, BeginAnewAfterAJumpOfTheClock) {
  for (const char* name : {"people", "cart"}) ages_.accept(name, at(0.0));
  EXPECT_EQ(statusAt(-0.75),
            "tracked source 'people' on '/seen/people': its latest message is 0.75 s ahead of the clock");
  EXPECT_EQ(refusal(-0.75, -0.75), "");
}

TEST_F(AgesOfTwo, CountAfterAReloadOnlyForTheSameSourcesInTheSameFrame) {
  for (const char* name : {"people", "cart"}) ages_.accept(name, at(0.0));
  Config config = tracking({"people", "cart"});
  ages_.follow(*robotWith(config));
  EXPECT_EQ(statusAt(0.0), "");
  config.reference_frame = "map";
  ages_.follow(*robotWith(config));
  EXPECT_NE(statusAt(0.0), "");
  for (const char* name : {"people", "cart"}) ages_.accept(name, at(0.0));
  config.tracked[1].radius = 0.25;
  ages_.follow(*robotWith(config));
  EXPECT_NE(statusAt(0.0), "");
  ages_.follow(*robotWith(Config()));
  EXPECT_EQ(statusAt(9.0), "") << "no sources";
}

// ---- Objects

class TrackedObjects : public testing::Test {
 protected:
  void track(const std::string& name, const std::vector<Vector3d>& points) {
    store_.track(store_.current().robot, sourceNamed(name), ballsAround(points, 0.2), [this] { ++placed_; });
  }
  std::string refusal(const ObjectChange& change) {
    return errorOf([&] { store_.apply(messageOf({change})); });
  }
  std::vector<std::string> ids() const {
    std::vector<std::string> ids;
    const RobotObjects now = store_.current().objects;
    for (const int number : now.all->numbers()) ids.push_back(now.all->object(number)->id);
    return ids;
  }
  using Ids = std::vector<std::string>;

  std::shared_ptr<const Robot> robot_ = robotWith(tracking({"people", "cart"}));
  int placed_ = 0, changes_ = 0;
  ObjectStore store_{robot_, 7, {}, [this](const Robot&) { ++changes_; }};
};

TEST_F(TrackedObjects, AreBallsAroundThePointsUntilNobodyIsThere) {
  track("people", {{1.0, 2.0, 0.0}, {3.0, 2.0, 0.0}});
  EXPECT_EQ(ids(), Ids{"people"});
  const auto objects = robot_->objects().get().all;
  const scene::Object& people = *objects->object(objects->find("people"));
  const Eigen::Isometry3d& pose = std::get<scene::Fixed>(people.placement).world_T_object;
  const std::vector<scene::ObjectShape>& shapes = scene::givenShapesOf(people);
  ASSERT_EQ(shapes.size(), 2U);
  EXPECT_EQ(Vector3d(pose * shapes[0].object_T_shape.translation()), Vector3d(1.0, 2.0, 0.0));
  EXPECT_EQ(Vector3d(pose * shapes[1].object_T_shape.translation()), Vector3d(3.0, 2.0, 0.0));
  EXPECT_EQ(scene::piecesOf(people)[0].shape.margin(), 0.2);
  track("people", {{0.0, 0.0, 5.0}});
  EXPECT_EQ(scene::givenShapesOf(*robot_->objects().get().all->object(0)).size(), 1U);
  track("people", {});
  EXPECT_EQ(ids(), Ids{});
  track("people", {});
  EXPECT_EQ(placed_, 4);
  EXPECT_EQ(changes_, 3) << "the last one changes nothing";
}

TEST_F(TrackedObjects, AreNoObjectsOfClients) {
  track("people", {{1.0, 2.0, 0.0}});
  for (const ObjectChange& refused :
       {addBall("people"), change(ObjectChange::REMOVE, "people"), moveTo("people", poseAt(9.0, 0.0, 0.0)),
        attach("people", "left"), addBall("cart")}) {
    const std::string id = refused.id;
    EXPECT_EQ(refusal(refused), "changes[0]: object \"" + id +
                                    "\": id: it is a tracked source: only messages on '/seen/" + id + "' change it");
  }
  EXPECT_EQ(refusal(addBall("box")), "");
  EXPECT_EQ(ids(), (Ids{"box", "people"}));
  EXPECT_EQ(refusal(change(ObjectChange::REMOVE, "*")), "");
  EXPECT_EQ(ids(), Ids{"people"});
}

TEST_F(TrackedObjects, AreInNoListAndNoFile) {
  store_.apply(messageOf({addBall("box")}));
  track("people", {{1.0, 2.0, 0.0}});
  EXPECT_EQ(store_.current().objects.revision, 2U);
  EXPECT_EQ(store_.revision(), 1U) << "that of the list";
  EXPECT_EQ(store_.list().revision, 1U);
  ASSERT_EQ(store_.list().objects.size(), 1U);
  EXPECT_EQ(store_.list().objects[0].id, "box");
  const ObjectStore::Snapshot kept = store_.snapshot();
  EXPECT_EQ(kept.revision, 1U);
  ASSERT_EQ(kept.file.objects.size(), 1U);
  EXPECT_EQ(kept.file.objects[0].id, "box");
  EXPECT_EQ(ObjectStore::fileOf(store_.current()).objects.size(), 2U) << "a record has all";
  EXPECT_EQ(store_.apply(messageOf({addBall("more")})), 3U);
  EXPECT_EQ(store_.list().revision, 3U);
}

TEST_F(TrackedObjects, OfAFileAreRefused) {
  Config config = tracking({"people"});
  config.objects.objects.emplace_back();
  config.objects.objects.back().id = "people";
  config.objects.objects.back().source = "objects[0]";
  EXPECT_EQ(errorOf([&] { objectsAtStart(config); }),
            "objects[0]: id: it is a tracked source, see the parameter tracked");
}

TEST_F(TrackedObjects, StayAtAReloadThatKeepsTheSource) {
  track("people", {{1.0, 2.0, 0.0}});
  track("cart", {{4.0, 2.0, 0.0}});
  const auto nothing = [] {};
  store_.follow(robotWith(tracking({"people"})), nothing);
  EXPECT_EQ(ids(), Ids{"people"});
  store_.track(robot_, sourceNamed("people"), {}, [this] { ++placed_; });
  EXPECT_EQ(ids(), Ids{"people"}) << "a message that was transformed for the robot before";
  EXPECT_EQ(placed_, 2);
  Config elsewhere = tracking({"people"});
  elsewhere.reference_frame = "map";
  store_.follow(robotWith(elsewhere), nothing);
  EXPECT_EQ(ids(), Ids{}) << "the next message places it";
}

TEST_F(TrackedObjects, DoNotTakeTheIdOfAnotherObjectAtAReload) {
  store_.apply(messageOf({addBall("guest")}));
  EXPECT_EQ(errorOf([&] { store_.follow(robotWith(tracking({"guest"})), [] {}); }),
            "object \"guest\": a tracked source has its id: remove it first");
}

TEST_F(TrackedObjects, AreNotMadeAnewOfTheSameBoxes) {
  const auto see = [&](double height) {
    const Eigen::AlignedBox3d box(Vector3d(0.0, 2.0, 0.0), Vector3d(0.1, 2.1, height));
    store_.track(robot_, sourceNamed("people"), {{{scene::Boxes{{box}}}}, Eigen::Isometry3d::Identity()},
                 [this] { ++placed_; });
    return robot_->objects().get().revision;
  };
  const std::uint64_t first = see(0.1);
  EXPECT_EQ(see(0.1), first);
  EXPECT_EQ(see(0.2), first + 1);
  EXPECT_EQ(see(0.2), first + 1);
  EXPECT_EQ(placed_, 4) << "they are seen";
}

TEST(TrackedSourceNamedAsALink, IsRefused) {
  EXPECT_EQ(errorOf([] {
              robotWith(tracking({"people", "left"}));
            }),
            "parameter tracked: name is \"left\", that of a link");
}

// ---- Thresholds. The ball of the person is 0.2 m around its point, that of each slider 0.1 m.

class MonitorOfPeople : public MonitorOfSliders {
 protected:
  MonitorOfPeople() {
    config_ = tracking({"people"});
    follow("");
    store_ = std::make_unique<ObjectStore>(robot_, 7, FindFrame());
  }
  /// The level with a person beside the right sphere, so far from its surface [m].
  const Clearance& withAPersonAt(double distance) {
    store_->track(robot_, config_.tracked[0], ballsAround({{0.5, 0.3 + distance, 0.0}}, 0.2), [] {});
    return cycleWithPresentObjects();
  }
  const Clearance& cycleWithPresentObjects() {
    MonitoredObjects objects(*robot_, robot_->objects().get());
    monitor_.use(objects);
    return cycle();
  }

  std::unique_ptr<ObjectStore> store_;
};

TEST_F(MonitorOfPeople, HasTheThresholdsOfTrackedSources) {
  EXPECT_EQ(withAPersonAt(0.55).level, Clearance::CLEAR);
  EXPECT_EQ(withAPersonAt(0.45).level, Clearance::WARN);
  EXPECT_EQ(monitor_.latest().deciding_threshold, 0.5);
  EXPECT_EQ(withAPersonAt(0.15).level, Clearance::STOP);
  EXPECT_EQ(monitor_.latest().deciding_threshold, 0.2);
  EXPECT_EQ(monitor_.latest().deciding.b.link, "people");
  settings_.tracked_stop_distance = 0.1;
  settings_.tracked_warn_distance = 0.12;
  EXPECT_EQ(cycle().level, Clearance::CLEAR) << "with the settings of the cycle";
}

TEST_F(MonitorOfPeople, GivesThemToNoOtherObjectThatGetsTheNumber) {
  EXPECT_EQ(withAPersonAt(0.15).level, Clearance::STOP);
  store_->track(robot_, config_.tracked[0], {}, [] {});
  store_->apply(messageOf({addBall("box", poseAt(0.5, 0.35, 0.0))}));
  EXPECT_EQ(cycleWithPresentObjects().level, Clearance::CLEAR);
  EXPECT_EQ(robot_->objects().get().all->find("box"), 0);
  EXPECT_EQ(robot_->thresholdsWith(*robot_->objects().get().all).stop.range(scene::PairKind::WithObject).largest, 0.02);
}

TEST_F(MonitorOfPeople, HasNoRowsIfTheInfluenceDoesNotReachThem) {
  store_->track(robot_, config_.tracked[0], ballsAround({{1.1, 0.0, 0.0}}, 0.2),
                [] {});  // in the way of the right sphere, 0.3 m off
  cycleWithPresentObjects();
  const ConstraintRows& rows = monitor_.constraints(snapshot(), settings_);
  EXPECT_EQ(rows.status.message, "influence_distance is 0.1, not above tracked_stop_distance, which is 0.2");
  settings_.influence_distance = 0.4;
  cycle();
  const ConstraintRows& near = monitor_.constraints(snapshot(), settings_);
  EXPECT_EQ(near.status.code, QueryStatus::OK) << near.status.message;
  ASSERT_FALSE(near.b.empty());
  EXPECT_EQ(near.b[0].link, "people");
}

TEST_F(MonitorOfPeople, GivesThemToServices) {
  withAPersonAt(0.3);
  const auto objects = robot_->objects().get().all;
  const scene::ShapeRef people = scene::ShapeRef::ofObject(objects->find("people"));
  EXPECT_EQ(robot_->thresholdsWith(*objects).stop.of({{0}, people}), 0.2);
  settings_.tracked_stop_distance = 0.25;
  robot_->useDefaults(settings_);
  EXPECT_EQ(robot_->thresholdsWith(*objects).stop.of({{0}, people}), 0.25);
  EXPECT_EQ(robot_->thresholdsWith(*objects).warn.of({{0}, people}), 0.5);
}

/// The same with a sensed source, and a debounce of 0.3 s.
class MonitorOfACamera : public MonitorOfPeople {
 protected:
  MonitorOfACamera() {
    config_.tracked[0].sensing.emplace();
    config_.monitor.sensed_debounce = settings_.sensed_debounce = 0.3;
    follow("");
    store_ = std::make_unique<ObjectStore>(robot_, 7, FindFrame());
  }
  Clearance::_level_type levelAt(double distance, double time) {
    store_->track(robot_, config_.tracked[0], ballsAround({{0.5, 0.3 + distance, 0.0}}, 0.2), [] {});
    MonitoredObjects objects(*robot_, robot_->objects().get());
    monitor_.use(objects);
    PoseSnapshot now = snapshot();
    now.stamp.fromSec(time);
    return monitor_.cycle(now, {}, settings_).level;
  }
};

TEST_F(MonitorOfACamera, HoldsALevelBackUntilItHasLasted) {
  EXPECT_EQ(levelAt(0.5, 1.0), Clearance::CLEAR);
  EXPECT_EQ(levelAt(0.15, 1.1), Clearance::CLEAR) << "WARN since now";
  EXPECT_NEAR(monitor_.latest().minimum.distance, 0.15, 1e-9) << "the minimum tells it at once";
  EXPECT_EQ(levelAt(0.05, 1.3), Clearance::CLEAR) << "STOP since now";
  EXPECT_EQ(levelAt(0.05, 1.41), Clearance::WARN);
  EXPECT_EQ(levelAt(0.05, 1.59), Clearance::WARN);
  EXPECT_EQ(levelAt(0.05, 1.61), Clearance::STOP);
  EXPECT_EQ(levelAt(0.15, 1.7), Clearance::WARN) << "better at once";
  EXPECT_EQ(levelAt(0.05, 1.8), Clearance::WARN) << "STOP begins anew";
}

TEST_F(MonitorOfACamera, HoldsBackNoContactAndNoOtherPair) {
  EXPECT_EQ(levelAt(-0.01, 1.0), Clearance::COLLISION);
  EXPECT_EQ(levelAt(0.5, 2.0), Clearance::CLEAR);
  store_->apply(messageOf({addBall("box", poseAt(0.5, 0.35, 0.0))}));
  settings_.object_stop_distance = settings_.object_warn_distance = 0.2;
  EXPECT_EQ(levelAt(0.5, 2.1), Clearance::STOP);
  EXPECT_EQ(levelAt(0.05, 3.0), Clearance::STOP);
}

}  // namespace proximity_server::node::tracked_sources_test
