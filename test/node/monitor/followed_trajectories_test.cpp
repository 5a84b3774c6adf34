// The lookahead beside simulated robots and controllers. With PROXIMITY_REPEATS many more cycles are simulated.
#include "node/monitor/commanded_trajectories.h"
#include "node/monitor/slider_robot.h"
#include "sanitized.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::node::followed_trajectories_test {

constexpr double kTrackingError = 0.01;
constexpr double kContact = 0.2 + 0.02;  // [m] between the centres of two sliders at the stop distance
constexpr int kJoints = 3;
const std::array<std::string, kJoints> kNames{"to_left", "to_middle", "to_right"};
const std::array<double, kJoints> kHomes{-0.55, 0.0, 0.55};

ros::Time at(double time) { return ros::Time(1000.0) + ros::Duration(time); }

struct State {
  double position = 0.0, velocity = 0.0, acceleration = 0.0;
};

/// A point of a command. The first degree has a position only, the third a velocity, the fifth an acceleration.
struct Knot {
  double time;
  State state;
  int degree;
};

/// The position that a controller commands to a joint, as a polynomial of the time.
class Path {
 public:
  explicit Path(double position) : pieces_{{-1.0, 0.0, {position, 0.0, 0.0, 0.0, 0.0, 0.0}}} {}

  State stateAt(double time) const {
    auto piece = pieces_.begin();
    while (std::next(piece) != pieces_.end() && std::next(piece)->begin <= time) ++piece;
    const double t = std::clamp(time, piece->begin, piece->end) - piece->begin;
    State state;
    for (int i = 5; i >= 0; --i) {
      state.acceleration = state.acceleration * t + 2.0 * state.velocity;
      state.velocity = state.velocity * t + state.position;
      state.position = state.position * t + piece->powers[i];
    }
    if (time > piece->end || time < piece->begin) state.velocity = state.acceleration = 0.0;
    return state;
  }

  void cut(double time) {
    while (pieces_.size() > 1 && pieces_.back().begin >= time) pieces_.pop_back();
    pieces_.back().end = std::min(pieces_.back().end, time);
  }
  void rest(double time, double position) {
    cut(time);
    pieces_.push_back({time, time, {position, 0.0, 0.0, 0.0, 0.0, 0.0}});
  }
  /// Slows down steadily, and rests after `duration`.
  void brake(double time, const State& from, double duration) {
    cut(time);
    pieces_.push_back(
        {time, time + duration, {from.position, from.velocity, -0.5 * from.velocity / duration, 0.0, 0.0, 0.0}});
  }
  void command(double begin, double zero, const std::vector<Knot>& knots) {
    State from = stateAt(begin);
    double time = begin;
    cut(begin);
    int degree = 5;
    for (const Knot& knot : knots) {
      if (zero + knot.time < begin + 1e-9) continue;
      add(time, from, zero + knot.time, knot.state, std::min(degree, knot.degree));
      time = zero + knot.time;
      from = knot.state;
      degree = knot.degree;
    }
  }

 private:
  struct Piece {
    double begin, end;
    std::array<double, 6> powers;
  };
  void add(double begin, const State& a, double end, const State& b, int degree) {
    const double t = end - begin, way = b.position - a.position;
    Piece piece{begin, end, {a.position, way / t, 0.0, 0.0, 0.0, 0.0}};
    auto& c = piece.powers;
    if (degree >= 3) {
      c[1] = a.velocity;
      c[2] = (3.0 * way - (2.0 * a.velocity + b.velocity) * t) / (t * t);
      c[3] = (-2.0 * way + (a.velocity + b.velocity) * t) / (t * t * t);
    }
    if (degree == 5) {
      c[2] = 0.5 * a.acceleration;
      const double p = way - (a.velocity + c[2] * t) * t, v = (b.velocity - a.velocity - 2.0 * c[2] * t) * t,
                   w = (b.acceleration - 2.0 * c[2]) * t * t;
      c[3] = (10.0 * p - 4.0 * v + 0.5 * w) / std::pow(t, 3);
      c[4] = (-15.0 * p + 7.0 * v - w) / std::pow(t, 4);
      c[5] = (6.0 * p - 3.0 * v + 0.5 * w) / std::pow(t, 5);
    }
    pieces_.push_back(piece);
  }
  std::vector<Piece> pieces_;
};

