// The lanes prove what they say: frames lie within their error, outlines around and balls inside of the links, and
// distances within their bounds. Verdicts are those of a Scene. The bits are the same on every processor.
//
// PROXIMITY_LANE_STATES: how many states of each robot are compared.
#include "scene/lanes/lane_bounds.h"

#include "from_environment.h"
#include "proximity_server/narrowphase/shape/support.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/kinematics.h"
#include "sanitized.h"
#include "scene/batch/batch_robots.h"
#include "scene/batch/verdicts.h"
#include "scene/lanes/link_outline.h"
#include "scene/posed_scene.h"
#include "scene/random_states.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace proximity_server::scene::lane_bounds_test {

using Eigen::Isometry3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Kind = StateVerdict::Kind;
using Model = std::shared_ptr<const SceneModel>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

int statesToTest() { return static_cast<int>(fromEnvironment("PROXIMITY_LANE_STATES", repeats(200))); }

Vector3d randomVector(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return {normal(random), normal(random), normal(random)};
}

/// A chain of joints of all kinds about any axes, with long and short links. `size` [m] of the links.
Model randomChain(unsigned seed, double size = 1.0) {
  std::mt19937_64 random(seed);
  const auto text = [&](double scale) {
    const Vector3d v = scale * randomVector(random);
    std::ostringstream stream;
    stream << v.x() << " " << v.y() << " " << v.z();
    return stream.str();
  };
  const char* types[] = {"revolute", "continuous", "prismatic", "revolute", "fixed", "planar", "floating"};
  std::ostringstream box, radius;
  box << "<box size='" << 0.1 * size << " " << 0.2 * size << " " << 0.05 * size << "'/>";
  radius << 0.05 * size;
  std::string parts = link("l0", ball(radius.str()));
  for (int i = 1; i <= 14; ++i) {
    const std::string name = "l" + std::to_string(i), type = types[random() % 7];
    const double length = size * std::pow(10.0, std::uniform_real_distribution<double>(-3.0, 0.5)(random));
    const std::string place = text(0.1 * size), xyz = text(length), rpy = text(2.0), direction = text(1.0);
    parts += link(name, collision(box.str(), place)) + joint("to_" + name, type, "l" + std::to_string(i - 1), name,
                                                             origin(xyz, rpy) + axis(direction) + limits("-2", "1.5"));
  }
  return modelOf(urdfOf(parts));
}

struct NamedModel {
  std::string name;
  Model model;
};

std::vector<NamedModel> robots() {
  std::vector<NamedModel> robots;
  for (const char* name : {"TwoArms", "Beads", "JoinedArms", "Solids", "SolidsInParts", "Demo", "Panda", "Ur5", "Pr2"})
    if (const Model model = robotNamed(name)) robots.push_back({name, model});
  for (unsigned seed = 1; seed <= 4; ++seed) robots.push_back({"chain " + std::to_string(seed), randomChain(seed)});
  robots.push_back({"chain of kilometres", randomChain(5, 1e3)});
  robots.push_back({"chain of millimetres", randomChain(6, 1e-3)});
  return robots;
}

/// Within the ranges of the joints; every fifth state has angles of many turns.
MatrixXd statesOfManyTurns(const RobotModel& robot, int count, unsigned seed) {
  std::mt19937_64 random(seed);
  const std::vector<JointRange> ranges = jointRanges(robot);
  MatrixXd states(count, static_cast<Eigen::Index>(robot.joints.size()));
  for (int i = 0; i < count; ++i) {
    const Positions positions = randomPositions(robot, ranges, random);
    for (std::size_t j = 0; j < positions.size(); ++j) {
      const bool turns = robot.joints[j].type != Joint::Type::Prismatic && i % 5 == 4;
      states(i, static_cast<Eigen::Index>(j)) = positions[j] * (turns ? 1000.0 : 1.0);
    }
  }
  return states;
}

std::vector<const lanes::Kernels*> allKernels() {
  std::vector<const lanes::Kernels*> all;
  for (const lanes::Kernels* const* kernels = lanes::allKernels(); *kernels; ++kernels) all.push_back(*kernels);
  return all;
}

