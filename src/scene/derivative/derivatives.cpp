#include "proximity_server/scene/derivative/derivatives.h"

#include "scene/derivative/contact_feature.h"
#include "scene/derivative/placed_joints.h"
#include "scene/model/body_pose.h"
#include "scene/scene_model/given_model.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {

Derivatives::Derivatives(std::shared_ptr<const SceneModel> model)
    : features_(std::make_unique<ContactFeatures>(given(model))),
      joints_(std::make_unique<PlacedJoints>(std::move(model))) {
  row_.resize(degreesOfFreedom().size());
}
Derivatives::~Derivatives() = default;
Derivatives::Derivatives(Derivatives&&) noexcept = default;
Derivatives& Derivatives::operator=(Derivatives&&) noexcept = default;

const DegreesOfFreedom& Derivatives::degreesOfFreedom() const { return joints_->degreesOfFreedom(); }

void Derivatives::use(std::shared_ptr<const Objects> objects) {
  joints_->use(objects);
  frames_.assign(objects ? objects->frames().size() : 0, std::nullopt);
  features_->use(std::move(objects));
}

void Derivatives::use(std::shared_ptr<const Objects> objects, ObjectCarriers carriers) {
  joints_->use(objects, std::move(carriers));
  frames_.assign(objects ? objects->frames().size() : 0, std::nullopt);
  features_->use(std::move(objects));
}

void Derivatives::update(const BodyPoses& poses) {
  joints_->update(poses);
  std::fill(frames_.begin(), frames_.end(), std::nullopt);
}

void Derivatives::update(const BodyPoses& poses, const FramePoses& frames) {
  if (frames.size() != frames_.size())
    throw std::invalid_argument("the objects have " + std::to_string(frames_.size()) + " frames, but there are " +
                                std::to_string(frames.size()) + " poses");
  joints_->update(poses);
  std::transform(frames.begin(), frames.end(), frames_.begin(), usablePose);
}

void Derivatives::requireSize(Eigen::Index size) const {
  if (size != degreesOfFreedom().size())
    throw std::invalid_argument("the robot has " + std::to_string(degreesOfFreedom().size()) +
                                " degrees of freedom, but the vector has " + std::to_string(size) + " entries");
}

bool Derivatives::gradient(const PairProximity& pair, Eigen::Ref<Eigen::VectorXd> gradient) const {
  const DegreesOfFreedom& columns = degreesOfFreedom();
  requireSize(gradient.size());
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
    const auto& own = columns.columnsOf(joints_->robot().bodies[body].joint);
    for (int i = 0; i < twists.count; ++i)
      gradient[own.first + i] += own.multiplier * away.dot(twists.twists[i].velocityAt(point));
  });
  return true;
}

double Derivatives::rate(const PairProximity& pair, const Eigen::Ref<const Eigen::VectorXd>& velocity) {
  requireSize(velocity.size());
  if (!gradient(pair, row_)) return std::numeric_limits<double>::quiet_NaN();
  const double at_points = row_.dot(velocity);
  if (pair.result.unique) return at_points;
  // If the witness pair moves by x, the rate changes by n . (turn x x) = (n x turn) . x.
  const Eigen::Vector3d turn =
      joints_->relativeTurn(joints_->bodyOf(pair.asked.a), joints_->bodyOf(pair.asked.b), velocity);
  return at_points + features_->minimum(pair, pair.result.normal.cross(turn), joints_->poses(), frames_);
}

}  // namespace proximity_server::scene
