// A cycle of the monitor allocates nothing besides what tf2 takes within its own functions.
#include <proximity_server/Clearance.h>
#include "allocations.h"
#include "from_environment.h"
#include "heap_in_use.h"
#include "node/gantry.h"
#include "node/monitor/monitor.h"
#include "node/record/recorder.h"
#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"

#include <tf2/buffer_core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <limits>

namespace proximity_server::node::monitor_memory_test {

using namespace narrowphase;
using namespace scene;

const std::string kLongName = "_with_a_name_that_no_string_holds_in_itself";
constexpr int kTfRemembers = 1000;  // cycles: 10 s
constexpr int kBatch = 20;          // cycles whose transforms come at once
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
using Transforms = std::array<geometry_msgs::TransformStamped, 3>;

ros::Time stampOf(std::int64_t cycle) { return ros::Time(1000.0 + 0.01 * static_cast<double>(cycle)); }

/// The URDF of the gantry with long names. The ball overlaps with the base at times, and is beyond the threshold at
/// others.
Transforms transformsOf(std::int64_t cycle) {
  const double phase = 0.05 * static_cast<double>(cycle);
  const GantryPosition position{0.6 + 0.6 * std::cos(phase), 0.5 * std::sin(0.3 * phase), 0.2 * std::cos(0.7 * phase)};
  Transforms transforms = {Gantry::slide(position), Gantry::ball(position), Gantry::post(position)};
  for (geometry_msgs::TransformStamped& transform : transforms) {
    transform.header.stamp = stampOf(cycle);
    transform.header.frame_id += kLongName;
    transform.child_frame_id += kLongName;
  }
  return transforms;
}

/// By tf2, to look up the joints once at a stamp, or at their latest if it is 0.
long allocationsOfTf2(const ros::Time& stamp) {
  tf2::BufferCore buffer;
  for (const std::int64_t cycle : {1, 2}) {
    for (const geometry_msgs::TransformStamped& transform : transformsOf(cycle)) buffer.setTransform(transform, "test");
  }
  const Transforms wanted = transformsOf(1);
  const long before = allocations();
  for (const geometry_msgs::TransformStamped& transform : wanted) {
    buffer.lookupTransform(transform.header.frame_id, transform.child_frame_id, stamp);
  }
  return allocations() - before;
}

/// A ball that stands beside the way of the gantry's ball, and one that the gantry's ball carries.
void addObjects(const Robot& robot, double x) {
  const auto ball = [](const std::string& id, const scene::Placement& placement) {
    return scene::AddObject{scene::makeObject(id + kLongName, {{Shape(Sphere{0.1})}}, placement)};
  };
  const Eigen::Isometry3d beside(Eigen::Translation3d(x, 0.0, 0.0)), below(Eigen::Translation3d(0.0, 0.0, -0.3));
  const scene::Objects none(robot.sharedModel());
  const scene::Objects both = none.changed(
      {ball("standing", scene::Fixed{beside}), ball("carried", scene::Attached{"ball" + kLongName, {}, below})});
  robot.objects().set({std::make_shared<const scene::Objects>(both), 1});
}

std::shared_ptr<const Robot> gantryWithLongNames(Config config) {
  std::string urdf;
  ros::param::get("/robot_description", urdf);
  for (const std::string name : {"base", "slide", "ball", "post", "block", "x_axis", "y_axis", "lift"}) {
    const std::string quoted = '"' + name + '"';
    for (std::size_t at = urdf.find(quoted); at != std::string::npos; at = urdf.find(quoted, at + 1)) {
      urdf.insert(at + 1 + name.size(), kLongName);
    }
  }
  ros::param::set("/gantry_with_long_names", urdf);
  config.robot_description = "/gantry_with_long_names";
  config.max_tf_age = 1.0;
  config.joint_inequalities =
      scene::readYaml("- x_axis" + kLongName + " <= 0.6\n- 2*lift" + kLongName + " + x_axis" + kLongName + " <= 5", "");
  return std::make_shared<const Robot>(ros::NodeHandle(), config);
}

/// Nothing is known exactly, and the poses are old.
Config uncertain() {
  Config config;
  config.uncertainty.joint = {1e-3};
  config.uncertainty.joint_frame = {1e-3};
  config.uncertainty.object = {1e-3};
  config.pose_latency = PoseLatency::Limit;
  return config;
}

/// Does in this process what the node does in each cycle. Every cycle has poses of its own: the last one of a batch
/// those of the latest transforms, as in the node, the others those of their stamp.
class MonitoredGantry {
 public:
  enum class With : unsigned char { LinksOnly, Objects, ObjectsAndAController, ObjectsAndUncertainty };
  explicit MonitoredGantry(With with = With::LinksOnly)
      : has_controller_(with == With::ObjectsAndAController),
        robot_(gantryWithLongNames(with == With::ObjectsAndUncertainty ? uncertain() : Config())) {
    if (with != With::LinksOnly) addObjects(*robot_, 0.5);
    monitor_.follow(robot_);
    endTimeAfter(kNever);  // not by the clock, which ends it in other cycles each time
    settings_.threshold = 0.5;
    settings_.gradients = has_controller_;
    settings_.influence_distance = 0.5;
    settings_.max_constraints = 2;
  }

