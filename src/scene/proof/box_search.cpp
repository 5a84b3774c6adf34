#include "scene/proof/box_search.h"

#include "proximity_server/scene/motion/frames_on_links.h"
#include "scene/guaranteed/place_to_halve.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace proximity_server::scene {
BoxMeasures::BoxMeasures(const std::shared_ptr<const SceneModel>& model, const std::shared_ptr<const Objects>& objects)
    : state_(model), scene_(model), bounds_(model), travel_(model), weights_(state_.degreesOfFreedom().size()) {
  bounds_.divideInto(0);
  if (objects) state_.set(objects, carriersOnLinks(*objects));
}

void BoxMeasures::update(const Positions& positions) { setPositions(state_, positions); }

bool BoxMeasures::findTravel(const ShapeRefPair& pair) { return travel_.weights(state_, pair, weights_); }

BoxSearch::BoxSearch(const SceneModel& model, const ShapeRefPair& pair, const JointBox& box,
                     const ProofQuestion& question)
    : model_(model),
      pair_(pair),
      question_(question),
      whole_(pairBox(model.robot, question.objects.get(), pair, box)),
      positions_(model.robot.joints.size(), 0.0),
      settled_bound_(kInfinity) {
  proof_.pair = pair;
  proof_.box = whole_.joints;
  placeAtCentre(box);
  boxes_[{}] = {whole_.joints, -kInfinity, 1.0, 0};
}

/// [m] A bound above this is good enough.
double BoxSearch::target() const {
  return contact() + question_.tightness * std::max(0.0, proof_.closest_upper_bound - contact());
}

bool BoxSearch::isSettled() const {
  if (boxes_.empty()) return true;
  const Box& next = boxes_.begin()->second;
  if (wantsShares()) return next.widest < 0;
  return proof_.closest_upper_bound <= contact() || next.widest < 0 || next.bound > target();
}

void BoxSearch::run(BoxMeasures& measures, long most_boxes) {
  if (proof_.boxes == 0 && most_boxes > 0) examine(boxes_.extract(boxes_.begin()).mapped(), measures);
  while (!isSettled() && proof_.boxes + 2 <= most_boxes && !question_.deadline.hasPassed()) divide(measures);
}

void BoxSearch::settle(double bound) {
  boxes_.clear();
  settled_bound_ = bound;
}

void BoxSearch::divide(BoxMeasures& measures) {
  Box low = std::move(boxes_.extract(boxes_.begin()).mapped());
  low.share *= 0.5;
  Box high = low;
  const auto at = static_cast<std::size_t>(low.widest);
  low.joints[at].upper = high.joints[at].lower = 0.5 * (low.joints[at].lower + low.joints[at].upper);
  examine(std::move(low), measures);
  examine(std::move(high), measures);
}

// --- one box

void BoxSearch::placeAtCentre(const JointBox& box) {
  for (const JointRange& interval : box) positions_[interval.joint] = 0.5 * (interval.lower + interval.upper);
}

Uncertainty BoxSearch::halfWidths(const JointBox& box) const {
  Uncertainty uncertainty(model_.robot);
  for (const JointRange& interval : box)
    if (interval.lower < interval.upper)
      uncertainty.positions[interval.joint] = halfWidth(interval.lower, interval.upper);
  return uncertainty;
}

/// Measures the distance in the state of positions_, and keeps the state if none was closer.
narrowphase::SignedDistance BoxSearch::measure(BoxMeasures& measures, PairProximity& found) {
  measures.update(positions_);
  Question question;
  if (!wantsShares()) question.depth = Question::Depth::NotWanted;
  found = measures.scene().proximity(measures.state(), pair_, question);
  if (found.result.upper_bound < proof_.closest_upper_bound) {
    proof_.closest_upper_bound = found.result.upper_bound;
    proof_.closest = positions_;
  }
  return found.result;
}

/// Moves the joints to where the closest points come together, and measures there.
void BoxSearch::tryCorners(const PairProximity& found, BoxMeasures& measures) {
  const ReachedState* reached = measures.bounds().reached(measures.state(), found, contact());
  if (!reached) return;
  for (const JointRange& interval : whole_.joints) {
    double& position = positions_[interval.joint];
    position = std::clamp(position + reached->displacements[interval.joint], interval.lower, interval.upper);
  }
  PairProximity there;
  measure(measures, there);
}

bool BoxSearch::isInContact(const JointBox& box, double upper_bound, const BoxMeasures& measures) const {
  double travel = whole_.rounding;
  for (const JointRange& interval : box)
    travel += measures.travelOf(interval.joint) * halfWidth(interval.lower, interval.upper);
  return upper_bound + travel * (1.0 + 64.0 * std::numeric_limits<double>::epsilon()) <= contact();
}

void BoxSearch::examine(Box box, BoxMeasures& measures) {
  ++proof_.boxes;
  placeAtCentre(box.joints);
  PairProximity found;
  const double closest_before = proof_.closest_upper_bound;
  const narrowphase::SignedDistance distance = measure(measures, found);
  measures.bounds().assume(halfWidths(box.joints));
  const double bound = measures.bounds().of(measures.state(), found, target() + whole_.rounding) - whole_.rounding;
  // Parts of a box are no worse than the box, even if another direction bounds them. NaN counts as no bound.
  box.bound = bound > box.bound ? bound : box.bound;
  if (box.bound > target()) {
    settled_bound_ = std::min(settled_bound_, box.bound);
    return;
  }
  const bool knows_travel = measures.findTravel(pair_);
  if (wantsShares() && knows_travel && isInContact(box.joints, distance.upper_bound, measures)) {
    proof_.in_contact += box.share;
    settled_bound_ = std::min(settled_bound_, box.bound);
    return;
  }
  const auto travel = [&](const JointRange& own) { return measures.travelOf(own.joint) * own.width(); };
  box.widest = knows_travel ? placeToHalve(box.joints.data(), box.joints.size(), travel) : -1;
  if (distance.upper_bound < closest_before && distance.upper_bound > contact()) tryCorners(found, measures);
  boxes_[{wantsShares() ? -box.share : 0.0, box.bound, proof_.boxes}] = std::move(box);
}

PairProof BoxSearch::result() const {
  PairProof proof = proof_;
  proof.lower_bound = settled_bound_;
  proof.undecided = 0.0;
  const Box* worst = nullptr;
  for (const auto& [order, box] : boxes_) {
    proof.lower_bound = std::min(proof.lower_bound, box.bound);
    if (box.bound > contact()) continue;
    proof.undecided += box.share;
    if (!worst || box.bound < worst->bound) worst = &box;
  }
  if (proof.closest_upper_bound <= contact())
    proof.outcome = ProofOutcome::Refuted;
  else if (!worst)
    proof.outcome = ProofOutcome::Proven;
  if (worst) proof.worst = worst->joints;
  return proof;
}

}  // namespace proximity_server::scene