std::vector<int> numbers(int count) {
  std::vector<int> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

TEST(LaneKernels, SineAndCosineAreWithinTheirError) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> exponent(-6.0, std::log10(lanes::kMostAngle)), sign(-1.0, 1.0);
  lanes::WideRow sines, cosines;
  std::vector<double> angles(lanes::kBlock);
  double most = 0.0;
  for (int round = 0; round < 2 * statesToTest(); ++round) {
    for (int i = 0; i < lanes::kBlock; ++i) {
      double angle = std::copysign(std::pow(10.0, exponent(random)), sign(random));
      if (i % 4 == 0) angle = std::remainder(angle, 2.0 * std::acos(-1.0));
      if (i % 16 == 1)
        angle = std::nextafter(std::acos(-1.0) / 4.0 * static_cast<double>(random() % 1000), sign(random));
      angles[i] = angle;
    }
    lanes::kernels().sinesAndCosines(angles.data(), lanes::kBlock, sines, cosines);
    for (int i = 0; i < lanes::kBlock; ++i) {
      const double angle = angles[i];
      most = std::max({most, std::abs(sines[i] - std::sin(angle)), std::abs(cosines[i] - std::cos(angle))});
    }
  }
  EXPECT_LT(most, lanes::kSineError);
  EXPECT_GT(most, 0.3 * lanes::kSineError);
}

TEST(LaneBounds, FramesAreWithinTheirError) {
  for (const NamedModel& robot : robots()) {
    SCOPED_TRACE(robot.name);
    const auto model = std::make_shared<const LaneModel>(*robot.model, Volumes(robot.model->robot));
    LaneBounds bounds(model);
    const int count = statesToTest();
    const MatrixXd states = statesOfManyTurns(robot.model->robot, count, 3);
    double most = 0.0;
    for (int first = 0; first < count; first += LaneBounds::kBlock) {
      const int placed = std::min(LaneBounds::kBlock, count - first);
      bounds.place(states.middleRows(first, placed));
      for (int i = 0; i < placed; ++i) {
        ASSERT_TRUE(bounds.isPlaced(i));
        const BodyPoses poses = forwardKinematics(robot.model->robot, positionsOf(states, first + i));
        const std::vector<Isometry3d> in_lanes = bounds.bodyPoses(i);
        for (std::size_t body = 0; body < poses.size(); ++body) {
          const Isometry3d& pose = in_lanes[body];
          const LaneError& error = model->body_errors[body];
          const double turned = (pose.linear() - poses[body]->linear()).norm();
          const double moved = (pose.translation() - poses[body]->translation()).norm();
          ASSERT_LE(turned, error.rotation + 1e-14);
          ASSERT_LE(moved, error.origin + 1e-14);
          ASSERT_LE(poses[body]->translation().norm(), error.reach + 1e-14);
          if (error.rotation > 0.0) most = std::max(most, turned / error.rotation);
        }
      }
    }
    EXPECT_GT(most, 0.01);  // a bound, and not a guess of any size
  }
}

/// How far a link sticks out of what its outline says, along a direction.
double uncoveredAlong(const Vector3d& direction, const LinkOutline& outline, std::size_t corners, double uncovered,
                      double extent) {
  double height = -kInfinity;
  for (std::size_t i = 0; i < corners; ++i)
    height = std::max(height, direction.dot(outline.corners[i].centre) + outline.corners[i].radius);
  return extent - (height + uncovered);
}