struct Command {
  int controller;
  double stamp;                                          ///< [s]; 0: none
  double received;                                       ///< [s] by the node
  double heard;                                          ///< [s] by the controller
  std::vector<std::pair<int, std::vector<Knot>>> knots;  ///< by joint; empty: the motion ends
  bool is_refused = false;
  double braking = 0.0;  ///< [s] if it cancels the goal, so long the joints brake
};

/// A controller and the joints that it moves. They follow it with a delay, and with errors that depend on the position;
/// or they do not follow it, and move at constant velocities.
struct Controller {
  std::string topic;
  std::vector<int> joints;
  double delay;
  std::vector<Path> paths;
  std::vector<double> phases;
  enum class Mode { Follows, Ignores } mode = Mode::Follows;
  double since = 0.0;  ///< [s] it ignores
  std::vector<State> then;
  bool is_exact = false;
  bool is_other = false;  ///< it has refused a command or canceled a goal, and taken no command of all its joints since

  State stateAt(std::size_t i, double time) const {
    if (mode == Mode::Ignores) return {then[i].position + (time - since) * then[i].velocity, then[i].velocity};
    State state = paths[i].stateAt(time - delay);
    constexpr double kTurns = 3.0;
    const double error = is_exact ? 0.0 : 0.9 * kTrackingError;
    const double angle = phases[i] + kTurns * state.position;
    state.velocity *= 1.0 + error * kTurns * std::cos(angle);
    state.position += error * std::sin(angle);
    return state;
  }
  /// Joints that brake together stay on a straight line, without errors.
  void brake(double time, double duration) {
    std::vector<State> states;
    for (std::size_t i = 0; i < joints.size(); ++i) states.push_back(stateAt(i, time));
    for (std::size_t i = 0; i < joints.size(); ++i) paths[i].brake(time - delay, states[i], duration);
    is_exact = true;
  }
  /// Rests at the present positions.
  void hold(double time) {
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const double position = stateAt(i, time).position;
      paths[i].rest(time - delay, position);
      phases[i] = -3.0 * position;
    }
    mode = Mode::Follows;
  }
  void ignore(double time, const std::vector<double>& velocities) {
    then.clear();
    for (std::size_t i = 0; i < joints.size(); ++i) then.push_back({stateAt(i, time).position, velocities[i]});
    mode = Mode::Ignores;
    since = time;
  }
  void hear(const Command& command) {
    if (mode == Mode::Ignores) return;
    if (command.is_refused || command.braking > 0.0) is_other = true;
    if (command.is_refused) return;
    if (command.braking > 0.0) return brake(command.heard, command.braking);
    if (command.knots.size() == joints.size()) is_other = false;
    if (command.knots.empty()) return hold(command.heard);
    const double zero = command.stamp == 0.0 ? command.heard : command.stamp;
    for (const auto& [joint, knots] : command.knots) {
      const auto place = std::find(joints.begin(), joints.end(), joint) - joints.begin();
      paths[place].command(std::max(zero, command.heard), zero, knots);
    }
  }
};

/// Robots that controllers move, and what the node is told of them.
class FollowedTrajectories : public MonitorOfSliders {
 protected:
  void SetUp() override {
    ros::Time::init();  // for warnings
    settings_.lookahead = 1.0;
    settings_.rate = 0.1;  // a search may take 2.5 s
    config_.tracking_error = {kTrackingError, {}};
  }

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  bool happens(double probability) { return uniform(0.0, 1.0) < probability; }
  static double rounded(double time) { return std::round(1e3 * time) * 1e-3; }

  void begin() {
    robot_ = std::make_shared<const Robot>(kSliders, "", config_);
    monitor_.follow(robot_);
    commands_.follow(nullptr, {});
    commands_.follow(robot_, {{"/arm", 0}, {"/gripper", 0}});
    controllers_.clear();
    commands_on_their_way_.clear();
    measured_.clear();
    for (const auto& [topic, joints] : {std::pair<std::string, std::vector<int>>{"/arm", {0, 1}}, {"/gripper", {2}}}) {
      Controller controller{topic, joints, uniform(0.0, 0.08), {}, {}, Controller::Mode::Follows, 0.0, {},
                            false, false};
      for (const int joint : joints) {
        const double home = kHomes[joint] + uniform(-0.1, 0.1);
        controller.paths.emplace_back(home);
        controller.phases.push_back(-3.0 * home);
      }
      controllers_.push_back(std::move(controller));
    }
    next_event_ = 0.3;
    next_command_ = {0.2, 0.2};
  }

