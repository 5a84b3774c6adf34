#include "node/answers/motions.h"
#include "node/robot/load_config.h"
#include "node/robot/robot.h"
#include "node/services/joint_requests.h"
#include "node/tf/joint_frames.h"
#include "robots/urdf.h"
#include "sanitized.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <vector>

// Two random robots in one node, with any frame as the reference frame. The transforms of tf are composed here, from
// their joints.

namespace proximity_server::node::reference_frames_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kRadius = 0.05;       // [m] of the ball about the origin of each link
constexpr double kRounding = 1e-12;    // [m] poses of a few metres
constexpr double kMotionError = 3e-6;  // [m] the tolerance of a minimum is 1e-6
constexpr std::size_t kJoints = 3;     // of each robot: base, upper, lower, hand
const std::array<std::string, 5> kLinks = {"base", "upper", "lower", "hand", "tool"};  // a fixed joint carries the tool

using Positions = std::array<double, kJoints>;

class Random {
 public:
  explicit Random(unsigned seed) : generator_(seed) {}
  double real(double from, double to) { return std::uniform_real_distribution<double>(from, to)(generator_); }
  std::size_t below(std::size_t size) { return std::uniform_int_distribution<std::size_t>(0, size - 1)(generator_); }
  Vector3d point(double size) { return {real(-size, size), real(-size, size), real(-size, size)}; }

 private:
  std::mt19937 generator_;
};

std::string textOf(const Vector3d& v) {
  std::ostringstream text;
  text.precision(17);
  text << v.x() << " " << v.y() << " " << v.z();
  return text.str();
}

/// A frame, with the angles that a URDF gives it.
struct Origin {
  Vector3d xyz, rpy;

  Isometry3d pose() const {
    return Isometry3d(Eigen::Translation3d(xyz) * Eigen::AngleAxisd(rpy.z(), Vector3d::UnitZ()) *
                      Eigen::AngleAxisd(rpy.y(), Vector3d::UnitY()) * Eigen::AngleAxisd(rpy.x(), Vector3d::UnitX()));
  }
  std::string text() const { return robots::origin(textOf(xyz), textOf(rpy)); }
};

Origin randomOrigin(Random& random, double size) { return {random.point(size), random.point(3.0)}; }

/// A chain of links.
struct Arm {
  struct Part {
    Origin origin;
    Vector3d axis;
    bool turns;
  };
  Isometry3d world_T_base;
  std::array<Part, kJoints> parts;
  Origin tool;

  Isometry3d poseOf(std::size_t link, const Positions& positions) const {
    Isometry3d pose = world_T_base;
    for (std::size_t i = 0; i < std::min(link, kJoints); ++i) {
      const Part& part = parts[i];
      pose = pose * part.origin.pose() *
             (part.turns ? Isometry3d(Eigen::AngleAxisd(positions[i], part.axis))
                         : Isometry3d(Eigen::Translation3d(positions[i] * part.axis)));
    }
    return link <= kJoints ? pose : pose * tool.pose();
  }

  std::string urdf() const {
    using namespace robots;
    std::string all;
    for (const std::string& name : kLinks) all += link(name, ball(std::to_string(kRadius)));
    for (std::size_t i = 0; i < kJoints; ++i)
      all += joint(kLinks[i + 1], parts[i].turns ? "continuous" : "prismatic", kLinks[i], kLinks[i + 1],
                   parts[i].origin.text() + axis(textOf(parts[i].axis)) + limits("-9", "9"));
    return urdfOf(all + joint("tool", "fixed", "hand", "tool", tool.text()));
  }
};

Arm randomArm(Random& random) {
  Arm arm;
  arm.world_T_base = randomOrigin(random, 1.0).pose();
  for (Arm::Part& part : arm.parts) {
    part = {randomOrigin(random, 0.5), random.point(1.0), random.below(2) == 0};
    part.axis.normalize();
  }
  arm.tool = randomOrigin(random, 0.3);
  return arm;
}

Positions randomPositions(Random& random) {
  Positions positions;
  for (double& position : positions) position = random.real(-2.0, 2.0);
  return positions;
}

/// The positions of both robots.
using State = std::array<Positions, 2>;
State randomState(Random& random) { return {randomPositions(random), randomPositions(random)}; }