TEST(LinkOutline, ContainsTheLinkAndItsBallsAreInside) {
  std::mt19937_64 random(9);
  int balls = 0, simplified = 0;
  for (const NamedModel& robot : robots()) {
    SCOPED_TRACE(robot.name);
    const RobotModel& model = robot.model->robot;
    const Volumes volumes(model);
    for (int link = 0; link < static_cast<int>(model.links.size()); ++link) {
      if (!model.hasGeometry(link)) continue;
      const LinkOutline outline = outlineOf(model, link, volumes[link].bounds);
      const std::vector<const Piece*> pieces = peers::piecesOfLink(model, link);
      simplified += outline.coarse_corners < outline.corners.size() ? 1 : 0;
      for (int i = 0; i < repeats(300); ++i) {
        const Vector3d direction = randomVector(random).normalized();
        double extent = -kInfinity;
        for (const Piece* piece : pieces) {
          int vertex = 0;
          const Vector3d in_piece = piece->body_T_piece.linear().transpose() * direction;
          const Vector3d point = piece->body_T_piece * narrowphase::supportPoint(piece->shape, in_piece, vertex) +
                                 piece->shape.margin() * direction;
          extent = std::max(extent, direction.dot(point));
          const Vector3d in_box = outline.bounds.axes.transpose() * (point - outline.bounds.centre);
          ASSERT_LE((in_box.cwiseAbs() - outline.bounds.half).maxCoeff(), 0.0);
          ASSERT_LE(in_box.norm(), outline.bounds.radius);
        }
        ASSERT_LE(uncoveredAlong(direction, outline, outline.corners.size(), outline.uncovered, extent), 1e-14);
        ASSERT_LE(uncoveredAlong(direction, outline, outline.coarse_corners, outline.coarse_uncovered, extent), 1e-14);
      }
      for (const Ball& ball : outline.inner) {
        // The ball moved into the piece by its depth is as deep as it can be: no translation shorter than its radius
        // and that of a small ball at its centre takes the small ball out.
        double deepest = kInfinity;
        for (const Piece* piece : pieces) {
          Isometry3d piece_T_ball = Isometry3d::Identity();
          piece_T_ball.translation() = piece->body_T_piece.inverse() * ball.centre;
          deepest = std::min(deepest, signedDistance(piece->shape, narrowphase::Sphere{1e-3}, piece_T_ball).distance);
        }
        ASSERT_LE(deepest, -(ball.radius + 1e-3) + 2e-9);
        ++balls;
      }
    }
  }
  EXPECT_GT(balls, 100);
  EXPECT_GT(simplified, 3);
}

TEST(LaneBounds, HoldTheSignedDistance) {
  for (const NamedModel& robot : robots()) {
    SCOPED_TRACE(robot.name);
    LaneBounds bounds(*robot.model);
    PosedScene scene(robot.model);
    const Candidates& candidates = scene.candidates();
    const int count = std::min(LaneBounds::kBlock, statesToTest() / 10);
    const MatrixXd states = statesOfManyTurns(robot.model->robot, count, 21);
    bounds.place(states);
    const std::vector<int> all = numbers(count);
    std::vector<std::vector<float>> lower(candidates.size()), upper(candidates.size());
    std::vector<std::vector<int>> near(candidates.size());
    const std::vector<double> limits(LaneBounds::kBlock, 0.2);
    for (std::size_t pair = 0; pair < candidates.size(); ++pair) {
      lower[pair].resize(all.size());
      upper[pair].resize(all.size());
      bounds.bounds(static_cast<int>(pair), all.data(), count, lower[pair].data(), upper[pair].data());
      std::vector<float> alone(all.size());
      bounds.lowerBounds(static_cast<int>(pair), all.data(), count, 0.2, alone.data());
      for (std::size_t i = 0; i < all.size(); ++i) {
        ASSERT_LE(alone[i], lower[pair][i]);
        ASSERT_EQ(alone[i] > 0.2F, lower[pair][i] > 0.2F);
      }
      near[pair].resize(LaneBounds::kBlock);
      near[pair].resize(bounds.findNear(static_cast<int>(pair), limits.data(), near[pair].data()));
    }
    int with_upper = 0, narrow = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      scene.update(forwardKinematics(robot.model->robot, positionsOf(states, static_cast<Eigen::Index>(i))));
      for (std::size_t pair = 0; pair < candidates.size(); ++pair) {
        const narrowphase::SignedDistance truth = scene.proximity(candidates[pair]).result;
        // The truth is between its bounds.
        ASSERT_LE(static_cast<double>(lower[pair][i]), truth.upper_bound);
        ASSERT_GE(static_cast<double>(upper[pair][i]), truth.lower_bound);
        // Balls that are far prove it, in all states at once and in one.
        ASSERT_LE(bounds.ballGap(static_cast<int>(pair), static_cast<int>(i)), truth.upper_bound);
        if (truth.upper_bound <= 0.2) {
          ASSERT_TRUE(std::binary_search(near[pair].begin(), near[pair].end(), static_cast<int>(i)));
        }
        with_upper += std::isfinite(upper[pair][i]) ? 1 : 0;
        narrow += upper[pair][i] - lower[pair][i] < 0.05F ? 1 : 0;
      }
    }
    if (!kIsSanitized && !candidates.empty()) {
      EXPECT_GT(with_upper, 0);
      EXPECT_GT(narrow, 0);
    }
  }
}

