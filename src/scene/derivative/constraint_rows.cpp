#include "proximity_server/scene/derivative/constraint_rows.h"

#include "scene/model/numbers.h"
#include "scene/scene_model/given_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

namespace proximity_server::scene {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

void require(bool holds, const char* field, double value, const char* what) {
  if (!holds) throw std::invalid_argument(std::string(field) + " is " + std::to_string(value) + ": " + what);
}

void requireUsable(const VelocityDamper& damper) {
  const double of_links = damper.stop.range(PairKind::OfLinks).largest;
  const double of_objects = damper.stop.range(PairKind::WithObject).largest;
  const std::pair<const char*, double> fields[] = {{"stop_distance", of_links},
                                                   {"object_stop_distance", of_objects},
                                                   {"influence_distance", damper.influence_distance},
                                                   {"gain", damper.gain}};
  for (const auto& [field, value] : fields) require(std::isfinite(value), field, value, "it is not finite");
  if (!damper.stop.areFinite()) throw std::invalid_argument("the stop distance of a pair is not finite");
  require(damper.gain > 0.0, "gain", damper.gain, "it is not positive");
  require(damper.influence_distance > of_links, "influence_distance", damper.influence_distance,
          "it is not above stop_distance");
  require(damper.influence_distance > of_objects, "influence_distance", damper.influence_distance,
          "it is not above object_stop_distance");
}

/// True if the objects of the scene still have this pair.
bool isStillChecked(const ShapeRefPair& pair, const Objects& objects) {
  if (pair.areLinks()) return true;
  for (const ShapeRef& ref : {pair.a, pair.b})
    if (ref.isObject() && !objects.object(ref.object())) return false;
  return objects.isChecked(pair.a, pair.b);
}

/// Orders pairs that are equally demanding, in the same way on every machine.
bool comesFirst(const ShapeRefPair& p, const ShapeRefPair& q) {
  const auto key = [](const ShapeRefPair& pair) {
    return std::tuple(pair.a.link(), pair.a.object(), pair.b.link(), pair.b.object());
  };
  return key(p) < key(q);
}

/// [m/s] The bound of a row. The share has three roundings and the product one: together at most 2.5 epsilon.
double smallestRate(double share, const VelocityDamper& damper) {
  const double rate = -damper.gain * share;
  return rate + 4.0 * kEpsilon * std::abs(rate);
}

/// [rad/s, m/s] The largest speed of each column. The velocity of a mimic joint limits the column of its leader, too.
Eigen::VectorXd largestSpeeds(const RobotModel& robot) {
  const DegreesOfFreedom columns(robot);
  Eigen::VectorXd speeds = Eigen::VectorXd::Constant(columns.size(), kInfinity);
  for (std::size_t joint = 0; joint < robot.joints.size(); ++joint) {
    if (!hasOnePosition(robot.joints[joint])) continue;
    const DegreesOfFreedom::Columns& own = columns.columnsOf(static_cast<int>(joint));
    if (own.multiplier == 0.0) continue;
    speeds[own.first] = std::min(speeds[own.first], robot.joints[joint].max_velocity / std::abs(own.multiplier));
  }
  return speeds;
}

/// [rad/s, m/s] The largest speeds of the columns that move, and 0 of all others.
Eigen::VectorXd speedsOf(const RobotModel& robot, const std::vector<int>& moving) {
  const Eigen::VectorXd largest = largestSpeeds(robot);
  Eigen::VectorXd speeds = Eigen::VectorXd::Zero(largest.size());
  for (const int column : moving) {
    if (column < 0 || column >= largest.size())
      throw std::invalid_argument("the robot has no degree of freedom " + std::to_string(column));
    speeds[column] = largest[column];
  }
  return speeds;
}

/// [m] The lower bound that counts.
double distanceOf(const PairProximity& pair, const VelocityDamper& damper) {
  return damper.guaranteed ? damper.guaranteed(pair) : pair.result.lower_bound;
}

std::vector<int> allColumns(const RobotModel& robot) {
  std::vector<int> columns(static_cast<std::size_t>(DegreesOfFreedom(robot).size()));
  std::iota(columns.begin(), columns.end(), 0);
  return columns;
}

/// [m/s] The largest rate of change of a distance. A speed may be infinite.
double largestRate(const Eigen::VectorXd& gradient, const Eigen::VectorXd& speeds) {
  double rate = 0.0;
  for (Eigen::Index i = 0; i < gradient.size(); ++i)
    if (std::abs(gradient[i]) > ConstraintRows::kNoChange) rate += std::abs(gradient[i]) * speeds[i];
  return rate;
}

}  // namespace