  std::vector<Knot> randomKnots(int joint, double first) {
    std::vector<Knot> knots;
    const int count = 1 + static_cast<int>(uniform(0.0, 3.0)), degree = 1 + 2 * static_cast<int>(uniform(0.0, 3.0));
    double time = first;
    for (int i = 0; i < count; ++i) {
      time = rounded(time + uniform(0.2, 0.8));
      const bool is_last = i + 1 == count;
      knots.push_back(
          {time,
           {kHomes[joint] + uniform(-0.3, 0.3), is_last ? 0.0 : uniform(-0.6, 0.6), is_last ? 0.0 : uniform(-2.0, 2.0)},
           degree});
    }
    return knots;
  }

  void publish(int number, double time) {
    const Controller& controller = controllers_[number];
    Command command{number, 0.0, 0.0, 0.0, {}, false, 0.0};
    const double lead = scene::SplineDelays::kLargestLead;
    command.received = rounded(time + uniform(0.0, 0.02));
    command.heard = command.received + uniform(-lead, std::min(lead, scene::SplineDelays::kLargest - controller.delay));
    command.heard = std::max(command.heard, time);
    double first = 0.0;
    if (happens(0.5)) {
      command.stamp = rounded(command.received + (happens(0.4) ? uniform(-0.01, 0.0) : uniform(0.03, 0.5)));
      first = 0.05;  // no point is past
    }
    if (command.stamp == 0.0 && happens(0.15)) {
      command.braking = uniform(0.01, 0.5);
      ++canceled_;
    } else if (happens(0.9))
      for (const int joint : controller.joints)
        if (controller.joints.size() == 1 || command.knots.empty() || happens(0.7))
          command.knots.emplace_back(joint, randomKnots(joint, first));
    const bool is_partial = !command.knots.empty() && command.knots.size() < controller.joints.size();
    command.is_refused = command.braking == 0.0 && happens(is_partial ? 0.5 : 0.1);
    refused_ += command.is_refused;
    tell(command);
    commands_on_their_way_.push_back(command);
  }

  /// The points of joints that have others at the same time; a message has the same times for all.
  void tell(Command& command) {
    trajectory_msgs::JointTrajectory message;
    if (command.stamp > 0.0) message.header.stamp = at(command.stamp);
    const std::string topic = controllers_[command.controller].topic;
    if (!command.knots.empty()) {
      std::vector<Knot>& first = command.knots.front().second;
      for (auto& [joint, knots] : command.knots) {
        message.joint_names.push_back(kNames[joint]);
        while (knots.size() < first.size()) knots.push_back(knots.back());
        knots.resize(first.size());
        for (std::size_t i = 0; i < knots.size(); ++i) {
          knots[i].time = first[i].time;
          knots[i].degree = first[i].degree;
        }
      }
      for (std::size_t i = 0; i < first.size(); ++i) {
        trajectory_msgs::JointTrajectoryPoint point;
        point.time_from_start = ros::Duration(first[i].time);
        for (const auto& [joint, knots] : command.knots) {
          point.positions.push_back(knots[i].state.position);
          if (knots[i].degree >= 3) point.velocities.push_back(knots[i].state.velocity);
          if (knots[i].degree == 5) point.accelerations.push_back(knots[i].state.acceleration);
        }
        message.points.push_back(point);
      }
    }
    messages_.push_back({command.received, topic, message});
    std::ostringstream log;
    log << topic << " heard at " << command.heard << ", received at " << command.received << ", stamp " << command.stamp
        << (command.is_refused ? ", refused" : "");
    if (command.braking > 0.0) log << ", canceled, braking in " << command.braking;
    for (const auto& [joint, knots] : command.knots) {
      log << ", " << kNames[joint];
      for (const Knot& knot : knots) log << " " << knot.state.position << " at " << knot.time;
    }
    log_.push_back(log.str());
  }