  void endTimeAfter(std::int64_t steps) { monitor_.endTimeAfter(steps); }

  const Clearance& cycle() {
    const bool is_new = cycles_ % kBatch == 0;  // then the latest transforms are looked up, once for the batch
    if (is_new) addBatch();
    ++cycles_;
    const bool is_latest = cycles_ % kBatch == 0;
    const long before = allocations();
    const PoseSnapshot& snapshot = tf_.lookUp(lookup_, is_latest ? ros::Time() : stampOf(cycles_));
    const Clearance& clearance = monitor_.cycle(snapshot, {}, settings_);
    recorder_.add(*robot_, snapshot, {}, clearance, settings_);
    if (has_controller_) rows_in_use_ = usedRows(monitor_.constraints(snapshot, settings_));
    allocations_ += allocations() - before - (is_new ? of_the_latest_ : 0) - (is_latest ? 0 : at_a_stamp_);
    return clearance;
  }

  /// The standing ball stands at x from now on.
  void moveObject(double x) {
    addObjects(*robot_, x);
    MonitoredObjects objects(*robot_, robot_->objects().get());
    monitor_.use(objects);
  }

  /// The constraints of the latest cycle, if there is a controller.
  int rowsInUse() const { return rows_in_use_; }

  /// The allocations of all cycles so far, without those of tf2.
  long allocationsOfCycles() const { return allocations_; }

 private:
  static int usedRows(const proximity_server::ConstraintRows& rows) {
    return static_cast<int>(std::count_if(rows.lower_bounds.begin(), rows.lower_bounds.end(),
                                          [](double bound) { return std::isfinite(bound); }));
  }

  void addBatch() {
    tf2_msgs::TFMessage message;
    for (std::int64_t cycle = cycles_ + 1; cycle <= cycles_ + kBatch; ++cycle) {
      const Transforms transforms = transformsOf(cycle);
      message.transforms.insert(message.transforms.end(), transforms.begin(), transforms.end());
    }
    ros::Time::setNow(stampOf(cycles_ + kBatch));
    tf_.add(message, TfTree::Kind::Moving, "/robot");
  }

