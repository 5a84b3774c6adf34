#include "node/monitor/monitor_loop.h"

#include "node/robot/query_status.h"
#include "node/threads/real_time.h"
#include "node/threads/request_queue.h"
#include "proximity_server/scene/model/kinematics.h"

#include <ros/console.h>
#include <ros/single_subscriber_publisher.h>
#include <std_msgs/Float64.h>
#include <std_msgs/Int64.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>

namespace proximity_server::node {
namespace {

using Lock = std::lock_guard<std::mutex>;

/// The longest wall time [s] without a message: two periods and at least 1 s, or at rate 0 the age at which transforms
/// are stale, and at most 1 s.
ros::WallDuration keepAlivePeriod(const MonitorSettings& settings, const Config& config) {
  return ros::WallDuration(settings.rate > 0.0 ? std::max(1.0, 2.0 / settings.rate) : std::min(1.0, config.max_tf_age));
}

/// [s] During this wall time after the start no warning is logged, and no velocity scale of 0 is made of not knowing,
/// because the first transforms and joint_states may take so long to arrive.
const ros::WallDuration kFirstTransformsTimeout(1.0);
/// [s] Shortest wall time between two warnings about the level INVALID.
const ros::WallDuration kWarningPeriod(10.0);

/// The snapshot without its poses, so that the level is INVALID with this status.
PoseSnapshot withoutPoses(PoseSnapshot snapshot, const QueryStatus& status) {
  std::fill(snapshot.poses.begin(), snapshot.poses.end(), std::nullopt);
  snapshot.status = status;
  return snapshot;
}

}  // namespace

MonitorLoop::MonitorLoop(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh, TfPoses& tf,
                         const TrackedAges& ages, const Config& config, Recorder& recorder)
    : tf_(tf),
      ages_(ages),
      recorder_(recorder),
      public_nh_(nh),
      nh_(withQueue(private_nh, queue_)),
      spinner_(1, &queue_),
      steady_timer_([priority = config.realtime_priority] { runInRealTime(priority); }, [this] { cycleOfTimer(); }) {
  health_.enabled = true;
  health_.settings = config.monitor;
  clearance_pub_ = nh_.advertise<Clearance>("clearance", 1);
  constraints_pub_ = nh_.advertise<ConstraintRows>("constraints", 1);
  velocity_scale_pub_ = nh_.advertise<std_msgs::Float64>("collision_velocity_scale", 1);
  separation_pub_ = nh_.advertise<Separation>("separation", 1);
  separation_scale_pub_ = nh_.advertise<std_msgs::Float64>("separation_scale", 1);
  separation_override_pub_ = nh_.advertise<std_msgs::Int64>("separation_override", 1);
  sensed_pub_ = nh_.advertise<Sensed>("sensed", 1);
  markers_pub_ = nh_.advertise<visualization_msgs::MarkerArray>(
      "markers", 10, [this](const ros::SingleSubscriberPublisher& subscriber) { sendPieces(subscriber); });
  simulated_timer_ = nh_.createTimer(
      ros::Duration(1.0), [this](const ros::TimerEvent&) { cycleOfTimer(); }, false, false);
  keep_alive_ = nh_.createWallTimer(ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) { onKeepAlive(); });
  wake_ = callbackOf([this] {
    wake_pending_ = false;
    cycleIfNew();
  });
  changed_ = callbackOf([this] {
    if (on_tf_) changed_pending_ = false;
    cycle();
  });
  queue_.addCallback(callbackOf([priority = config.realtime_priority] { runInRealTime(priority); }));
}

void MonitorLoop::start(const std::shared_ptr<const Robot>& robot) {
  next_warning_ = first_scale_until_ = ros::SteadyTime::now() + kFirstTransformsTimeout;
  follow(robot);
  configure(robot->config().monitor);
  tf_.onChange([this] { onTransform(); });
  spinner_.start();
}