ConstraintRows::ConstraintRows(const std::shared_ptr<const SceneModel>& model, int capacity)
    : ConstraintRows(model, capacity, allColumns(given(model).robot)) {}

ConstraintRows::ConstraintRows(std::shared_ptr<const SceneModel> model, int capacity, const std::vector<int>& moving)
    : model_(std::move(model)) {
  if (capacity < 1)
    throw std::invalid_argument("the capacity of the constraint rows is " + std::to_string(capacity) +
                                ", not at least 1");
  speeds_ = speedsOf(given(model_).robot, moving);
  const auto size = static_cast<std::size_t>(capacity);
  matrix_.setZero(capacity, speeds_.size());
  gradient_.setZero(speeds_.size());
  bounds_.setConstant(capacity, -kInfinity);
  rows_.resize(size);
  stuck_.reserve(size);
  offers_.reserve(model_->pairs.checked.size() + size);
}

void ConstraintRows::find(Scene& scene, const State& state, const VelocityDamper& damper) {
  requireUsable(damper);
  if (&scene.model() != model_.get()) throw std::invalid_argument("the scene is of another robot");
  state.requireModel(*model_);
  offers_.clear();
  stuck_.clear();
  left_out_ = unneeded_ = stuck_count_ = unknown_ = 0;
  offerNear(scene, state, damper);
  offerKept(scene, state, damper);
  choose(state, damper);
  assignRows();
  for (const Offer& offer : offers_) fill(offer, state);
}

void ConstraintRows::offerNear(Scene& scene, const State& state, const VelocityDamper& damper) {
  Question question;
  question.threshold = damper.influence_distance + damper.largest_loss;
  for (const PairProximity& pair : scene.below(state, scene.candidates(), question)) {
    const double distance = distanceOf(pair, damper);
    if (!(distance > damper.influence_distance)) offer(pair, distance, damper, rowOf(pair.asked));
  }
  unknown_ += scene.counts().unknown;
}

/// Offers the pairs that have a row and are not within the influence distance.
void ConstraintRows::offerKept(Scene& scene, const State& state, const VelocityDamper& damper) {
  const std::size_t near = offers_.size();
  for (int row = 0; row < capacity(); ++row) {
    const Row& kept = rows_[row];
    const auto is_offered = [&](const Offer& offer) { return offer.row == row; };
    if (!kept.is_used || std::any_of(offers_.begin(), offers_.begin() + static_cast<std::ptrdiff_t>(near), is_offered))
      continue;
    if (!isStillChecked(kept.pair, *state.objects())) continue;
    const double stop = damper.stop.of(kept.pair);
    Question question;
    const double farthest = stop + (1.0 + kKeepShare) * (damper.influence_distance - stop);
    question.threshold = farthest + damper.largest_loss;
    const PairProximity pair = scene.proximity(state, kept.pair, question);
    const double distance = distanceOf(pair, damper);
    if (pair.result.status == narrowphase::Status::Unknown || distance > farthest) continue;
    offer(pair, distance, damper, row);
    offers_.back().is_within = false;
  }
}

void ConstraintRows::offer(const PairProximity& pair, double distance, const VelocityDamper& damper, int row) {
  const double stop = damper.stop.of(pair.asked);
  const double share = (distance - stop) / (damper.influence_distance - stop);
  offers_.push_back({pair.asked, pair.result, distance, share, row, true});
}

/// Keeps the most demanding offers that need a row, at most as many as there are rows.
void ConstraintRows::choose(const State& state, const VelocityDamper& damper) {
  std::sort(offers_.begin(), offers_.end(), [](const Offer& a, const Offer& b) {
    return a.rank() != b.rank() ? a.rank() < b.rank() : comesFirst(a.pair, b.pair);
  });
  std::size_t chosen = 0;
  for (Offer& offer : offers_) {
    const Need need = decideNeed(offer, state, damper);
    unknown_ += need == Need::Unknown;
    unneeded_ += need == Need::None && offer.is_within;
    if (need != Need::Row) continue;
    if (chosen < rows_.size())
      offers_[chosen++] = offer;
    else
      left_out_ += offer.is_within;
  }
  offers_.erase(offers_.begin() + static_cast<std::ptrdiff_t>(chosen), offers_.end());
}

