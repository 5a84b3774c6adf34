#include "scene/batch/exact_state.h"

#include "proximity_server/narrowphase/assertion.h"
#include "proximity_server/scene/model/kinematics.h"
#include "scene/model/body_pose.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace proximity_server::scene {

using Eigen::Isometry3d;

namespace {

// [rad] or [m] States whose joints are farther apart are not on one edge. A guess that is wrong costs one distance.
constexpr double kSmallStep = 0.1;

}  // namespace

bool areNear(const States& states, Eigen::Index a, Eigen::Index b) {
  return ((states.row(a) - states.row(b)).array().abs() <= kSmallStep).all();
}

ExactState::ExactState(std::shared_ptr<const BatchModel> batch)
    : batch_(std::move(batch)),
      robot_(std::make_unique<PlacedRobot>(batch_->model->robot, batch_->volumes)),
      measurement_(std::make_unique<PairMeasurement>(*batch_->model, Skipping::On, Memory::None)),
      poses_(batch_->model->robot.bodies.size(), Isometry3d::Identity()),
      pose_of_(poses_.size(), 0),
      body_of_(poses_.size(), 0),
      sphere_of_(static_cast<std::size_t>(batch_->volumes->rootCount()), 0),
      last_positions_(batch_->model->robot.joints.size(), kInfinity),
      guesses_(batch_->pairs.size()),
      known_(batch_->candidates.size()) {
  measurement_->see(*robot_);
  if (!batch_->objects) return;
  robot_->use(batch_->objects->objects);
  frames_.resize(batch_->objects->frame_links.size());
}

void ExactState::place(const States& states, Eigen::Index state) {
  positions_ = states.data() + state * states.rowStride();
  stride_ = states.colStride();
  ++state_;
}

// --- poses

double ExactState::positionOf(int joint) const {
  const Joint::Mimic& leader = batch_->leaders[joint];
  return followedPosition(leader, positions_[leader.joint * stride_]);
}

const Isometry3d& ExactState::poseOf(int body) {
  const auto index = static_cast<std::size_t>(body);
  const RobotModel& robot = batch_->model->robot;
  const Body& here = robot.bodies[index];
  if (here.joint < 0 || pose_of_[index] == state_) return poses_[index];  // a root body stays at the identity
  poses_[index] =
      poseOnParent(robot, here, poseOf(here.parent), jointMotion(robot.joints[here.joint], positionOf(here.joint)));
  pose_of_[index] = state_;
  return poses_[index];
}

void ExactState::placeBody(int body) {
  if (body >= static_cast<int>(poses_.size())) return placeFrames();  // the body of an object that no link holds
  std::uint64_t& state = body_of_[body];
  if (state == state_) return;
  robot_->place(body, poseOf(body));
  state = state_;
}

/// Places the moving objects. Fixed ones stand in their places.
void ExactState::placeFrames() {
  if (frames_of_ == state_ || frames_.empty()) return;
  const RobotModel& robot = batch_->model->robot;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const Link& link = robot.links[batch_->objects->frame_links[i]];
    frames_[i] = poseOf(link.body) * link.body_T_link;
  }
  robot_->placeFrames(frames_);
  frames_of_ = state_;
}

/// Chooses the origin as PlacedRobot::update() does.
void ExactState::placeOrigin() {
  if (origin_of_ == state_) return;
  PlacedRobot& robot = *robot_;
  for (int body = 0; body < static_cast<int>(poses_.size()); ++body) {
    if (!robot.hasGeometry(body)) continue;
    placeBody(body);
    if (!robot.isKnown(body)) continue;
    robot.takeOriginOf(body);
    break;
  }
  origin_of_ = state_;
}

void ExactState::placeSphere(int part) {
  PlacedRobot& robot = *robot_;
  if (robot.isObject(part)) return placeBody(robot[part].body);  // its sphere is made when it is asked
  std::uint64_t& state = sphere_of_[part];
  if (state == state_) return;
  placeBody(robot[part].body);
  robot.placeSphere(part);
  state = state_;
}

// --- pairs