// As near to the distance as float allows, so that a bound without its error is noticed.
TEST(LaneBounds, OfPiecesHoldTheSignedDistance) {
  for (const NamedModel& robot : robots()) {
    SCOPED_TRACE(robot.name);
    LaneBounds bounds(*robot.model);
    PosedScene scene(robot.model);
    const Candidates& candidates = scene.candidates();
    const int count = std::min(LaneBounds::kBlock, statesToTest());
    const MatrixXd states = statesOfManyTurns(robot.model->robot, count, 57);
    bounds.place(states);
    const std::vector<int> all = numbers(count);
    const std::vector<double> no_limits(all.size(), kInfinity);
    int apart = 0, narrow = 0, overlaps = 0, proven_overlaps = 0;
    std::vector<float> lower(all.size()), upper(all.size()), limited_lower(all.size()), limited_upper(all.size());
    std::vector<double> limits(all.size());
    for (int pair = 0; pair < static_cast<int>(candidates.size()); ++pair) {
      bounds.bounds(pair, all.data(), count, lower.data(), upper.data());
      limited_lower = lower;
      limited_upper = upper;
      bounds.boundPieces(pair, all.data(), count, no_limits.data(), 1e-12, lower.data(), upper.data());
      for (std::size_t i = 0; i < all.size(); ++i)
        limits[i] = static_cast<double>(lower[i]) - (i % 2 == 0 ? 0.01 : 0.0);
      bounds.boundPieces(pair, all.data(), count, limits.data(), 1e-3, limited_lower.data(), limited_upper.data());
      for (int i = 0; i < count; i += robot.name == "Pr2" ? 10 : 1) {
        scene.update(forwardKinematics(robot.model->robot, positionsOf(states, i)));
        const narrowphase::SignedDistance truth = scene.proximity(candidates[pair]).result;
        ASSERT_LE(static_cast<double>(lower[i]), truth.upper_bound);
        ASSERT_GE(static_cast<double>(upper[i]), truth.lower_bound);
        ASSERT_LE(static_cast<double>(limited_lower[i]), truth.upper_bound);
        ASSERT_GE(static_cast<double>(limited_upper[i]), truth.lower_bound);
        if (truth.distance > 0.0) {
          ++apart;
          narrow += upper[i] - lower[i] < 2e-5F ? 1 : 0;
        } else if (truth.distance < -1e-4) {
          ++overlaps;
          proven_overlaps += upper[i] <= 0.0F ? 1 : 0;
        }
      }
    }
    RecordProperty(robot.name, std::to_string(narrow) + " of " + std::to_string(apart) + " apart are narrow, " +
                                   std::to_string(proven_overlaps) + " of " + std::to_string(overlaps) +
                                   " overlaps are proven");
    // Those that are not have cylinders, or may be inside of a solid; at kilometres float is coarser.
    if (!kIsSanitized && (robot.name == "Panda" || robot.name == "Ur5")) {
      EXPECT_GT(narrow, 0.99 * apart);
      EXPECT_GT(proven_overlaps, 0.9 * overlaps);
    }
  }
}