  void causeEvents(double time) {
    for (int i = 0; i < 2; ++i) {
      if (time < next_command_[i]) continue;
      publish(i, time);
      next_command_[i] = time + uniform(0.08, 1.5);
    }
    if (time < next_event_) return;
    next_event_ = time + uniform(0.3, 1.0);
    if (controllers_[0].mode == Controller::Mode::Follows && controllers_[1].mode == Controller::Mode::Follows &&
        happens(0.5))
      return;
    Controller& controller = controllers_[controllers_[0].mode == Controller::Mode::Ignores || happens(0.3) ? 0 : 1];
    const bool is_told = std::any_of(commands_on_their_way_.begin(), commands_on_their_way_.end(),
                                     [&](const Command& command) { return command.heard > time - 0.1; });
    if (is_told) return;
    log_.push_back(controller.topic + " changes at " + std::to_string(time));
    if (controller.mode == Controller::Mode::Ignores) return controller.hold(time);
    std::vector<double> velocities;
    for (std::size_t i = 0; i < controller.joints.size(); ++i)
      velocities.push_back(happens(0.3)   ? 0.0
                           : happens(0.5) ? controller.stateAt(i, time).velocity
                                          : uniform(-1.0, 1.0));
    controller.ignore(time, velocities);
  }

  /// The controllers after all that they hear until a time.
  static void hearUntil(std::vector<Controller>& controllers, std::vector<Command>& commands, double time) {
    std::sort(commands.begin(), commands.end(), [](const Command& a, const Command& b) { return a.heard < b.heard; });
    while (!commands.empty() && commands.front().heard <= time) {
      controllers[commands.front().controller].hear(commands.front());
      commands.erase(commands.begin());
    }
  }

  /// Whether the spheres come into contact within the lookahead, if the controllers get what the node has got.
  bool touchesAfter(double time) const {
    std::vector<Controller> controllers = controllers_;
    std::vector<Command> commands = commands_on_their_way_;
    for (double t = time; t < time + settings_.lookahead - 1e-6; t += 0.004) {
      hearUntil(controllers, commands, t);
      std::array<double, kJoints> places;
      for (const Controller& controller : controllers)
        for (std::size_t i = 0; i < controller.joints.size(); ++i)
          places[controller.joints[i]] = controller.stateAt(i, t).position;
      for (const auto& [a, b] : {std::pair{0, 1}, {0, 2}, {1, 2}})
        if (std::abs(places[a] - places[b]) < kContact - 1e-6) return true;
    }
    return false;
  }

  struct Measured {
    double time;
    std::array<State, kJoints> joints;
  };

  /// Whether the last states agree with splines as UNCERTAINTY.md says: for 0.1 s, those since the last command with one
  /// delay, and those before it with one.
  bool agrees(const scene::FollowedSplines& followed) const {
    const double command = commanded_[followed.joints.front() < 2 ? 0 : 1];
    return agrees(followed, -std::numeric_limits<double>::infinity(), command) &&
           agrees(followed, command, std::numeric_limits<double>::infinity());
  }
  /// Those between two times. The delay is relative to the best one. What the splines and their velocities change in a
  /// cell of SplineDelays is left over.
  bool agrees(const scene::FollowedSplines& followed, double from, double to) const {
    for (double delay = -0.12; delay < 0.12 + 1e-6; delay += 0.001) {
      const auto isNear = [&](const Measured& measured) {
        if (measured.time < from || measured.time >= to) return true;
        const double time = followed.time + measured.time - measured_.back().time;
        return std::all_of(followed.joints.begin(), followed.joints.end(), [&](int joint) {
          const State& is = measured.joints[joint];
          const double error = kTrackingError + 6e-3 + followed.splines->inexactAt(joint, time - 0.12);
          double slowest = std::numeric_limits<double>::infinity(), fastest = -slowest;
          for (const double later : {-scene::SplineDelays::kStep, 0.0, scene::SplineDelays::kStep}) {
            const double velocity = followed.splines->stateAt(time - delay + later).velocities[joint];
            slowest = std::min(slowest, velocity);
            fastest = std::max(fastest, velocity);
          }
          return std::abs(followed.splines->positionAt(joint, time - delay) - is.position) < error &&
                 is.velocity > slowest - 0.3 && is.velocity < fastest + 0.3;
        });
      };
      if (std::all_of(measured_.begin(), measured_.end(), isNear)) return true;
    }
    return false;
  }

