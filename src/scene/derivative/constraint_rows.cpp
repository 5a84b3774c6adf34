#include "proximity_server/scene/derivative/constraint_rows.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "scene/model/infinity.h"
#include "scene/query/same_pair.h"

namespace proximity_server::scene {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

void require(bool holds, const char* field, double value, const char* what) {
  if (!holds) throw std::invalid_argument(std::string(field) + " is " + std::to_string(value) + ": " + what);
}

void requireUsable(const VelocityDamper& damper) {
  const std::pair<const char*, double> fields[] = {{"stop_distance", damper.stop_distance},
                                                   {"object_stop_distance", damper.object_stop_distance},
                                                   {"influence_distance", damper.influence_distance},
                                                   {"gain", damper.gain}};
  for (const auto& [field, value] : fields) require(std::isfinite(value), field, value, "it is not finite");
  require(damper.gain > 0.0, "gain", damper.gain, "it is not positive");
  require(damper.influence_distance > damper.stop_distance, "influence_distance", damper.influence_distance,
          "it is not above stop_distance");
  require(damper.influence_distance > damper.object_stop_distance, "influence_distance", damper.influence_distance,
          "it is not above object_stop_distance");
}

bool isObject(const ShapeRef& ref) { return ref.link < 0; }

/// Whether the objects of the scene still have a pair that it had before.
bool isStillChecked(const ShapeRefPair& pair, const Objects* objects) {
  if (!isObject(pair.a) && !isObject(pair.b)) return true;
  for (const ShapeRef& ref : {pair.a, pair.b})
    if (isObject(ref) && !(objects && objects->object(ref.object))) return false;
  if (isObject(pair.a) && isObject(pair.b))
    return objects->objectReason(pair.a.object, pair.b.object) == PairReason::Checked;
  const ShapeRef &link = isObject(pair.a) ? pair.b : pair.a, &object = isObject(pair.a) ? pair.a : pair.b;
  return objects->linkReason(link.link, object.object) == PairReason::Checked;
}

double stopDistance(const ShapeRefPair& pair, const VelocityDamper& damper) {
  return isObject(pair.a) || isObject(pair.b) ? damper.object_stop_distance : damper.stop_distance;
}

/// [m/s] The bound of a row. The share has three roundings, the product one: together at most 2.5 epsilon.
double leastRate(double share, const VelocityDamper& damper) {
  const double rate = -damper.gain * share;
  return rate + 4.0 * kEpsilon * std::abs(rate);
}

}  // namespace

ConstraintRows::ConstraintRows(std::shared_ptr<const SceneModel> model, int capacity) : model_(std::move(model)) {
  if (capacity < 1)
    throw std::invalid_argument("the capacity of the constraint rows is " + std::to_string(capacity) +
                                ", not at least 1");
  const auto size = static_cast<std::size_t>(capacity);
  matrix_.setZero(capacity, DegreesOfFreedom(model_->robot).size());
  bounds_.setConstant(capacity, -kInfinity);
  rows_.resize(size);
  offers_.reserve(3 * size);  // pairs of links, pairs with objects, and those that have the rows
}

void ConstraintRows::update(Scene& scene, const Derivatives& derivatives, const VelocityDamper& damper) {
  requireUsable(damper);
  if (&scene.model() != model_.get()) throw std::invalid_argument("the scene is of another robot");
  if (derivatives.degreesOfFreedom().size() != matrix_.cols())
    throw std::invalid_argument("the derivatives are of another robot");
  offers_.clear();
  left_out_ = unknown_ = 0;
  offerClosest(scene, PairKind::OfLinks, damper);
  if (scene.objects() && scene.objects()->pairCount() > 0) offerClosest(scene, PairKind::WithObject, damper);
  offerKept(scene, damper);
  choose();
  giveRows();
  for (const Offer& offer : offers_) fill(offer, derivatives, damper);
}

void ConstraintRows::offerClosest(Scene& scene, PairKind kind, const VelocityDamper& damper) {
  Question question;
  question.threshold = damper.influence_distance;
  const PairsBelow below = scene.closestBelow(Pairs(scene.candidates(), kind), capacity(), question);
  for (const PairProximity& pair : below.closest) offer(pair, damper, rowOf(pair.asked), Reach::Within);
  left_out_ += below.count;
  unknown_ += scene.counts().unknown;
}

/// Offers the pairs that have a row and are not among the closest.
void ConstraintRows::offerKept(Scene& scene, const VelocityDamper& damper) {
  const std::size_t closest = offers_.size();
  for (int row = 0; row < capacity(); ++row) {
    const Row& kept = rows_[static_cast<std::size_t>(row)];
    const auto is_offered = [&](const Offer& offer) { return offer.row == row; };
    if (!kept.is_used ||
        std::any_of(offers_.begin(), offers_.begin() + static_cast<std::ptrdiff_t>(closest), is_offered))
      continue;
    if (!isStillChecked(kept.pair, scene.objects())) continue;
    const double stop = stopDistance(kept.pair, damper);
    Question question;
    question.threshold = stop + (1.0 + kKeepShare) * (damper.influence_distance - stop);
    const PairProximity pair = scene.proximity(kept.pair, question);
    if (pair.result.status == narrowphase::Status::Unknown || pair.result.lower_bound > question.threshold) continue;
    // An upper bound, so that the scene has counted each pair that is taken off leftOut().
    offer(pair, damper, row, pair.result.upper_bound <= damper.influence_distance ? Reach::Within : Reach::Open);
  }
}

void ConstraintRows::offer(const PairProximity& pair, const VelocityDamper& damper, int row, Reach reach) {
  const double stop = stopDistance(pair.asked, damper);
  const double share = (pair.result.lower_bound - stop) / (damper.influence_distance - stop);
  offers_.push_back({pair.asked, pair.result, share, row, reach});
}

/// Leaves the most demanding offers, as many as there are rows.
void ConstraintRows::choose() {
  if (offers_.size() > rows_.size()) {
    const auto comes_first = [](const Offer& a, const Offer& b) { return a.rank() < b.rank(); };
    const auto end = offers_.begin() + capacity();
    std::nth_element(offers_.begin(), end, offers_.end(), comes_first);
    offers_.erase(end, offers_.end());
  }
  left_out_ -= static_cast<int>(
      std::count_if(offers_.begin(), offers_.end(), [](const Offer& offer) { return offer.reach == Reach::Within; }));
}

/// Frees the rows of pairs that were not chosen, and gives the free rows to those that have none.
void ConstraintRows::giveRows() {
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
      std::find_if(rows_.begin(), rows_.end(), [&](const Row& row) { return row.is_used && areSame(row.pair, pair); });
  return found == rows_.end() ? kNone : static_cast<int>(found - rows_.begin());
}

void ConstraintRows::free(int row) {
  matrix_.row(row).setZero();
  bounds_[row] = -kInfinity;
  rows_[static_cast<std::size_t>(row)] = {};
}

void ConstraintRows::fill(const Offer& offer, const Derivatives& derivatives, const VelocityDamper& damper) {
  if (!std::isfinite(offer.share) ||
      !derivatives.gradient(PairProximity{offer.pair, 0, 0, offer.result}, matrix_.row(offer.row).transpose())) {
    free(offer.row);
    ++unknown_;
    return;
  }
  bounds_[offer.row] = leastRate(offer.share, damper);
  rows_[static_cast<std::size_t>(offer.row)] = {offer.pair, offer.result.lower_bound, true, offer.result.unique};
}

}  // namespace proximity_server::scene