/// Two robots in a world, as they are here, and as the node has them.
struct Cell {
  std::array<Arm, 2> arms;
  std::string reference;
  Robot robot;

  /// "world", or the frame of a link as "left/hand".
  Isometry3d worldPoseOf(const std::string& frame, const State& state) const {
    if (frame == "world") return Isometry3d::Identity();
    const std::size_t slash = frame.find('/');
    const std::size_t arm = frame.substr(0, slash) == "left" ? 0 : 1;
    const auto link = std::find(kLinks.begin(), kLinks.end(), frame.substr(slash + 1));
    return arms[arm].poseOf(static_cast<std::size_t>(link - kLinks.begin()), state[arm]);
  }
  Isometry3d poseOf(const std::string& frame, const std::string& in, const State& state) const {
    return worldPoseOf(in, state).inverse() * worldPoseOf(frame, state);
  }

  /// The transforms that tf has of the frames that the node asks for, in a state.
  JointSnapshot tfIn(const State& state) const {
    const scene::RobotModel& model = robot.robotModel();
    std::vector<int> bodies;
    for (std::size_t i = 0; i < model.bodies.size(); ++i) bodies.push_back(static_cast<int>(i));
    std::map<int, Isometry3d> said;
    for (const int edge : edgesTo(robot, bodies)) {
      const TfEdge& asked = robot.tfEdges()->at(static_cast<std::size_t>(edge));
      said[edge] = poseOf(asked.child, asked.parent, state);
    }
    const auto find = [&](int edge) { return said.count(edge) ? std::optional(said.at(edge)) : std::nullopt; };
    JointSnapshot snapshot;
    for (std::size_t i = 0; i < model.joints.size(); ++i) snapshot.joints.push_back(find(static_cast<int>(i)));
    for (int i = 0; i < 2; ++i) snapshot.roots.push_back(find(robot.rootEdge(i)));
    return snapshot;
  }

  /// The positions of the joints in the order of the model.
  std::vector<double> inOrder(const State& state) const {
    std::vector<double> positions;
    for (const scene::Joint& joint : robot.robotModel().joints) {
      const std::size_t arm = joint.name.rfind("left/", 0) == 0 ? 0 : 1;
      const std::string own = joint.name.substr(joint.name.find('/') + 1);
      positions.push_back(
          state[arm][static_cast<std::size_t>(std::find(kLinks.begin(), kLinks.end(), own) - kLinks.begin()) - 1]);
    }
    return positions;
  }
};

Cell randomCell(Random& random) {
  const std::array<Arm, 2> arms = {randomArm(random), randomArm(random)};
  std::vector<std::string> frames = {"world"};
  for (const std::string robot : {"left/", "right/"})
    for (const std::string& link : kLinks) frames.push_back(robot + link);
  const std::string& reference = frames[random.below(frames.size())];
  XmlRpc::XmlRpcValue values;
  for (const std::string name : {"left", "right"}) {
    values["robots"][name]["description"] = "/" + name;
    values["robots"][name]["tf_prefix"] = name;
  }
  values["reference_frame"] = reference;
  return {arms, reference,
          Robot(std::vector<RobotTexts>{{arms[0].urdf(), ""}, {arms[1].urdf(), ""}}, configFrom(values, "/node"))};
}

/// The poses that a request has which gives all positions.
scene::BodyPoses posesIn(const Cell& cell, const JointSnapshot& tf, const State& state) {
  JointValues positions;
  for (const double position : cell.inOrder(state)) positions.emplace_back(position);
  return inReference(cell.robot, posesInRoot(cell.robot, positions, tf), tf.roots);
}

TEST(ReferenceFrames, OfAnyLinkSeeBothRobotsWhereTheyStand) {
  Random random(1);
  for (int i = 0; i < repeats(300); ++i) {
    const Cell cell = randomCell(random);
    const JointSnapshot tf = cell.tfIn(randomState(random));
    const State asked = randomState(random);
    const scene::BodyPoses poses = posesIn(cell, tf, asked);
    for (const scene::Link& link : cell.robot.robotModel().links) {
      const auto& pose = poses[link.body];
      ASSERT_TRUE(pose) << link.name;
      const Isometry3d expected = cell.poseOf(link.name, cell.reference, asked);
      ASSERT_TRUE((*pose * link.body_T_link).matrix().isApprox(expected.matrix(), kRounding))
          << link.name << " in " << cell.reference << ", cell " << i;
    }
  }
}