/// Every point of the ball of a link, in every two states.
TEST(LaneBounds, NoPointMovesFartherThanTheTravelOfItsLink) {
  for (const NamedModel& robot : robots()) {
    SCOPED_TRACE(robot.name);
    const auto model = std::make_shared<const LaneModel>(*robot.model, Volumes(robot.model->robot));
    const std::size_t links = model->links.size();
    const int count = 40;
    const MatrixXd states = statesAlongEdges(robot.model->robot, count, 17);
    LaneBounds bounds(model);
    bounds.place(states);
    std::vector<double> travel(LaneBounds::kBlock * links);
    bounds.travel(travel.data());
    std::vector<BodyPoses> poses;
    for (Eigen::Index i = 0; i < count; ++i)
      poses.push_back(forwardKinematics(robot.model->robot, positionsOf(states, i)));
    Chance chance(18);
    double most = 0.0;
    for (std::size_t point = 0; point < 10 * links; ++point) {
      const std::size_t link = point % links;
      const lanes::LinkPlan& plan = model->links[link];
      const Vector3d direction(chance.between(-1.0, 1.0), chance.between(-1.0, 1.0), chance.between(-1.0, 1.0));
      const double radius = static_cast<double>(model->link_balls[link].radius);
      const Vector3d in_body = Eigen::Map<const Vector3d>(plan.origin) + radius * direction.normalized();
      for (std::size_t to = 0; to < poses.size(); ++to)
        for (std::size_t from = 0; from < to; ++from) {
          const double moved = (*poses[to][plan.body] * in_body - *poses[from][plan.body] * in_body).norm();
          const double bound = travel[to * links + link] - travel[from * links + link];
          ASSERT_LE(moved, bound);
          if (to == from + 1) most = std::max(most, moved / bound);
        }
    }
    if (!model->pairs.empty()) {
      EXPECT_GT(most, 0.5);
    }
  }
}

TEST(LaneBounds, EveryKindOfProcessorGivesTheSameBits) {
  const std::vector<const lanes::Kernels*> kernels = allKernels();
  ASSERT_FALSE(kernels.empty());
  EXPECT_STREQ(kernels.back()->name, "baseline");
  for (const NamedModel& robot : robots()) {
    SCOPED_TRACE(robot.name);
    const auto model = std::make_shared<const LaneModel>(*robot.model, Volumes(robot.model->robot));
    const int count = LaneBounds::kBlock - 5;
    const MatrixXd states = statesOfManyTurns(robot.model->robot, count, 33);
    const std::vector<int> all = numbers(count);
    LaneBounds expected(model, *kernels.front());
    expected.place(states);
    std::vector<float> lower(all.size()), upper(all.size()), other_lower(all.size()), other_upper(all.size());
    std::vector<double> limits(all.size(), kInfinity);
    for (std::size_t i = 0; i < limits.size(); i += 2) limits[i] = 0.1;
    std::vector<double> thresholds(LaneBounds::kBlock, -kInfinity);
    for (std::size_t i = 0; i < limits.size(); i += 3) thresholds[i] = 0.01 * static_cast<double>(i % 50);
    for (std::size_t k = 1; k < kernels.size(); ++k) {
      SCOPED_TRACE(kernels[k]->name);
      LaneBounds other(model, *kernels[k]);
      other.place(states);
      for (int i = 0; i < count; ++i) {
        const std::vector<Isometry3d> expected_poses = expected.bodyPoses(i), other_poses = other.bodyPoses(i);
        for (std::size_t body = 0; body < model->bodies.size(); ++body)
          ASSERT_EQ(expected_poses[body].matrix(), other_poses[body].matrix());
      }
      std::vector<double> travel(all.size() * model->links.size()), other_travel(travel.size());
      expected.travel(travel.data());
      other.travel(other_travel.data());
      ASSERT_EQ(travel, other_travel);
      for (int pair = 0; pair < static_cast<int>(model->pairs.size()); ++pair) {
        expected.bounds(pair, all.data(), count, lower.data(), upper.data());
        other.bounds(pair, all.data(), count, other_lower.data(), other_upper.data());
        ASSERT_EQ(lower, other_lower);
        ASSERT_EQ(upper, other_upper);
        expected.boundPieces(pair, all.data(), count, limits.data(), 1e-6, lower.data(), upper.data());
        other.boundPieces(pair, all.data(), count, limits.data(), 1e-6, other_lower.data(), other_upper.data());
        ASSERT_EQ(lower, other_lower);
        ASSERT_EQ(upper, other_upper);
        expected.lowerBounds(pair, all.data(), count, 0.05, lower.data());
        other.lowerBounds(pair, all.data(), count, 0.05, other_lower.data());
        for (std::size_t i = 0; i < lower.size(); ++i) ASSERT_EQ(lower[i] > 0.05F, other_lower[i] > 0.05F);
        ASSERT_EQ(expected.sides(pair, 0.05, all.data(), count), other.sides(pair, 0.05, all.data(), count));
        std::vector<int> near = all, other_near = all;
        near.resize(expected.keepNear(pair, 0.05, near.data(), count));
        other_near.resize(other.keepNear(pair, 0.05, other_near.data(), count));
        ASSERT_EQ(near, other_near);
        near = other_near = std::vector<int>(LaneBounds::kBlock);
        near.resize(expected.findNear(pair, thresholds.data(), near.data()));
        other_near.resize(other.findNear(pair, thresholds.data(), other_near.data()));
        ASSERT_EQ(near, other_near);
      }
    }
  }
}

