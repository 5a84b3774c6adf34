#include "proximity_server/scene/derivative/free_motion.h"

#include "scene/bounds/seen_bounds.h"
#include "scene/model/numbers.h"
#include "scene/objects/placed_object.h"
#include "scene/scene_model/given_model.h"
#include "scene/state/volumes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {

using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

void requireFinite(const FreeMotionQuestion& question) {
  if (!question.thresholds.areFinite() || !std::isfinite(question.influence_distance))
    throw std::invalid_argument("the thresholds and the influence distance of a free motion must be finite");
}

}  // namespace

FreeMotion::FreeMotion(std::shared_ptr<const SceneModel> model) : model_(std::move(model)) {
  const DegreesOfFreedom columns(given(model_).robot);
  scratch_.setZero(columns.size());
  sides_.setZero(columns.size());
  for (std::size_t joint = 0; joint < model_->robot.joints.size(); ++joint)
    sides_.segment(columns.columnsOf(static_cast<int>(joint)).first, columns.columnsOf(static_cast<int>(joint)).count)
        .array() += 1.0;
  sides_ = sides_.cwiseMin(2.0);
  is_checked_.assign(model_->robot.links.size(), false);
  for (const LinkPair& pair : model_->pairs.pairs)
    if (pair.reason == PairReason::Checked) is_checked_[pair.link_a] = is_checked_[pair.link_b] = true;
}
// --- weights

/// Adds the weights of the joints that carry `body`, but not the other one, for the points of a shape.
bool FreeMotion::addWeights(const State& state, const ShapeRef& moved, int body, int other_body,
                            Eigen::Ref<VectorXd> weights) const {
  if (body < 0) return true;
  const std::optional<Eigen::Isometry3d> pose = state.poseOf(moved);
  if (!pose || !state.knowsBetween(body, other_body)) return false;
  const Bounds& bounds = state.volumes()->part(moved, state.objects().get()).whole().bounds;
  const RobotModel& robot = state.robot();
  state.forEachBetween(body, other_body, [&](int carried, State::Side side) {
    if (side != State::Side::A) return;
    const int joint = robot.bodies[carried].joint;
    const JointTwists twists = state.twistsOf(carried);
    const DegreesOfFreedom::Columns& own = state.degreesOfFreedom().columnsOf(joint);
    const SeenBounds seen(bounds, *pose, state.poses()[carried]->translation());
    for (int i = 0; i < twists.count; ++i) {
      const Vector3d& axis = twists.twists[i].angular;
      double weight = 1.0 + kPoseRounding;  // of a translation
      if (!axis.isZero(0.0))
        weight = robot.joints[joint].type == Joint::Type::Floating ? radiusAboutOrigin(seen) : radiusAbout(axis, seen);
      weights[own.first + i] += std::abs(own.multiplier) * weight;
    }
  });
  return true;
}

bool FreeMotion::weights(const State& state, const ShapeRefPair& pair, Eigen::Ref<VectorXd> weights) const {
  state.requireModel(*model_);
  if (weights.size() != state.degreesOfFreedom().size())
    throw std::invalid_argument("the robot has " + std::to_string(state.degreesOfFreedom().size()) +
                                " degrees of freedom, but there is room for " + std::to_string(weights.size()));
  state.volumes()->of(pair.a), state.volumes()->of(pair.b);  // throws for a link that does not exist
  const int body_a = state.bodyOf(pair.a), body_b = state.bodyOf(pair.b);
  const auto isUnbounded = [&](const ShapeRef& ref) {
    return state.volumes()->part(ref, state.objects().get()).isUnbounded();
  };
  const ShapeRef &by_a = isUnbounded(pair.a) ? pair.b : pair.a, &by_b = isUnbounded(pair.b) ? pair.a : pair.b;
  weights.setZero();
  if (addWeights(state, by_a, body_a, body_b, weights) && addWeights(state, by_b, body_b, body_a, weights)) return true;
  weights.setConstant(std::numeric_limits<double>::quiet_NaN());
  return false;
}

// --- all pairs of a scene

