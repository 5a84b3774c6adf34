#include "proximity_server/scene/derivative/derivatives.h"

#include "scene/derivative/contact_feature.h"
#include "scene/scene_model/given_model.h"

#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {
namespace {

void requireSize(Eigen::Index size, const DegreesOfFreedom& columns) {
  if (size != columns.size())
    throw std::invalid_argument("the robot has " + std::to_string(columns.size()) +
                                " degrees of freedom, but the vector has " + std::to_string(size) + " entries");
}

}  // namespace

bool gradient(const State& state, const PairProximity& pair, Eigen::Ref<Eigen::VectorXd> gradient) {
  const DegreesOfFreedom& columns = state.degreesOfFreedom();
  requireSize(gradient.size(), columns);
  const narrowphase::SignedDistance& result = pair.result;
  const int body_a = state.bodyOf(pair.asked.a), body_b = state.bodyOf(pair.asked.b);
  if (result.status == narrowphase::Status::Unknown || !result.has_points || !state.knowsBetween(body_a, body_b)) {
    gradient.setConstant(std::numeric_limits<double>::quiet_NaN());
    return false;
  }
  gradient.setZero();
  state.forEachBetween(body_a, body_b, [&](int body, State::Side side) {
    const bool carries_a = side == State::Side::A;
    const Eigen::Vector3d point = carries_a ? result.point_a : result.point_b;
    const Eigen::Vector3d away = carries_a ? Eigen::Vector3d(-result.normal) : result.normal;
    const JointTwists twists = state.twistsOf(body);
    const auto& own = columns.columnsOf(state.robot().bodies[body].joint);
    for (int i = 0; i < twists.count; ++i)
      gradient[own.first + i] += own.multiplier * away.dot(twists.twists[i].velocityAt(point));
  });
  return true;
}

void gradient(const State& state, const PairProximity& pair, std::vector<double>& gradient) {
  gradient.resize(static_cast<std::size_t>(state.degreesOfFreedom().size()));
  Eigen::Map<Eigen::VectorXd> columns(gradient.data(), state.degreesOfFreedom().size());
  if (!scene::gradient(state, pair, columns) || !columns.allFinite()) gradient.clear();
}

Derivatives::Derivatives(std::shared_ptr<const SceneModel> model)
    : model_(std::move(model)),
      features_(std::make_unique<ContactFeatures>(given(model_))),
      row_(DegreesOfFreedom(model_->robot).size()) {}
Derivatives::~Derivatives() = default;
Derivatives::Derivatives(Derivatives&&) noexcept = default;
Derivatives& Derivatives::operator=(Derivatives&&) noexcept = default;

double Derivatives::rate(const State& state, const PairProximity& pair,
                         const Eigen::Ref<const Eigen::VectorXd>& velocity) {
  state.requireModel(*model_);
  requireSize(velocity.size(), state.degreesOfFreedom());
  if (!gradient(state, pair, row_)) return std::numeric_limits<double>::quiet_NaN();
  const double at_points = row_.dot(velocity);
  if (pair.result.unique) return at_points;
  // If the witness pair moves by x, the rate changes by n . (turn x x) = (n x turn) . x.
  const Eigen::Vector3d turn = state.relativeTurn(state.bodyOf(pair.asked.a), state.bodyOf(pair.asked.b), velocity);
  return at_points + features_->minimum(state, pair, pair.result.normal.cross(turn));
}

}  // namespace proximity_server::scene