/// Places all that visitOf() of the pair reads.
void ExactState::placePair(int pair) {
  PROXIMITY_ASSERT(narrowphase::isPlace(pair, batch_->pairs.size()),
                   "No pair has this number: they are numbered as in BatchModel::pairs.");
  const Visit& visit = visitOf(pair);
  placeOrigin();
  placeSphere(visit.a);
  placeSphere(visit.b);
}

/// Compares the state with the last one that was compared, and takes its place.
void ExactState::takeStep() {
  if (compared_ == state_) return;
  compared_ = state_;
  bool is_near = true;
  for (std::size_t joint = 0; joint < last_positions_.size(); ++joint) {
    const double position = positions_[static_cast<Eigen::Index>(joint) * stride_];
    is_near &= std::abs(position - last_positions_[joint]) <= kSmallStep;
    last_positions_[joint] = position;
  }
  if (!is_near) edge_begin_ = state_;
}

bool ExactState::isNearLast() {
  takeStep();
  return edge_begin_ != state_;
}

/// The pieces of a pair that were the closest the last time on this edge, and the place for the pieces of this state.
LeafPair* ExactState::guessFor(int pair) {
  takeStep();
  Guess& guess = guesses_[pair];
  if (guess.state < edge_begin_) guess.leaves = {};
  guess.state = state_;
  return &guess.leaves;
}

bool ExactState::isBelow(int pair, double distance) {
  const std::optional<Visit> visit = boundedWithin(pair, distance);
  return visit && isBelow(*visit, distance);
}

std::optional<Visit> ExactState::boundedWithin(int pair, double distance) {
  placePair(pair);
  std::optional<Visit> visit = measurement_->visitOf(refsOf(pair), pair);
  if (visit && !(visit->lower_bound > distance)) visit = measurement_->refined(*visit, distance);
  return visit && visit->lower_bound > distance ? std::nullopt : visit;
}

PairProximity ExactState::proximity(int pair, double threshold) {
  placePair(pair);
  Question question;
  question.threshold = threshold;
  return measurement_->settle(refsOf(pair), question, guessFor(pair));
}

Representation ExactState::representationOf(const PartPair& pair) const {
  const PlacedRobot& robot = *robot_;
  return std::max(robot[pair.a].whole().representation, robot[pair.b].whole().representation);
}

bool ExactState::isPlaced(const Visit& visit) {
  const PlacedRobot& robot = *robot_;
  const int body_a = robot[visit.a].body, body_b = robot[visit.b].body;
  placeBody(body_a);
  placeBody(body_b);
  return robot.isKnown(body_a) && robot.isKnown(body_b);
}

bool ExactState::isPlaced() {
  return std::all_of(batch_->visits.begin(), batch_->visits.end(), [&](const Visit& visit) { return isPlaced(visit); });
}

Visit ExactState::refined(Visit visit, double limit) const {
  const auto pair = static_cast<std::size_t>(visit.number);
  if (pair < known_.size() && known_[pair].lower_bound > limit) {
    const PlacedRobot& robot = *robot_;
    const RelativeMotionBound motion = PlacedRobot::relativeMotion(robot[visit.a], robot[visit.b], known_[pair].a_T_b,
                                                                   robot.relative(visit.a, visit.b));
    visit.lower_bound = std::max(visit.lower_bound, known_[pair].lower_bound - motion.distance_change);
  }
  return visit.lower_bound > limit ? visit : measurement_->refined(visit, limit);
}

void ExactState::keepBound(const Visit& visit, double lower_bound) {
  const auto pair = static_cast<std::size_t>(visit.number);
  if (pair < known_.size() && isNearLast()) known_[pair] = {robot_->relative(visit.a, visit.b), lower_bound};
}

PairProximity ExactState::measure(const Visit& visit, double limit) {
  return measurement_->measure(refsOf(visit.number), visit, limit, {}, guessFor(visit.number));
}

PairProximity ExactState::measure(const Visit& visit, double limit, const Question& question) {
  return measurement_->measure(refsOf(visit.number), visit, limit, question);
}

}  // namespace proximity_server::scene
