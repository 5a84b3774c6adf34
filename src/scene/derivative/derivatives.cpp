#include "proximity_server/scene/derivative/derivatives.h"

#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "scene/derivative/placed_joints.h"

namespace proximity_server::scene {

Derivatives::Derivatives(std::shared_ptr<const SceneModel> model)
    : joints_(std::make_unique<PlacedJoints>(std::move(model))) {}
Derivatives::~Derivatives() = default;
Derivatives::Derivatives(Derivatives&&) noexcept = default;
Derivatives& Derivatives::operator=(Derivatives&&) noexcept = default;

const DegreesOfFreedom& Derivatives::degreesOfFreedom() const { return joints_->degreesOfFreedom(); }

void Derivatives::use(std::shared_ptr<const Objects> objects) { joints_->use(std::move(objects)); }

void Derivatives::use(std::shared_ptr<const Objects> objects, ObjectCarriers carriers) {
  joints_->use(std::move(objects), std::move(carriers));
}

void Derivatives::update(const BodyPoses& poses) { joints_->update(poses); }

bool Derivatives::gradient(const PairProximity& pair, Eigen::Ref<Eigen::VectorXd> gradient) const {
  const DegreesOfFreedom& columns = degreesOfFreedom();
  if (gradient.size() != columns.size())
    throw std::invalid_argument("the robot has " + std::to_string(columns.size()) +
                                " degrees of freedom, but there is room for " + std::to_string(gradient.size()));
  const narrowphase::SignedDistance& result = pair.result;
  const int body_a = joints_->bodyOf(pair.asked.a), body_b = joints_->bodyOf(pair.asked.b);
  if (result.status == narrowphase::Status::Unknown || !result.has_points || !joints_->knowsBetween(body_a, body_b)) {
    gradient.setConstant(std::numeric_limits<double>::quiet_NaN());
    return false;
  }
  gradient.setZero();
  joints_->forEachBetween(body_a, body_b, [&](int body, PlacedJoints::Side side) {
    const bool carries_a = side == PlacedJoints::Side::A;
    const Eigen::Vector3d point = carries_a ? result.point_a : result.point_b;
    const Eigen::Vector3d away = carries_a ? Eigen::Vector3d(-result.normal) : result.normal;
    const JointTwists twists = joints_->twistsOf(body);
    const auto& own = columns.columnsOf(joints_->robot().bodies[static_cast<std::size_t>(body)].joint);
    for (int i = 0; i < twists.count; ++i)
      gradient[own.first + i] +=
          own.multiplier * away.dot(twists.twists[static_cast<std::size_t>(i)].velocityAt(point));
  });
  return true;
}

}  // namespace proximity_server::scene