/// Sets weights that no checked pair exceeds: the largest of all links and objects. A degree of freedom with mimic
/// joints may move both shapes of a pair; any other one moves only one of them. A shape without a pose is in no known
/// pair. Among objects, every link may be in a checked pair. The joints that carry a half-space move all other shapes.
bool FreeMotion::findLargestWeights(const State& state, VectorXd& weights) {
  weights.setZero();
  bool is_known = true;
  const auto consider = [&](const ShapeRef& ref, int body) {
    if (!is_known || body < 0 || !state.poseOf(ref)) return;
    scratch_.setZero();
    is_known = addWeights(state, ref, body, -1, scratch_);
    weights = weights.cwiseMax(scratch_);
  };
  forEachBounded(state, [&](const ShapeRef& ref) { consider(ref, state.bodyOf(ref)); });
  for (const int number : state.objects()->unbounded()) {
    const int body = state.bodyOf(ShapeRef::ofObject(number));
    if (body >= 0) forEachBounded(state, [&](const ShapeRef& ref) { consider(ref, body); });
  }
  weights.array() *= sides_.array();
  return is_known;
}

/// Visits all links that may be in a checked pair, and all objects without half-spaces.
template <class Visit>
void FreeMotion::forEachBounded(const State& state, const Visit& visit) const {
  const Objects& objects = *state.objects();
  for (int link = 0; link < static_cast<int>(is_checked_.size()); ++link)
    if (state.robot().hasGeometry(link) && (!objects.empty() || is_checked_[link])) visit(ShapeRef(link));
  for (const int number : objects.numbers())
    if (!objects.placed(number)->isUnbounded()) visit(ShapeRef::ofObject(number));
}

Bubble& FreeMotion::next() {
  if (size_ == static_cast<int>(bubbles_.size())) bubbles_.push_back({{}, 0.0, VectorXd(sides_.size())});
  return bubbles_[size_++];
}

void FreeMotion::find(Scene& scene, const State& state, const FreeMotionQuestion& question) {
  is_known_ = false;
  size_ = 0;
  requireFinite(question);
  Question near;
  near.threshold = question.influence_distance;
  near.deadline = question.deadline;
  const std::vector<PairProximity>& pairs = scene.below(state, scene.candidates(), near);
  const bool knows_all = scene.counts().unknown == 0;
  find(state, pairs.data(), pairs.data() + pairs.size(), question);
  is_known_ = is_known_ && knows_all;
}

void FreeMotion::find(const State& state, const PairProximity* begin, const PairProximity* end,
                      const FreeMotionQuestion& question) {
  is_known_ = false;
  size_ = 0;
  state.requireModel(*model_);
  requireFinite(question);
  bool is_known = true;
  for (const PairProximity* pair = begin; pair != end; ++pair) {
    Bubble& bubble = next();
    bubble.pair = pair->asked;
    bubble.free = std::max(0.0, pair->result.lower_bound - question.thresholds.of(pair->asked));
    is_known = is_known && weights(state, pair->asked, bubble.weights);
  }
  Bubble& others = next();
  others.pair = {};
  others.free = std::max(0.0, question.influence_distance - question.thresholds.range(PairKind::Any).largest);
  is_known_ = is_known && findLargestWeights(state, others.weights);
}

double FreeMotion::scale(const Eigen::Ref<const VectorXd>& motion) const {
  if (motion.size() != sides_.size())
    throw std::invalid_argument("the robot has " + std::to_string(sides_.size()) +
                                " degrees of freedom, but the motion is of " + std::to_string(motion.size()));
  if (!is_known_ || !motion.allFinite()) return 0.0;
  double scale = 1.0;
  for (int i = 0; i < size_; ++i) {
    const Bubble& bubble = (*this)[i];
    // The sum of n products has a relative error of at most (n + 1) eps, and the quotient of one eps.
    const double rounding = static_cast<double>(motion.size() + 4) * std::numeric_limits<double>::epsilon();
    const double change = (1.0 + rounding) * bubble.weights.dot(motion.cwiseAbs());
    if (!(change <= bubble.free)) scale = std::min(scale, bubble.free / change * (1.0 - rounding));
  }
  return scale;
}

double FreeMotion::alone(int column) const {
  if (column < 0 || column >= sides_.size())
    throw std::invalid_argument("the robot has no degree of freedom " + std::to_string(column));
  if (!is_known_) return 0.0;
  constexpr double kRoundedDown = 1.0 - 4.0 * std::numeric_limits<double>::epsilon();
  double alone = kInfinity;
  for (int i = 0; i < size_; ++i) {
    const Bubble& bubble = (*this)[i];
    if (bubble.weights[column] > 0.0) alone = std::min(alone, kRoundedDown * bubble.free / bubble.weights[column]);
  }
  return alone;
}

}  // namespace proximity_server::scene