MonitorLoop::~MonitorLoop() {
  tf_.onChange(nullptr);
  steady_timer_.stop();
  queue_.disable();
  spinner_.stop();
}

void MonitorLoop::follow(const std::shared_ptr<const Robot>& robot) {
  const Lock lock(mutex_);
  {
    const Lock exchange_lock(exchange_mutex_);  // the objects in next_ are those of the previous robot
    next_.reset();
  }
  lookup_.reset();  // it refers to the robot that is replaced next
  monitor_.follow(robot);
  lookup_.emplace(*robot, edgesTo(*robot, monitor_.bodies()));
  listenToCommands();
  markers_.reset();
  keep_alive_.setPeriod(keepAlivePeriod(health_.settings, robot->config()));
  redrawPieces();
}

void MonitorLoop::takeObjects(const Robot& robot) {
  auto objects = std::make_unique<MonitoredObjects>(robot, robot.objects().get());
  std::unique_ptr<MonitoredObjects> previous;
  {
    const Lock lock(exchange_mutex_);
    next_.swap(objects);
    previous_.swap(previous);
  }
  // A cycle that has begun with the previous objects publishes its message before this lock is granted. This thread
  // must do nothing while it has the lock, because it may have a low priority.
  { const Lock cycle_has_ended(mutex_); }
  if (!changed_pending_.exchange(true)) queue_.addCallback(changed_);
}

void MonitorLoop::useNextObjects() {
  std::unique_ptr<MonitoredObjects> objects;
  {
    const Lock lock(exchange_mutex_);
    next_.swap(objects);
  }
  if (!objects) return;
  monitor_.use(*objects);
  if (monitor_.bodies() != objects->bodies)
    lookup_.emplace(*monitor_.robot(), edgesTo(*monitor_.robot(), monitor_.bodies()));
  const Lock lock(exchange_mutex_);
  previous_.swap(objects);
}

const PoseSnapshot& MonitorLoop::lookUp() {
  useNextObjects();
  const PoseSnapshot& found = tf_.lookUp(*lookup_);
  const QueryStatus tracked = ages_.status(ros::Time::now());
  if (tracked.code == QueryStatus::OK || found.status.code != QueryStatus::OK) return found;
  return stale_ = withoutPoses(found, tracked);
}

void MonitorLoop::configure(const MonitorSettings& settings) {
  const Lock lock(mutex_);
  const bool redraw = settings.markers != health_.settings.markers;
  health_.settings = settings;
  on_tf_ = settings.rate == 0.0;
  changed_pending_ = false;
  listenToCommands();
  setRate(settings.rate);
  keep_alive_.setPeriod(keepAlivePeriod(settings, monitor_.robot()->config()));
  if (redraw) redrawPieces();
}

void MonitorLoop::setRate(double rate) {
  simulated_timer_.stop();
  steady_timer_.stop();
  if (rate == 0.0) return;
  if (!ros::Time::isSimTime()) return steady_timer_.start(1.0 / rate);
  simulated_timer_.setPeriod(ros::Duration(1.0 / rate));
  simulated_timer_.start();
}

void MonitorLoop::enable() {
  const Lock lock(mutex_);
  health_.enabled = true;
}

void MonitorLoop::disable() {
  const Lock lock(mutex_);
  health_.enabled = false;
}

bool MonitorLoop::beginRecord() {
  const Lock lock(mutex_);
  return recorder_.beginSaving();
}

MonitorHealth MonitorLoop::health() {
  const Lock lock(mutex_);
  MonitorHealth health = health_;
  health.last = monitor_.latest();
  if (const auto& broken = monitor_.broken()) health.broken = broken->inequality->brokenText(broken->excess);
  health_.slowest_cycle = ros::Duration(0.0);
  return health;
}

void MonitorLoop::onTransform() {
  if (on_tf_ && !wake_pending_.exchange(true)) queue_.addCallback(wake_);
}