  const bool has_controller_;
  int rows_in_use_ = 0;
  std::int64_t cycles_ = 0;
  long allocations_ = 0;
  const long of_the_latest_ = allocationsOfTf2(ros::Time()), at_a_stamp_ = allocationsOfTf2(stampOf(1));
  const std::shared_ptr<const Robot> robot_;
  TfPoses tf_;
  Monitor monitor_;
  MonitorSettings settings_;
  Recorder recorder_{Config(), "/memory_test"};
  TfLookup lookup_{*robot_, {0, 1, 2}};
};

/// The least over as many cycles as tf remembers.
std::size_t heapThatStaysInUse(MonitoredGantry& gantry) {
  std::size_t least = heapInUse();
  for (int i = 0; i < kTfRemembers; ++i) {
    gantry.cycle();
    least = std::min(least, heapInUse());
  }
  return least;
}

TEST(MonitorMemory, CyclesOfAMovingRobotTakeNothingAndTheHeapStaysFlat) {
  const std::int64_t cycles = fromEnvironment("PROXIMITY_MONITOR_CYCLES", 20000);
  ASSERT_GT(allocationsOfTf2(ros::Time()), 0) << "the counter does not count";
  MonitoredGantry gantry;
  for (int i = 0; i < 3 * kTfRemembers; ++i) ASSERT_NE(gantry.cycle().level, Clearance::INVALID) << i;

  const long allocations_before = gantry.allocationsOfCycles();
  const std::size_t heap_before = heapThatStaysInUse(gantry);
  std::array<std::int64_t, 3> cycles_with_so_many_pairs{};
  std::array<std::int64_t, 4> cycles_of_level{};
  for (std::int64_t i = 0; i < cycles; ++i) {
    const Clearance& clearance = gantry.cycle();
    ASSERT_LT(clearance.level, Clearance::INVALID) << clearance.status.message;
    ASSERT_LE(clearance.below_threshold.size(), 2u);
    ++cycles_with_so_many_pairs[clearance.below_threshold.size()];
    ++cycles_of_level[clearance.level];
  }
  const std::size_t heap_after = heapThatStaysInUse(gantry);
  std::cout << cycles << " cycles: the heap went from " << heap_before << " to " << heap_after << " bytes" << std::endl;

  EXPECT_EQ(gantry.allocationsOfCycles(), allocations_before);
  // tf's history and roscpp's queues come in blocks of some hundred bytes; a byte in each cycle would be more.
  EXPECT_NEAR(static_cast<double>(heap_after), static_cast<double>(heap_before), 16384.0);
  for (const std::int64_t seen : cycles_with_so_many_pairs) EXPECT_GT(seen, cycles / 100);
  for (const std::int64_t seen : cycles_of_level) EXPECT_GT(seen, 0);
}

TEST(MonitorMemory, CyclesWithinAnUncertaintyTakeNothing) {
  MonitoredGantry gantry(MonitoredGantry::With::ObjectsAndUncertainty);
  const auto cycle = [&](int i) -> const Clearance& {
    gantry.endTimeAfter(i % 3 == 0 ? 0 : kNever);
    return gantry.cycle();
  };
  for (int i = 0; i < 3 * kTfRemembers; ++i) ASSERT_NE(cycle(i).level, Clearance::INVALID) << i;
  const long allocations_before = gantry.allocationsOfCycles();
  int reached = 0, over = 0;
  for (int i = 0; i < 2000; ++i) {
    const Clearance& clearance = cycle(i);
    ASSERT_TRUE(clearance.by_guaranteed);
    ASSERT_LT(clearance.deciding.guaranteed, clearance.deciding.lower_bound);
    reached += clearance.deciding_reached;
    over += !clearance.status.message.empty();
  }
  EXPECT_EQ(gantry.allocationsOfCycles(), allocations_before);
  EXPECT_GT(reached, 0);
  EXPECT_GT(over, 100);
}

TEST(MonitorMemory, CyclesWithObjectsTakeNothing) {
  MonitoredGantry gantry(MonitoredGantry::With::Objects);
  for (int i = 0; i < 3 * kTfRemembers; ++i) ASSERT_NE(gantry.cycle().level, Clearance::INVALID) << i;
  const long allocations_before = gantry.allocationsOfCycles();
  std::array<std::int64_t, 4> cycles_of_level{};
  int object_is_closest = 0;
  for (int i = 0; i < 2000; ++i) {
    const Clearance& clearance = gantry.cycle();
    ASSERT_LT(clearance.level, Clearance::INVALID) << clearance.status.message;
    ASSERT_NE(clearance.object_minimum.state, Proximity::UNKNOWN);
    ++cycles_of_level[clearance.level];
    object_is_closest += clearance.minimum.b.kind == proximity_server::ShapeRef::OBJECT;
  }
  EXPECT_EQ(gantry.allocationsOfCycles(), allocations_before);
  for (const std::int64_t seen : cycles_of_level) EXPECT_GT(seen, 0);
  EXPECT_GT(object_is_closest, 100);
  EXPECT_LT(object_is_closest, 1900);
}

TEST(MonitorMemory, CyclesWithGradientsAndConstraintsTakeNothing) {
  MonitoredGantry gantry(MonitoredGantry::With::ObjectsAndAController);
  for (int i = 0; i < 3 * kTfRemembers; ++i) ASSERT_NE(gantry.cycle().level, Clearance::INVALID) << i;
  const long allocations_before = gantry.allocationsOfCycles();
  std::array<int, 5> cycles_with_so_many_rows{};  // two of pairs, and two of inequalities
  for (int i = 0; i < 2000; ++i) {
    const Clearance& clearance = gantry.cycle();
    ASSERT_EQ(clearance.joint_names.size(), 3u);
    ASSERT_EQ(clearance.minimum.gradient.size(), 3u);
    ++cycles_with_so_many_rows[gantry.rowsInUse()];
  }
  EXPECT_EQ(gantry.allocationsOfCycles(), allocations_before);
  EXPECT_GT(cycles_with_so_many_rows[4], 100);
}

TEST(MonitorMemory, TheHeapStaysFlatWhileObjectsChange) {
  MonitoredGantry gantry(MonitoredGantry::With::Objects);
  const auto change = [&](int times) {
    for (int i = 0; i < times; ++i) {
      gantry.moveObject(0.5 + 0.001 * (i % 100));
      ASSERT_NE(gantry.cycle().level, Clearance::INVALID) << i;
    }
  };
  change(3 * kTfRemembers);
  const std::size_t heap_before = heapThatStaysInUse(gantry);
  change(3000);
  const std::size_t heap_after = heapThatStaysInUse(gantry);
  // Three bytes for each change would be more.
  EXPECT_NEAR(static_cast<double>(heap_after), static_cast<double>(heap_before), 16384.0);
}

}  // namespace proximity_server::node::monitor_memory_test