/// A pair of balls, one of each robot.
struct Balls {
  std::string left, right;

  double distance(const Cell& cell, const State& state) const {
    return cell.poseOf(right, left, state).translation().norm() - 2.0 * kRadius;
  }
};

TEST(ReferenceFrames, OfAnyLinkDoNotCarryTheOtherRobotAlongATrajectory) {
  Random random(2);
  int moving_references = 0, contacts = 0, complete = 0;
  const int cells = repeats(150);
  for (int i = 0; i < cells; ++i) {
    const Cell cell = randomCell(random);
    const scene::RobotModel& model = cell.robot.robotModel();
    const JointSnapshot tf = cell.tfIn(randomState(random));
    const State from = randomState(random), to = randomState(random);
    const auto at = [&](double time) {
      State state = from;
      for (std::size_t arm = 0; arm < 2; ++arm)
        for (std::size_t joint = 0; joint < kJoints; ++joint)
          state[arm][joint] += time * (to[arm][joint] - from[arm][joint]);
      return state;
    };
    const scene::BodyPoses poses = posesIn(cell, tf, from);
    scene::Motion motion(model, inRoot(cell.robot, poses), {0.0, cell.inOrder(from)}, {1.0, cell.inOrder(to)});
    motion.carryObjects(objectFramesInRoot(cell.robot, poses, {}, {}));

    const Balls balls{"left/" + kLinks[random.below(kLinks.size())], "right/" + kLinks[random.below(kLinks.size())]};
    const std::vector<scene::ShapeRefPair> pair = {{{model.findLink(balls.left)}, {model.findLink(balls.right)}}};
    const std::string what = balls.left + ", " + balls.right + " in " + cell.reference + ", cell " + std::to_string(i);
    scene::MotionSearch scene(cell.robot.sharedModel());
    const scene::RobotMinimum found = scene.minimum(pair, motion, {});
    ASSERT_LE(found.lower_bound, found.upper_bound) << what;
    ASSERT_NEAR(found.pair.result.distance, balls.distance(cell, at(found.time)), kMotionError) << what;
    for (int sample = 0; sample <= 20; ++sample)
      ASSERT_GE(balls.distance(cell, at(0.05 * sample)), found.lower_bound - kRounding) << what;

    const Proximity said = toMessage(RobotAndObjects(model), motion, found.time, found.state, found.pair);
    const Isometry3d reference_T_world = cell.worldPoseOf(cell.reference, at(found.time)).inverse();
    const Vector3d a = reference_T_world * cell.worldPoseOf(balls.left, at(found.time)).translation();
    const Vector3d b = reference_T_world * cell.worldPoseOf(balls.right, at(found.time)).translation();
    // The closer the centres, the less exact is their direction.
    const Vector3d surface = a + kRadius * (b - a).normalized();
    const Vector3d said_a(said.point_a.x, said.point_a.y, said.point_a.z);
    ASSERT_LE((said_a - surface).norm() * std::min(1.0, (b - a).norm() / kRadius), kMotionError) << what;

    scene::MotionQuestion question;
    question.contact_distance = 0.5 * (balls.distance(cell, at(0.0)) + found.lower_bound);
    const scene::RobotTimeOfContact contact = scene.timeOfContact(pair, motion, question);
    for (int sample = 0; 0.05 * sample < contact.t_free; ++sample)
      ASSERT_GE(balls.distance(cell, at(0.05 * sample)), question.contact_distance - kRounding) << what;
    if (contact.contact && contact.t_contact > 0.0) {
      ASSERT_NEAR(balls.distance(cell, at(contact.t_contact)), question.contact_distance, kMotionError) << what;
      ++contacts;
    }
    complete += found.status == narrowphase::Status::Converged ? 1 : 0;
    const int link = cell.robot.referenceLink();
    if (link >= 0 && model.links[link].parent >= 0) ++moving_references;
  }
  EXPECT_GT(moving_references, cells / 2);
  EXPECT_GT(contacts, cells / 4);
  EXPECT_GT(complete, cells * 9 / 10) << "all but those that keep their distance";
}

}  // namespace proximity_server::node::reference_frames_test