// With thresholds as near to the distance as can be, so that a bound without its error is noticed.
TEST(LaneBounds, ProveNoSideOfAThresholdThatIsWrong) {
  int above = 0, below = 0;
  for (const NamedModel& robot : robots()) {
    SCOPED_TRACE(robot.name);
    LaneBounds bounds(*robot.model);
    PosedScene scene(robot.model);
    const int count = std::min(LaneBounds::kBlock, repeats(20));
    const MatrixXd states = statesOfManyTurns(robot.model->robot, count, 22);
    bounds.place(states);
    std::vector<double> thresholds(LaneBounds::kBlock, -kInfinity);
    std::vector<int> near(LaneBounds::kBlock);
    for (int i = 0; i < count; ++i) {
      scene.update(forwardKinematics(robot.model->robot, positionsOf(states, i)));
      for (int pair = 0; pair < static_cast<int>(scene.candidates().size()); ++pair) {
        const narrowphase::SignedDistance truth = scene.proximity(scene.candidates()[pair]).result;
        const double not_above = truth.upper_bound, not_below = truth.lower_bound - 1e-12;
        int state = i;
        ASSERT_EQ(bounds.keepNear(pair, not_above, &state, 1), 1);
        thresholds[i] = not_above;
        ASSERT_EQ(bounds.findNear(pair, thresholds.data(), near.data()), 1);
        ASSERT_EQ(near.front(), i);
        ASSERT_NE(bounds.sides(pair, not_above, &i, 1).front(), LaneBounds::Side::Above);
        ASSERT_NE(bounds.sides(pair, not_below, &i, 1).front(), LaneBounds::Side::Below);
        above += bounds.sides(pair, not_below - 0.01, &i, 1).front() == LaneBounds::Side::Above ? 1 : 0;
        below += bounds.sides(pair, not_above + 0.05, &i, 1).front() == LaneBounds::Side::Below ? 1 : 0;
      }
      thresholds[i] = -kInfinity;
    }
  }
  if (!kIsSanitized) {
    EXPECT_GT(above, 1000);
    EXPECT_GT(below, 1000);
  }
}

/// Whether anything is below, by one Scene for the state.
Kind kindByScene(PosedScene& scene, const RobotModel& robot, const std::vector<double>& positions, double distance) {
  Question question;
  question.threshold = distance;
  scene.update(forwardKinematics(robot, positions));
  for (const ShapeRefPair& pair : scene.candidates())
    if (!(scene.proximity(pair, question).result.lower_bound > distance)) return Kind::Below;
  return Kind::Above;
}

TEST(Verdicts, AreThoseOfAScene) {
  int below = 0, above = 0;
  for (const NamedModel& robot : robots()) {
    SCOPED_TRACE(robot.name);
    Verdicts verdicts(std::make_shared<const BatchModel>(robot.model));
    PosedScene scene(robot.model, Skipping::On);
    const int count = statesToTest() / 2;
    const MatrixXd states = statesOfManyTurns(robot.model->robot, count, 41);
    for (const double distance : {-0.02, 0.0, 0.05, 0.3}) {
      const std::vector<StateVerdict>& found = verdicts.anyBelow(states, distance);
      for (int i = 0; i < count; ++i) {
        const std::vector<double> positions = positionsOf(states, i);
        const StateVerdict& verdict = found[i];
        ASSERT_EQ(verdict.kind, kindByScene(scene, robot.model->robot, positions, distance)) << i << " at " << distance;
        if (verdict.kind == Kind::Below) {
          Question question;
          question.threshold = distance;
          const ShapeRefPair& pair = scene.candidates()[verdict.pair];
          ASSERT_FALSE(scene.proximity(pair, question).result.lower_bound > distance);
        } else {
          ASSERT_EQ(verdict.pair, -1);
        }
        ++(verdict.kind == Kind::Below ? below : above);
      }
    }
  }
  if (!kIsSanitized) {
    EXPECT_GT(below, 1000);
    EXPECT_GT(above, 1000);
  }
}