  /// The answer about the states at a time.
  Lookahead cycle(double time, double now) {
    Measured measured{time, {}};
    for (const Controller& controller : controllers_)
      for (std::size_t i = 0; i < controller.joints.size(); ++i)
        measured.joints[controller.joints[i]] = controller.stateAt(i, time);
    measured_.push_back(measured);
    while (measured_.front().time < time - scene::SplineDelays::kAgreement) measured_.erase(measured_.begin());
    std::stable_sort(messages_.begin(), messages_.end(),
                     [](const Message& a, const Message& b) { return a.received < b.received; });
    while (!messages_.empty() && messages_.front().received <= now) {
      const Message& message = messages_.front();
      EXPECT_EQ(commands_.take(message.topic, message.trajectory, at(message.received)), "");
      const int number = message.topic == controllers_[0].topic ? 0 : 1;
      commanded_[number] = message.received;
      const std::vector<std::string>& named = message.trajectory.joint_names;
      for (const int joint : controllers_[number].joints)
        if (named.empty() || std::find(named.begin(), named.end(), kNames[joint]) != named.end())
          told_[joint] = message.received;
      messages_.erase(messages_.begin());
    }
    PoseSnapshot poses;
    poses.stamp = at(time);
    VelocitySnapshot moving;
    scene::Positions positions;
    for (const State& state : measured.joints) {
      positions.push_back(state.position);
      moving.velocities.push_back(state.velocity);
      moving.stamps.push_back(poses.stamp);
    }
    poses.poses = scene::forwardKinematics(robot_->robotModel(), positions);
    motion_ = commands_.lookUp(monitor_.joints(), poses, moving, at(now));
    return monitor_.cycle(poses, moving, settings_, {}, motion_).lookahead;
  }

  /// Whether a controller that is not followed looks as if it were, and whether only such a one does.
  bool isTakenForFollowed() {
    bool is_taken = false;
    for (const scene::FollowedSplines& followed : motion_.followed) {
      if (followed.certainty != scene::FollowedSplines::Certainty::Followed) continue;
      const Controller& controller = controllers_[followed.joints.front() < 2 ? 0 : 1];
      if (controller.mode == Controller::Mode::Follows && !(controller.is_other && isAnotherMotion(followed))) continue;
      is_taken = true;
      EXPECT_TRUE(agrees(followed)) << text(measured_.back().time);
      if (controller.mode == Controller::Mode::Ignores) continue;
      for (const int joint : followed.joints)
        EXPECT_GT(measured_.back().time, told_[joint] + scene::SplineDelays::kAgreement - 0.02)
            << text(measured_.back().time);
    }
    return is_taken;
  }

  /// Whether splines that count alone are not those of the controller.
  bool isAnotherMotion(const scene::FollowedSplines& followed) const {
    const auto hasJoint = [](const scene::FollowedSplines& splines, int joint) {
      return std::find(splines.joints.begin(), splines.joints.end(), joint) != splines.joints.end();
    };
    std::vector<Controller> controllers = controllers_;
    std::vector<Command> commands = commands_on_their_way_;
    const double now = measured_.back().time;
    hearUntil(controllers, commands, now + settings_.lookahead);
    const Controller& controller = controllers[followed.joints.front() < 2 ? 0 : 1];
    for (std::size_t i = 0; i < controller.joints.size(); ++i) {
      const int joint = controller.joints[i];
      const bool is_alone = std::count_if(motion_.followed.begin(), motion_.followed.end(),
                                          [&](const auto& other) { return hasJoint(other, joint); }) == 1;
      for (double time = 0.0; is_alone && hasJoint(followed, joint) && time < settings_.lookahead; time += 0.02) {
        const double expected = followed.splines->positionAt(joint, followed.time + time);
        const double error = kTrackingError + 5e-3 + followed.splines->inexactAt(joint, followed.time + time - 0.12);
        if (std::abs(expected - controller.stateAt(i, now + time).position) > error) return true;
      }
    }
    return false;
  }