/// Decides whether a pair needs a row, and sets its bound.
ConstraintRows::Need ConstraintRows::decideNeed(Offer& offer, const State& state, const VelocityDamper& damper) {
  if (!std::isfinite(offer.share) || !findGradient(offer, state)) return Need::Unknown;
  const double bound = smallestRate(offer.share, damper), rate = largestRate(gradient_, speeds_);
  if (bound > rate) {
    ++stuck_count_;
    if (stuck_.size() < rows_.size()) stuck_.push_back({offer.pair, offer.distance, rate});
  }
  if (rate == 0.0 || -bound >= rate + kSpareShare * damper.gain) return Need::None;
  const double square = gradient_.squaredNorm();
  offer.bound = bound > 0.0 ? std::min(bound * square / (square + kDamping * kDamping), 0.5 * rate) : bound;
  return Need::Row;
}

/// Sets the gradient by the columns that move. Returns false if it is not known.
bool ConstraintRows::findGradient(const Offer& offer, const State& state) {
  if (!gradient(state, PairProximity{offer.pair, 0, 0, offer.result}, gradient_)) return false;
  gradient_ = (speeds_.array() > 0.0).select(gradient_, 0.0);
  return true;
}

/// Frees the rows of pairs that were not chosen, and gives free rows to pairs that have none.
void ConstraintRows::assignRows() {
  for (int row = 0; row < capacity(); ++row)
    if (std::none_of(offers_.begin(), offers_.end(), [&](const Offer& offer) { return offer.row == row; })) free(row);
  std::size_t next = 0;
  for (Offer& offer : offers_) {
    if (offer.row != kNone) continue;
    while (rows_[next].is_used) ++next;
    offer.row = static_cast<int>(next);
    rows_[next].is_used = true;
  }
}

int ConstraintRows::rowOf(const ShapeRefPair& pair) const {
  const auto found =
      std::find_if(rows_.begin(), rows_.end(), [&](const Row& row) { return row.is_used && row.pair.isSameAs(pair); });
  return found == rows_.end() ? kNone : static_cast<int>(found - rows_.begin());
}

void ConstraintRows::free(int row) {
  matrix_.row(row).setZero();
  bounds_[row] = -kInfinity;
  rows_[row] = {};
}

void ConstraintRows::fill(const Offer& offer, const State& state) {
  findGradient(offer, state);
  matrix_.row(offer.row) = gradient_.transpose();
  bounds_[offer.row] = offer.bound;
  rows_[offer.row] = {offer.pair, offer.distance, true, offer.result.unique};
}

InequalityRows::InequalityRows(std::shared_ptr<const SceneModel> model, const std::vector<int>& moving)
    : model_(std::move(model)) {
  const RobotModel& robot = given(model_).robot;
  const DegreesOfFreedom columns(robot);
  const Eigen::VectorXd speeds = speedsOf(robot, moving);
  const auto count = static_cast<Eigen::Index>(robot.inequalities.size());
  matrix_.setZero(count, columns.size());
  bounds_.setConstant(count, -kInfinity);
  largest_.setZero(count);
  for (Eigen::Index row = 0; row < count; ++row)
    for (const JointInequality::Term& term : robot.inequalities[row].terms) {
      const int column = columns.columnsOf(term.joint).first;
      if (speeds[column] == 0.0) continue;
      matrix_(row, column) = -term.coefficient;
      largest_[row] += std::abs(term.coefficient) * speeds[column];
    }
}

bool InequalityRows::update(const BodyPoses& poses, const std::vector<std::optional<double>>& stated, double rate) {
  for (Eigen::Index row = 0; row < bounds_.size(); ++row) {
    if (largest_[row] == 0.0) continue;
    const std::optional<double> excess = excessAt(model_->robot, model_->robot.inequalities[row], poses, stated);
    if (!excess) return false;
    bounds_[row] = std::min(rate * *excess, largest_[row]);
  }
  return true;
}

}  // namespace proximity_server::scene