void MonitorLoop::onKeepAlive() {
  const Lock lock(mutex_);
  const ros::Time now = ros::Time::now();
  clock_stands_still_ = now == last_keep_alive_;
  if ((!has_cycled_ || clock_stands_still_) && health_.enabled)
    publish(clock_stands_still_ ? lookUpWithStoppedClock() : lookUp());
  has_cycled_ = false;
  last_keep_alive_ = now;
}

/// Returns no poses, because their age is not known.
PoseSnapshot MonitorLoop::lookUpWithStoppedClock() {
  const PoseSnapshot& snapshot = lookUp();
  if (snapshot.status.code != QueryStatus::OK) return snapshot;
  return withoutPoses(
      snapshot, statusOf(QueryStatus::TF_STALE, "the clock stands still: nothing tells how old the transforms are"));
}

/// Returns whether a timer or new transforms start a cycle now: not if the monitor is disabled, and not while the clock
/// stands still, because onKeepAlive() then publishes.
bool MonitorLoop::mustCycle() const {
  return health_.enabled && !(clock_stands_still_ && ros::Time::now() == last_keep_alive_);
}

void MonitorLoop::cycleIfNew() {
  const Lock lock(mutex_);
  if (!mustCycle()) return;
  const PoseSnapshot& snapshot = lookUp();
  const bool moved = snapshot.stamp != monitor_.latest().header.stamp;
  if (moved || !monitor_.frames().names.empty() || snapshot.status.code != monitor_.latest().status.code)
    publish(snapshot);
}

void MonitorLoop::cycleOfTimer() {
  changed_pending_ = false;
  cycle();
}

void MonitorLoop::cycle() {
  const Lock lock(mutex_);
  if (mustCycle()) publish(lookUp());
}

void MonitorLoop::publish(const PoseSnapshot& snapshot) {
  const ros::SteadyTime begin = ros::SteadyTime::now();
  has_cycled_ = true;
  const FrameSnapshot frames = tf_.lookUpFrames(*monitor_.robot(), monitor_.frames(), snapshot);
  // Asked once: a subscriber that comes during the cycle waits for the next one, which looks the velocities up.
  const bool is_scaled = velocity_scale_pub_.getNumSubscribers() > 0, is_separated = isSeparated();
  const bool needs_velocities = is_scaled || is_separated || health_.settings.lookahead > 0.0 ||
                                monitor_.robot()->config().pose_latency != PoseLatency::Off;
  const VelocitySnapshot velocities = needs_velocities ? lookUpVelocities() : VelocitySnapshot();
  const Clearance& clearance =
      monitor_.cycle(snapshot, velocities, health_.settings, frames, lookUpCommands(snapshot, velocities));
  clearance_pub_.publish(clearance);
  recorder_.add(*monitor_.robot(), snapshot, frames, clearance, health_.settings);
  warnIfInvalid(clearance);
  warnOfPositions(snapshot);
  if (constraints_pub_.getNumSubscribers() > 0)
    constraints_pub_.publish(monitor_.constraints(snapshot, health_.settings));
  if (is_scaled) publishVelocityScale(snapshot, velocities, frames);
  if (is_separated) publishSeparation(snapshot, velocities, frames);
  if (sensed_pub_.getNumSubscribers() > 0) sensed_pub_.publish(monitor_.sensed(ages_.clouds(ros::Time::now())));
  if (health_.settings.markers && markers_pub_.getNumSubscribers() > 0) publishMarkers(clearance, snapshot.poses);
  health_.slowest_cycle = std::max(health_.slowest_cycle, ros::Duration((ros::SteadyTime::now() - begin).toSec()));
}

void MonitorLoop::warnIfInvalid(const Clearance& clearance) {
  if (clearance.level != Clearance::INVALID) return;
  const ros::SteadyTime now = ros::SteadyTime::now();
  if (now < next_warning_) return;
  next_warning_ = now + kWarningPeriod;
  ROS_WARN_STREAM("~clearance is INVALID: " << statusName(clearance.status.code) << ": " << clearance.status.message);
}