  /// The true motion, and the one that the node assumes.
  std::string text(double time) const {
    std::ostringstream text;
    for (std::size_t i = log_.size() < 12 ? 0 : log_.size() - 12; i < log_.size(); ++i) text << "\n" << log_[i];
    for (const Controller& controller : controllers_) {
      text << "\n"
           << controller.topic << (controller.mode == Controller::Mode::Ignores ? " ignores" : " follows") << " since "
           << controller.since << ", with a delay of " << controller.delay;
      for (std::size_t i = 0; i < controller.joints.size(); ++i)
        text << ", " << kNames[controller.joints[i]] << " at " << controller.stateAt(i, time).position << " with "
             << controller.stateAt(i, time).velocity;
    }
    for (const Command& command : commands_on_their_way_)
      text << "\n"
           << controllers_[command.controller].topic << " gets a command at " << command.heard << ", the node at "
           << command.received;
    for (const scene::FollowedSplines& followed : motion_.followed) {
      text << "\nsplines of joint " << followed.joints.front()
           << (followed.certainty == scene::FollowedSplines::Certainty::Followed ? "" : " perhaps") << ", time "
           << followed.time << " - " << followed.behind << " + " << followed.ahead << ", first point at "
           << followed.splines->exact_from;
      for (const int joint : followed.joints)
        text << ", " << kNames[joint] << " at " << followed.splines->stateAt(followed.time).positions[joint]
             << ", inexact " << followed.splines->inexactAt(joint, followed.time);
    }
    return text.str();
  }

  /// Whether a controller has heard what the node has not got yet.
  bool hasUnknown(double now) const {
    return std::any_of(messages_.begin(), messages_.end(), [&](const Message& m) { return m.received > now; });
  }

  struct Message {
    double received;
    std::string topic;
    trajectory_msgs::JointTrajectory trajectory;
  };
  std::mt19937 random_{7};
  CommandedTrajectories commands_;
  CommandedMotion motion_;
  std::vector<Controller> controllers_;
  std::vector<Command> commands_on_their_way_;
  std::vector<Message> messages_;
  std::vector<Measured> measured_;
  std::vector<std::string> log_;
  std::array<double, 2> next_command_{};
  std::array<double, 2> commanded_{};   ///< [s] when the node has got the last command of a controller
  std::array<double, kJoints> told_{};  ///< [s] the same of a joint
  double next_event_ = 0.0;
  int canceled_ = 0, refused_ = 0;
};

TEST_F(FollowedTrajectories, IsNotFreeBeforeAContactOfWhatControllersDo) {
  int cycles = 0, free = 0, contacts = 0, along = 0, certain = 0, taken = 0, strays = 0;
  const int runs = repeats(20);
  for (int run = 0; run < runs; ++run) {
    begin();
    messages_.clear();
    double now = 0.0;
    for (double time = 0.0; time < 6.0; time = rounded(time + uniform(0.008, 0.02)), ++cycles) {
      causeEvents(time);
      now = std::max(now, rounded(time + uniform(0.0, 0.02)));
      hearUntil(controllers_, commands_on_their_way_, time);
      const Lookahead lookahead = cycle(time, now);
      free += lookahead.state == Lookahead::FREE;
      contacts += lookahead.state == Lookahead::CONTACT;
      along += !motion_.followed.empty();
      certain +=
          std::any_of(motion_.followed.begin(), motion_.followed.end(), [](const scene::FollowedSplines& followed) {
            return followed.certainty == scene::FollowedSplines::Certainty::Followed;
          });
      strays += motion_.text.find("off the trajectory") != std::string::npos;
      if (isTakenForFollowed()) {
        ++taken;
        continue;
      }
      if (lookahead.state != Lookahead::FREE || hasUnknown(now)) continue;
      ASSERT_FALSE(touchesAfter(time)) << "run " << run << " at " << time << ": " << lookahead.status.message
                                       << text(time);
    }
  }
  RecordProperty("cycles", cycles);
  std::cout << refused_ << " refused, " << canceled_ << " canceled, " << cycles << " cycles, " << free << " free, "
            << contacts << " contact, " << along << " along, " << certain << " certain, " << taken << " taken, "
            << strays << " stray\n";
  const bool is_short = runs < 20;  // a few runs have no shares that can be expected
  EXPECT_GT(refused_, is_short ? 0 : runs);
  EXPECT_GT(canceled_, is_short ? 0 : runs);
  EXPECT_GT(free, is_short ? 0 : cycles / 5);
  EXPECT_GT(contacts, is_short ? 0 : cycles / 5);
  EXPECT_GT(certain, is_short ? 0 : cycles / 5);
  EXPECT_LT(taken, is_short ? cycles : cycles / 8) << "about so many are not asked";
}

}  // namespace proximity_server::node::followed_trajectories_test