TEST(Verdicts, DependOnTheStateAlone) {
  for (const char* name : {"TwoArms", "Solids", "Panda"}) {
    const Model model = robotNamed(name);
    if (!model) continue;
    SCOPED_TRACE(name);
    const auto batch = std::make_shared<const BatchModel>(model);
    Verdicts verdicts(batch), in_other_order(batch);
    const int count = 2 * LaneBounds::kBlock + 77;
    const MatrixXd states = statesOfManyTurns(model->robot, count, 43);
    const std::vector<StateVerdict> expected = verdicts.anyBelow(states, 0.05);
    std::mt19937_64 random(1);
    std::vector<int> order = numbers(count);
    std::shuffle(order.begin(), order.end(), random);
    MatrixXd shuffled(states.rows(), states.cols());
    for (int i = 0; i < count; ++i) shuffled.row(i) = states.row(order[i]);
    for (int first = 0, size = 1; first < count; first += size, size = size * 3 % 401 + 1) {
      size = std::min(size, count - first);
      const MatrixXd part = shuffled.middleRows(first, size);
      const std::vector<StateVerdict>& found = in_other_order.anyBelow(part, 0.05);
      for (int i = 0; i < size; ++i) {
        const StateVerdict& other = expected[order[first + i]];
        ASSERT_EQ(found[i].kind, other.kind);
        ASSERT_EQ(found[i].pair, other.pair);
      }
    }
  }
}

TEST(Verdicts, StatesBeyondTheLanesAreDecidedExactly) {
  const Model model = robotNamed("TwoArms");
  const auto batch = std::make_shared<const BatchModel>(model);
  MatrixXd states = statesOfManyTurns(model->robot, 40, 47);
  for (int i = 0; i < 20; ++i) states(i, i % states.cols()) = i % 2 == 0 ? 3e5 : -1e12;
  states(30, 1) = std::numeric_limits<double>::quiet_NaN();
  states(31, 2) = kInfinity;
  LaneBounds lanes(batch->lanes);
  lanes.place(states);
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(lanes.isPlaced(i)) << i;
  Verdicts verdicts(batch);
  const std::vector<StateVerdict>& found = verdicts.anyBelow(states, 0.05);
  PosedScene scene(model);
  for (int i = 0; i < 40; ++i) {
    const Kind kind = found[i].kind;
    if (i == 30 || i == 31) {
      EXPECT_EQ(kind, Kind::Unknown);
    } else {
      EXPECT_EQ(kind, kindByScene(scene, model->robot, positionsOf(states, i), 0.05)) << i;
    }
  }
}

TEST(Verdicts, OfNoPairsAndOfInfiniteDistances) {
  Verdicts nothing(std::make_shared<const BatchModel>(nothingToCheck()));
  EXPECT_EQ(nothing.anyBelow(MatrixXd::Zero(3, 1), 1.0)[2].kind, Kind::Above);
  EXPECT_TRUE(nothing.anyBelow(MatrixXd::Zero(0, 1), 1.0).empty());
  const Model model = robotNamed("TwoArms");
  Verdicts verdicts(std::make_shared<const BatchModel>(model));
  const MatrixXd states = statesOfManyTurns(model->robot, 10, 3);
  EXPECT_EQ(verdicts.anyBelow(states, kInfinity)[4].kind, Kind::Below);
  EXPECT_EQ(verdicts.anyBelow(states, -kInfinity)[4].kind, Kind::Above);
}

}  // namespace proximity_server::scene::lane_bounds_test