void MonitorLoop::warnOfPositions(const PoseSnapshot& snapshot) {
  health_.beyond.clear();
  if (!snapshot.beyond) return;
  append(health_.beyond, *monitor_.robot(), *snapshot.beyond);
  ROS_WARN_STREAM_THROTTLE(10.0, health_.beyond);
}

void MonitorLoop::publishVelocityScale(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                                       const FrameSnapshot& frames) {
  const StoppingScale found = monitor_.velocityScale(snapshot, velocities, health_.settings, frames);
  if (found.status.code == QueryStatus::OK) {
    first_scale_until_ = {};
  } else {
    if (ros::SteadyTime::now() < first_scale_until_) return;
    ROS_WARN_STREAM_THROTTLE(10.0, "~collision_velocity_scale is 0: " << found.status.message);
  }
  std_msgs::Float64 message;
  message.data = found.scale;
  velocity_scale_pub_.publish(message);
}

bool MonitorLoop::isSeparated() const {
  return separation_pub_.getNumSubscribers() + separation_scale_pub_.getNumSubscribers() +
             separation_override_pub_.getNumSubscribers() >
         0;
}

void MonitorLoop::publishSeparation(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                                    const FrameSnapshot& frames) {
  const Separation found =
      monitor_.separation(snapshot, velocities, health_.settings, frames, ages_.all(ros::Time::now()));
  if (found.status.code != QueryStatus::OK)
    ROS_WARN_STREAM_THROTTLE(10.0, "~separation_scale is 0: " << found.status.message);
  separation_pub_.publish(found);
  std_msgs::Float64 scale;
  scale.data = found.scale;
  separation_scale_pub_.publish(scale);
  std_msgs::Int64 percent;
  percent.data = static_cast<std::int64_t>(100.0 * found.scale);  // rounded down
  separation_override_pub_.publish(percent);
}

void MonitorLoop::listenToCommands() {
  health_.settings.lookahead > 0.0 ? commands_.listen(public_nh_, monitor_.robot()) : commands_.stopListening();
}

VelocitySnapshot MonitorLoop::lookUpVelocities() {
  VelocitySnapshot velocities = velocitiesOf(*monitor_.robot(), tf_.stated(), monitor_.joints(), ros::Time::now());
  velocities.roots = tf_.standingStill(*monitor_.robot(), monitor_.roots());
  if (velocities.status.code == QueryStatus::OK) velocities.status = velocities.roots;
  return velocities;
}

const CommandedMotion& MonitorLoop::lookUpCommands(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities) {
  static const CommandedMotion kNone;
  if (health_.settings.lookahead == 0.0) return kNone;
  return commands_.lookUp(monitor_.joints(), snapshot, velocities, ros::Time::now());
}

void MonitorLoop::publishMarkers(const Clearance& clearance, const scene::BodyPoses& poses) {
  if (!markers_) markers_.emplace(monitor_.robot()->robotModel());
  visualization_msgs::MarkerArray array = markers_->draw(clearance, poses, health_.settings);
  addTracked(*monitor_.robot(), *monitor_.robot()->objects().get().all, array);
  markers_pub_.publish(array);
}

visualization_msgs::MarkerArray MonitorLoop::pieces() const { return pieceMarkers(*monitor_.robot()); }

void MonitorLoop::redrawPieces() {
  if (markers_pub_.getNumSubscribers() == 0) return;
  markers_pub_.publish(noMarkers());
  if (health_.settings.markers) markers_pub_.publish(pieces());
}

void MonitorLoop::sendPieces(const ros::SingleSubscriberPublisher& subscriber) {
  const Lock lock(mutex_);
  if (health_.settings.markers) subscriber.publish(pieces());
}

}  // namespace proximity_server::node
