#include "scene/proof/box_search.h"

#include "proximity_server/scene/motion/frames_on_links.h"
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
  for (const JointRange& interval : box) positions_[interval.joint] = 0.5 * (interval.lower + interval.upper);
  Box all{{}, {}, -kInfinity, 1.0, made_++, 0};
  for (const JointRange& interval : whole_.joints) {
    all.lower.push_back(interval.lower);
    all.upper.push_back(interval.upper);
  }
  boxes_.push_back(std::move(all));
}

// --- the order of the boxes

/// [m] A bound above this is good enough.
double BoxSearch::target() const {
  return contact() + question_.tightness * std::max(0.0, proof_.closest_upper_bound - contact());
}

/// True if the other box is divided first.
bool BoxSearch::isAfter(const Box& one, const Box& other) const {
  if (wantsShares() && one.share != other.share) return one.share < other.share;
  return one.bound != other.bound ? one.bound > other.bound : one.number > other.number;
}

void BoxSearch::push(Box box) {
  boxes_.push_back(std::move(box));
  std::push_heap(boxes_.begin(), boxes_.end(), [&](const Box& a, const Box& b) { return isAfter(a, b); });
}

BoxSearch::Box BoxSearch::pop() {
  std::pop_heap(boxes_.begin(), boxes_.end(), [&](const Box& a, const Box& b) { return isAfter(a, b); });
  Box box = std::move(boxes_.back());
  boxes_.pop_back();
  return box;
}

bool BoxSearch::isSettled() const {
  if (boxes_.empty()) return true;
  if (wantsShares()) return boxes_.front().widest < 0;
  return proof_.closest_upper_bound <= contact() || boxes_.front().widest < 0 || boxes_.front().bound > target();
}

void BoxSearch::run(BoxMeasures& measures, long most_boxes) {
  if (proof_.boxes == 0 && most_boxes > 0) examine(pop(), measures);
  while (!isSettled() && proof_.boxes + 2 <= most_boxes && !question_.deadline.hasPassed()) divide(measures);
}

void BoxSearch::settle(double bound) {
  boxes_.clear();
  settled_bound_ = bound;
}

void BoxSearch::divide(BoxMeasures& measures) {
  Box low = pop();
  const auto at = static_cast<std::size_t>(low.widest);
  Box high = low;
  low.upper[at] = high.lower[at] = 0.5 * (low.lower[at] + low.upper[at]);
  low.share = high.share = 0.5 * low.share;
  low.number = made_++;
  high.number = made_++;
  examine(std::move(low), measures);
  examine(std::move(high), measures);
}

// --- one box

void BoxSearch::placeAtCentre(const Box& box) {
  for (std::size_t i = 0; i < whole_.joints.size(); ++i)
    positions_[whole_.joints[i].joint] = 0.5 * (box.lower[i] + box.upper[i]);
}

Uncertainty BoxSearch::halfWidths(const Box& box) const {
  Uncertainty uncertainty(model_.robot);
  for (std::size_t i = 0; i < whole_.joints.size(); ++i)
    if (box.lower[i] < box.upper[i])
      uncertainty.positions[whole_.joints[i].joint] = halfWidth(box.lower[i], box.upper[i]);
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

bool BoxSearch::isInContact(const Box& box, double upper_bound, const BoxMeasures& measures) const {
  double travel = whole_.rounding;
  for (std::size_t i = 0; i < whole_.joints.size(); ++i)
    travel += measures.travelOf(whole_.joints[i].joint) * halfWidth(box.lower[i], box.upper[i]);
  return upper_bound + travel * (1.0 + 64.0 * std::numeric_limits<double>::epsilon()) <= contact();
}

/// The joint that moves the points of the two the most; -1 if no interval can be halved.
int BoxSearch::widestOf(const Box& box, const BoxMeasures& measures) const {
  int widest = -1;
  double most = -1.0;
  for (std::size_t i = 0; i < whole_.joints.size(); ++i) {
    const double middle = 0.5 * (box.lower[i] + box.upper[i]);
    const double travel = measures.travelOf(whole_.joints[i].joint) * (box.upper[i] - box.lower[i]);
    if (!(box.lower[i] < middle && middle < box.upper[i]) || !(travel > most)) continue;
    most = travel;
    widest = static_cast<int>(i);
  }
  return widest;
}

void BoxSearch::examine(Box box, BoxMeasures& measures) {
  ++proof_.boxes;
  placeAtCentre(box);
  PairProximity found;
  const double closest_before = proof_.closest_upper_bound;
  const narrowphase::SignedDistance distance = measure(measures, found);
  measures.bounds().assume(halfWidths(box));
  const double bound = measures.bounds().of(measures.state(), found, target() + whole_.rounding) - whole_.rounding;
  // Parts of a box are no worse than the box, even if another direction bounds them. NaN counts as no bound.
  box.bound = bound > box.bound ? bound : box.bound;
  if (box.bound > target()) {
    settled_bound_ = std::min(settled_bound_, box.bound);
    return;
  }
  const bool knows_travel = measures.findTravel(pair_);
  if (wantsShares() && knows_travel && isInContact(box, distance.upper_bound, measures)) {
    proof_.in_contact += box.share;
    settled_bound_ = std::min(settled_bound_, box.bound);
    return;
  }
  box.widest = knows_travel ? widestOf(box, measures) : -1;
  if (distance.upper_bound < closest_before && distance.upper_bound > contact()) tryCorners(found, measures);
  push(std::move(box));
}

PairProof BoxSearch::result() const {
  PairProof proof = proof_;
  proof.lower_bound = settled_bound_;
  proof.undecided = 0.0;
  const Box* worst = nullptr;
  for (const Box& box : boxes_) {
    proof.lower_bound = std::min(proof.lower_bound, box.bound);
    if (box.bound > contact()) continue;
    proof.undecided += box.share;
    if (!worst || box.bound < worst->bound) worst = &box;
  }
  if (proof.closest_upper_bound <= contact())
    proof.outcome = ProofOutcome::Refuted;
  else if (!worst)
    proof.outcome = ProofOutcome::Proven;
  for (std::size_t i = 0; worst && i < whole_.joints.size(); ++i)
    proof.worst.push_back({whole_.joints[i].joint, worst->lower[i], worst->upper[i]});
  return proof;
}

}  // namespace proximity_server::scene
