#include "scene/uncertainty/pair_bounds.h"

#include "proximity_server/narrowphase/shape/support.h"
#include "scene/model/numbers.h"
#include "scene/objects/object_geometry.h"
#include "scene/query/half_space.h"
#include "scene/scene_model/given_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <variant>

namespace proximity_server::scene {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::SignedDistance;

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kTiny = std::numeric_limits<double>::min();

// The steps of LimitedWork: of 3 ns, measured on PR2 and Panda within a factor of 1.5.
constexpr std::int64_t kStepsOfPair = 300, kStepsOfVisit = 60, kStepsOfQuery = 500, kStepsOfDirection = 60,
                       kStepsOfDisplacement = 30, kStepsOfVertex = 2;

void addFrame(const PoseUncertainty& frame, int place, const Vector3d& origin, std::vector<Displacement>& chain) {
  if (frame.angle > 0.0) chain.push_back({Displacement::Kind::Tilt, place, frame.angle, origin});
  if (frame.translation > 0.0) chain.push_back({Displacement::Kind::Shift, place, frame.translation, origin});
}

/// The origin of an object in the frame of what carries it.
Vector3d originOf(const Object& object, const RobotModel& robot) {
  if (const auto* fixed = std::get_if<Fixed>(&object.placement)) return fixed->world_T_object.translation();
  if (const auto* moving = std::get_if<Moving>(&object.placement)) return moving->frame_T_object.translation();
  const auto& attached = std::get<Attached>(object.placement);
  return robot.links[robot.findLink(attached.link)].body_T_link * attached.link_T_object.translation();
}

/// The point of the convex hull of some points that is the nearest to the origin, approximately: each step goes along
/// the segment to one of the points (Gilbert, An Iterative Procedure for Computing the Minimum of a Quadratic Form on a
/// Convex Set, 1966).
Vector3d nearestToOrigin(const Vector3d* points, int count) {
  constexpr int kRounds = 8;
  Vector3d nearest = points[count - 1];
  for (int i = 0; i < kRounds * (count - 1); ++i) {
    const Vector3d way = points[i % count] - nearest;
    nearest += std::clamp(-nearest.dot(way) / std::max(way.squaredNorm(), kTiny), 0.0, 1.0) * way;
  }
  return nearest;
}

template <class Visit>
void forEachLeaf(const Part& part, int volume, const Visit& visit) {
  if (part[volume].isLeaf()) return visit(part[volume]);
  for (const int each : part[volume].parts) forEachLeaf(part, each, visit);
}

/// [m] How far a piece of a body reaches along a unit vector in the frame of the body.
double reachOf(const Piece& piece, const Vector3d& direction) {
  const Vector3d in_piece = piece.body_T_piece.linear().transpose() * direction;
  int vertex = 0;
  return in_piece.dot(narrowphase::supportPoint(piece.shape, in_piece, vertex)) + piece.shape.margin() +
         direction.dot(piece.body_T_piece.translation());
}

}  // namespace

PairBounds::PairBounds(const std::shared_ptr<const SceneModel>& model)
    : model_(model),
      paddings_(paddingsOf(model->pairs)),
      uncertainty_(model->robot),
      places_(model->robot.bodies.size()),
      chains_(kFrames, Chains(static_cast<int>(model->robot.joints.size()))),
      column_of_(model->robot.joints.size(), kNoColumn),
      moved_(model->robot.bodies.size() + 2),
      closing_(model->robot.joints.size()),
      held_reach_(model->robot.bodies.size()) {
  const RobotModel& robot = model->robot;
  for (int joint = 0; joint < static_cast<int>(robot.joints.size()); ++joint) leaders_.push_back(robot.leaderOf(joint));
}

void PairBounds::assume(const Uncertainty& uncertainty) {
  uncertainty.requireValidFor(model_->robot);
  uncertainty_ = uncertainty;
  TwoLargest swellings;
  for (std::size_t link = 0; link < uncertainty_.swellings.size(); ++link)
    if (model_->robot.hasGeometry(static_cast<int>(link))) swellings.offer(uncertainty_.swellings[link]);
  swellings_ = swellings.sum();
  revision_ = 0;
}

/// Forgets what depends on poses, objects and uncertainty.
void PairBounds::forgetState() {
  for (Place& place : places_) place.is_found = false;
  for (Ways& ways : ways_) ways.is_begun = false;
  bounded_.clear();
  largest_loss_.reset();
}

/// Takes the poses and the objects of a state, unless they are those of the last question.
void PairBounds::see(const State& state) {
  state_ = &state;
  if (state.revision() == revision_) return;
  state.requireModel(*model_);
  const bool has_other_objects = state.objects() != objects_;
  if (has_other_objects) likely_ = {};
  objects_ = state.objects();
  if (has_other_objects || revision_ == 0) placeObjects();
  forgetState();
  revision_ = state.revision();
}

void PairBounds::placeObjects() {
  const Objects& objects = *objects_;
  object_frames_.resize(static_cast<std::size_t>(objects.numberLimit()));
  ways_.resize(static_cast<std::size_t>(state_->volumes()->rootCount()) + object_frames_.size());
  for (Ways& ways : ways_) ways.relative_to.reserve(model_->robot.bodies.size() + 1);
  objects_lose_ = 0.0;
  TwoLargest lose;
  const auto add_reach = [&](int body, const Part& part) {
    if (!part.whole().isEmpty()) held_reach_[body] = std::max(held_reach_[body], part.whole().bounds.reach);
  };
  std::fill(held_reach_.begin(), held_reach_.end(), 0.0);
  for (int link = 0; link < static_cast<int>(model_->robot.links.size()); ++link)
    if (model_->robot.hasGeometry(link)) add_reach(model_->robot.links[link].body, state_->volumes()->part(link));
  for (const int number : objects.numbers()) {
    const PlacedObject& placed = *objects.placed(number);
    ObjectFrame& frame = object_frames_[number];
    frame = {uncertainty_.ofObject(placed.object.id), originOf(placed.object, model_->robot)};
    const Bounds& bounds = partOf(placed).whole().bounds;
    if (placed.kind == PlacedObject::Kind::Attached)
      add_reach(state_->bodyOf(ShapeRef::ofObject(number)), partOf(placed));
    if (placed.isUnbounded()) continue;
    // The geometry of a fixed object is in the frame of the object itself.
    const Vector3d origin = placed.kind == PlacedObject::Kind::Fixed ? Vector3d(Vector3d::Zero()) : frame.origin;
    const double reach = (bounds.centre - origin).norm() + bounds.radius;
    lose.offer(frame.uncertainty.translation + frame.uncertainty.angle * reach);
  }
  objects_lose_ = lose.sum();
}

// --- the chain of a pair

/// The point about which the frame of a joint is turned.
Vector3d PairBounds::jointOrigin(int body) const {
  const Body& moved = model_->robot.bodies[body];
  const Joint& joint = model_->robot.joints[moved.joint];
  if (joint.type != Joint::Type::Prismatic) return state_->poses()[body]->translation();
  return *state_->poses()[moved.parent] *
         (model_->robot.links[joint.parent_link].body_T_link * joint.parent_T_joint.translation());
}

/// Adds the joint or the base of a body. Returns false if a pose is missing that is needed.
bool PairBounds::addPlace(int body, std::vector<Displacement>& chain) const {
  const Body& moved = model_->robot.bodies[body];
  const std::optional<Isometry3d>& pose = state_->poses()[body];
  if (moved.joint < 0) {
    const PoseUncertainty& base = uncertainty_.bases[moved.robot];
    if (base.isZero()) return true;
    if (pose) addFrame(base, body, pose->translation(), chain);
    return pose.has_value();
  }
  const Joint::Mimic& leader = leaders_[moved.joint];
  const double width = std::abs(leader.multiplier) * uncertainty_.positions[leader.joint];
  const PoseUncertainty& frame = uncertainty_.frames[moved.joint];
  if (width == 0.0 && frame.isZero()) return true;
  const bool slides = model_->robot.joints[moved.joint].type == Joint::Type::Prismatic;
  if (!state_->knowsJointOf(body) || (slides && !state_->poses()[moved.parent])) return false;
  if (width > 0.0) {
    const UnitTwist twist = state_->twistOf(body);
    // Only slides may be in one group, see point 6 of Displacements.
    const bool is_together = slides && model_->robot.joints[leader.joint].type == Joint::Type::Prismatic;
    chain.push_back({slides ? Displacement::Kind::Slide : Displacement::Kind::Turn, body, width, twist.origin,
                     slides ? twist.linear : twist.angular, is_together ? leader.joint : moved.joint,
                     is_together ? leader.multiplier : 1.0});
  }
  if (!frame.isZero()) addFrame(frame, body, jointOrigin(body), chain);
  return true;
}

const PairBounds::Place& PairBounds::placeOf(int body) {
  Place& place = places_[body];
  if (place.is_found) return place;
  place.is_found = true;
  place.displacements.clear();
  place.is_known = addPlace(body, place.displacements);
  return place;
}

/// The origin of an object in the frame of the poses.
Vector3d PairBounds::originAt(int number, const Isometry3d& pose) const {
  const bool is_fixed = state_->objects()->placed(number)->kind == PlacedObject::Kind::Fixed;
  return is_fixed ? object_frames_[number].origin : Vector3d(pose * object_frames_[number].origin);
}

/// Takes one shape of a pair, and begins its chain with what it is itself. Returns false if its pose is missing.
bool PairBounds::place(const ShapeRef& ref, int number, Side& side) {
  side.chain.clear();
  side.part = state_->volumes()->part(ref, state_->objects().get());
  const PlacedObject* object = side.part.object;
  const std::optional<Isometry3d> pose = state_->poseOf(ref);
  if (!pose) return false;
  side.pose = *pose;
  if (object) addFrame(object_frames_[ref.object()].uncertainty, number, originAt(ref.object(), side.pose), side.chain);
  return true;
}

/// Finds all that displaces the two relative to each other. Returns false if a pose is missing.
bool PairBounds::begin(const ShapeRefPair& pair) {
  const RobotModel& robot = model_->robot;
  const int bodies = static_cast<int>(robot.bodies.size());
  if (!place(pair.a, bodies, a_) || !place(pair.b, bodies + 1, b_)) return false;
  int a = state_->bodyOf(pair.a), b = state_->bodyOf(pair.b);
  while (a != b) {
    int& later = a > b ? a : b;  // parents come first
    const Place& place = placeOf(later);
    if (!place.is_known) return false;
    std::vector<Displacement>& chain = a > b ? a_.chain : b_.chain;
    chain.insert(chain.end(), place.displacements.begin(), place.displacements.end());
    later = robot.bodies[later].parent;
  }
  is_exchanged_ = a_.part.isUnbounded();
  if (is_exchanged_) std::swap(a_, b_);
  padding_ = paddings_.of(pair);
  swelling_ = swellingOf(pair.a) + swellingOf(pair.b);
  // A half-space has no farthest point: its frame is the only one in which all ways are bounded.
  frame_ = b_.part.isUnbounded() ? kOfB : kCommon;
  placeSides();
  return true;
}

/// Takes the poses of the two.
void PairBounds::placeSides() {
  a_T_b_ = relative(a_.pose, b_.pose);
  for (Chains& chains : chains_) chains.is_placed = false;
  place(frame_);
}

/// Finds what displaces the two as seen from one of the frames.
void PairBounds::place(int frame) {
  Chains& chains = chains_[frame];
  if (chains.is_placed) return;
  chains.is_placed = true;
  chains.of_a.begin(a_.part.whole().bounds, a_.pose);
  chains.of_b.begin(b_.part.whole().bounds, b_.pose);
  const auto add_inverse = [](const std::vector<Displacement>& chain, Displacements& of) {
    for (auto own = chain.rbegin(); own != chain.rend(); ++own) {
      Displacement inverse = *own;
      inverse.multiplier = -inverse.multiplier;
      of.add(inverse);
    }
  };
  if (frame != kOfA)
    for (const Displacement& own : a_.chain) chains.of_a.add(own);
  if (frame != kOfB)
    for (const Displacement& own : b_.chain) chains.of_b.add(own);
  if (frame == kOfA) add_inverse(a_.chain, chains.of_b);
  if (frame == kOfB) add_inverse(b_.chain, chains.of_a);
}

/// Adds the ways by some displacements [m].
void PairBounds::Ways::add(const std::vector<Displacement>& displacements, double& sum) const {
  for (const Displacement& own : displacements) {
    if (!own.turns()) {
      sum += own.width;
      continue;
    }
    Vector3d lever = centre - own.origin;
    if (own.kind == Displacement::Kind::Turn) lever = own.axis.cross(lever);
    sum += own.width * ((1.0 + kPoseRounding) * (lever.norm() + radius) + rounding);
  }
}

/// Begins with the ways of a shape relative to its body.
void PairBounds::begin(const ShapeRef& ref, Ways& ways) {
  double sum = place(ref, 0, seen_) ? 0.0 : std::numeric_limits<double>::quiet_NaN();
  const Bounds& bounds = seen_.part.whole().bounds;
  ways.is_begun = true;
  ways.centre = seen_.pose * bounds.centre;
  ways.radius = bounds.radius;
  ways.rounding = kPoseRounding * (bounds.reach + seen_.pose.translation().norm());
  ways.body = state_->bodyOf(ref);
  ways.add(seen_.chain, sum);
  ways.relative_to.assign(1, sum);
}

/// [m] An upper bound of the way of a shape's points relative to the body that is so many steps before its own one.
double PairBounds::wayOf(const ShapeRef& ref, std::size_t steps) {
  Ways& ways = ways_[state_->volumes()->of(ref)];
  if (!ways.is_begun) begin(ref, ways);
  while (ways.relative_to.size() <= steps) {
    const Place& place = placeOf(ways.body);
    double sum = place.is_known ? ways.relative_to.back() : std::numeric_limits<double>::quiet_NaN();
    ways.add(place.displacements, sum);
    ways.relative_to.push_back(sum);
    ways.body = model_->robot.bodies[ways.body].parent;
  }
  return ways.relative_to[steps];
}

/// [m] What the lower bound of a pair loses at most. It is coarser than that of the chain of the pair, and costs much
/// less, because the pairs of a shape share its ways. Infinity for a half-space: no ball contains its points.
double PairBounds::quickLossOf(const PairProximity& pair) {
  if (isUnbounded(pair.asked.a) || isUnbounded(pair.asked.b)) return kInfinity;
  const RobotModel& robot = model_->robot;
  int a = state_->bodyOf(pair.asked.a), b = state_->bodyOf(pair.asked.b);
  std::size_t steps_a = 0, steps_b = 0;
  while (a != b) {
    int& later = a > b ? a : b;  // parents come first
    ++(a > b ? steps_a : steps_b);
    later = robot.bodies[later].parent;
  }
  const double way = wayOf(pair.asked.a, steps_a) + wayOf(pair.asked.b, steps_b);
  const double rounding = static_cast<double>(4 * robot.bodies.size() + 8) * kEpsilon;  // of the sums
  return lossOf((1.0 + rounding) * way + swellingOf(pair.asked.a) + swellingOf(pair.asked.b), pair.result.lower_bound);
}

/// [m] What a lower bound loses if the points of the two come closer by `way`; 0 if nothing is uncertain.
double PairBounds::lossOf(double way, double lower_bound) {
  return way == 0.0 ? 0.0 : (1.0 + 4.0 * kEpsilon) * way + kEpsilon * std::abs(lower_bound);
}

double PairBounds::of(const State& state, const PairProximity& pair, double enough) {
  see(state);
  if (pair.result.status == narrowphase::Status::Unknown) return std::numeric_limits<double>::quiet_NaN();
  const auto before = std::find_if(bounded_.begin(), bounded_.end(),
                                   [&](const Bounded& bounded) { return bounded.pair.isSameAs(pair.asked); });
  if (before == bounded_.end()) return bounded_.emplace_back(Bounded{pair.asked, enough, boundOf(pair, enough)}).bound;
  if (before->enough < enough && before->bound < enough) {
    before->enough = enough;
    before->bound = std::max(before->bound, boundOf(pair, enough));
  }
  return std::min(before->bound, pair.result.lower_bound);
}

double PairBounds::boundOf(const PairProximity& pair, double enough) {
  const SignedDistance& known = pair.result;
  if (enough < known.lower_bound) {
    const double quick = known.lower_bound - quickLossOf(pair);
    if (quick >= enough) return quick;
  }
  work_.beginPair();
  work_.count(kStepsOfPair);
  if (!begin(pair.asked)) return std::numeric_limits<double>::quiet_NaN();
  deciding_.leaves = {};
  nearest_state_.clear();
  loss_ = lossOf(chains_[frame_].of_a.travel() + chains_[frame_].of_b.travel() + swelling_, known.lower_bound);
  if (loss_ == 0.0) return known.lower_bound;
  const double cheap = known.lower_bound - loss_;
  if (cheap >= enough) return cheap;
  asked_ = pair.asked;
  // Where surfaces may meet, one shape may also be inside of the other.
  constexpr double kApart = 1e-9;  // [m]
  const double apart = hasInterior() ? kApart - surfaces() : -kInfinity;
  enough = std::min(known.lower_bound, std::max(enough, apart));
  constexpr double kLittle = 3e-4;  // [m]
  Known closest{is_exchanged_ ? Vector3d(-known.normal) : known.normal, known.lower_bound, cheap, kLittle};
  findGaps(closest);
  double bound = ofAllPieces(closest, enough);
  if (deciding_.leaves.areLeaves()) likely_ = {pair.asked, deciding_.leaves};
  bound = divided(bound, closest, enough);
  if (bound < apart) bound = std::min(bound, ofInteriors(closest));
  return std::max(cheap, bound);
}

// --- pieces

void PairBounds::countAlong(const Displacements& of, const narrowphase::Shape& shape) {
  const bool is_hull = shape.kind() == narrowphase::Shape::Kind::Hull;
  const std::int64_t vertices = is_hull ? static_cast<std::int64_t>(shape.hull().vertices().size()) : 8;
  work_.count(kStepsOfDirection + kStepsOfDisplacement * of.count() + kStepsOfVertex * vertices);
}

PairBounds::Along PairBounds::along(const LeafPair& leaves, const Vector3d& normal, int frame) {
  place(frame);
  Chains& chains = chains_[frame];
  const Leaf a(a_.part, leaves.a), b(b_.part, leaves.b);
  countAlong(chains.of_a, a.piece.shape);
  countAlong(chains.of_b, b.piece.shape);
  const Vector3d from = a_.pose.translation();
  const Displacements::Lowest of_a = chains.of_a.lowest(a.piece, -normal, from),
                              of_b = chains.of_b.lowest(b.piece, normal, from);
  const double remainder = chains.of_a.remainder(-normal) + chains.of_b.remainder(normal) +
                           PlacedRobot::rounding(a.volume, b.volume, a_T_b_);
  return {of_a.present + of_b.present - padding_,
          of_a.displaced + of_b.displaced - remainder - surfaces(),
          of_a.loss + of_b.loss,
          frame,
          {leaves, normal, from + of_a.point, from + of_b.point}};
}

/// Tries the other frames, unless they cannot help: only one of the two is displaced, and the closest points lose about
/// as much in each of them. Then it turns the normal, see turn().
void PairBounds::improve(Along& best, double enough, double little) {
  constexpr double kMuchMore = 1.05;
  if (b_.part.isUnbounded()) return;
  const bool are_both_displaced = !a_.chain.empty() && !b_.chain.empty();
  if (are_both_displaced || best.present - swelling_ - best.bound > kMuchMore * best.loss) {
    for (const int frame : {kOfA, kOfB}) {
      const Along other = along(best.where.leaves, best.where.normal, frame);
      if (other.bound > best.bound) best = other;
    }
  }
  turn(best, enough, little);
}

/// Turns the normal so that the bound becomes larger. To first order the bound is the support height of a convex set,
/// all differences of displaced points of the cores, and the best normal points to the point of this set that is the
/// nearest to the origin. As in GJK, that of the support points so far gives the next normal. `little` [m] is not worth
/// the steps.
void PairBounds::turn(Along& best, double enough, double little) {
  constexpr int kMostSteps = 6;
  constexpr double kMuch = 0.05;  // of the loss
  if (best.present - best.bound <= little) return;
  const LeafPair leaves = best.where.leaves;
  const double margins =
      padding_ + Leaf(a_.part, leaves.a).piece.shape.margin() + Leaf(b_.part, leaves.b).piece.shape.margin();
  std::array<Vector3d, kMostSteps + 1> points{(best.present + margins) * best.where.normal};
  Along last = best;
  double lowest = 0.0;
  for (int i = 0; i < kMostSteps && best.bound < enough && best.present + margins > 0.0; ++i) {
    Chains& chains = chains_[last.frame];
    const Deciding& where = last.where;
    points[i + 1] = where.point_b + chains.of_b.lowestStep(where.point_b, where.normal) - where.point_a -
                    chains.of_a.lowestStep(where.point_a, -where.normal);
    lowest = std::max(lowest, where.normal.dot(points[i + 1]));
    const Vector3d nearest = nearestToOrigin(points.data(), i + 2);
    const double length = nearest.norm();
    if (!(length - lowest > std::max(little, kMuch * (best.present - best.bound)))) return;
    last = along(leaves, nearest / length, last.frame);
    if (last.bound > best.bound) best = last;
  }
}

/// Finds what the normal excludes.
void PairBounds::findGaps(Known& known) {
  if (!known.hasNormal()) return;
  known.in_a = a_.pose.linear().transpose() * known.normal;
  known.in_b = b_.pose.linear().transpose() * known.normal;
  known.between = (b_.pose.translation() - a_.pose.translation()).dot(known.normal) -
                  PlacedRobot::rounding(a_.part.whole(), b_.part.whole(), a_T_b_) - padding_;
  known.loss = kInfinity;
  if (a_.part.whole().isLeaf() && b_.part.whole().isLeaf()) return;
  Chains& chains = chains_[frame_];
  known.loss = chains.of_a.largestLoss(-known.normal) + chains.of_b.largestLoss(known.normal) +
               chains.of_a.remainder(-known.normal) + chains.of_b.remainder(known.normal) + swelling_;
}

/// [m] A lower bound of how far two volumes are apart along the normal now.
double PairBounds::gapAlong(const Volume& a, const Volume& b, const Known& known) {
  return known.between + known.in_b.dot(b.bounds.centre) - known.in_a.dot(a.bounds.centre) -
         (a.bounds.axes.transpose() * known.in_a).cwiseAbs().dot(a.bounds.half) -
         (b.bounds.axes.transpose() * known.in_b).cwiseAbs().dot(b.bounds.half);
}

/// [m] A lower bound of how far two pieces are apart along the normal now.
double PairBounds::gapAlong(const LeafPair& leaves, const Known& known) const {
  return known.between - reachOf(Leaf(a_.part, leaves.a).piece, known.in_a) -
         reachOf(Leaf(b_.part, leaves.b).piece, -known.in_b);
}

/// [m] A lower bound of the distance of all pieces. It is not improved above `enough`.
double PairBounds::ofAllPieces(const Known& known, double enough) {
  double lowest = enough;
  if (b_.part.isUnbounded())
    for (std::size_t i = 0; i < b_.part.halfSpaces().size(); ++i)
      boundHalfSpace(a_.part.root, static_cast<int>(i), lowest);
  if (b_.part.whole().isEmpty()) return lowest;
  // The pieces that decided the last time are likely to be the lowest ones, and exclude most others.
  if (!(likely_.pair.a == asked_.a && likely_.pair.b == asked_.b)) likely_ = {asked_, {}};
  if (likely_.leaves.areLeaves() && !work_.isOver()) boundPieces(likely_.leaves, known, lowest);
  visits_ = 0;
  boundVolumes({a_.part.root, b_.part.root}, -kInfinity, known, lowest);
  return lowest;
}

/// [m] A lower bound of the distance of the pieces of two volumes. It is not improved above `enough`.
double PairBounds::ofVolumes(const PartPair& volumes, const Known& known, double enough) const {
  const Volume &a = a_.part[volumes.a], &b = b_.part[volumes.b];
  double bound = known.hasNormal() ? gapAlong(a, b, known) - known.loss : -kInfinity;
  if (bound < enough) bound = std::max(bound, sphereGap(a.bounds, b.bounds, a_T_b_) - padding_ - loss_);
  if (bound < enough) bound = std::max(bound, boxGap(a.bounds, b.bounds, a_T_b_) - padding_ - loss_);
  return bound;
}

/// Lowers the bound of all pieces to that of the pieces of two volumes, which have the bound `own`. After kMostVisits,
/// or when the work of the pair is over, the bounds of what is left are taken as they are.
void PairBounds::boundVolumes(const PartPair& volumes, double own, const Known& known, double& lowest) {
  if (own >= lowest || lowest <= known.without_pieces) return;
  if (work_.isOver()) {
    lowest = own;
    return;
  }
  const Volume &a = a_.part[volumes.a], &b = b_.part[volumes.b];
  if (a.isLeaf() && b.isLeaf()) {
    const LeafPair leaves{volumes.a, volumes.b};
    if (leaves == likely_.leaves) return;
    const bool is_excluded = known.hasNormal() && gapAlong(leaves, known) - known.loss >= lowest;
    if (!is_excluded) boundPieces(leaves, known, lowest);
    return;
  }
  constexpr int kMostVisits = 1000;
  if (++visits_ > kMostVisits) {
    lowest = own;
    return;
  }
  work_.count(kStepsOfVisit);
  const bool split_a = splitsFirst(a, b);
  std::array<PartPair, 2> parts{volumes, volumes};
  std::array<double, 2> bounds{};
  for (std::size_t i = 0; i < 2; ++i) {
    (split_a ? parts[i].a : parts[i].b) = (split_a ? a : b).parts[i];
    bounds[i] = ofVolumes(parts[i], known, lowest);
  }
  const std::size_t first = bounds[1] < bounds[0] ? 1 : 0;
  boundVolumes(parts[first], bounds[first], known, lowest);
  boundVolumes(parts[1 - first], bounds[1 - first], known, lowest);
}

/// [m] A lower bound of the distance of what the interior of one part adds: that of the balls of the representatives of
/// the other part, see findInteriorDepths(), along the normal. An interior is in the convex hull of the pieces.
double PairBounds::ofInteriors(const Known& known) {
  if (!known.hasNormal() || b_.part.isUnbounded()) return -kInfinity;
  Chains& chains = chains_[frame_];
  const Vector3d from = a_.pose.translation();
  const double margins = chains.of_a.remainder(-known.normal) + chains.of_b.remainder(known.normal) + surfaces() +
                         4.0 * PlacedRobot::rounding(a_.part.whole(), b_.part.whole(), a_T_b_);
  const auto lowest = [&](Displacements& of, const Part& part, const Vector3d& n, const auto& heightOf) {
    double height = kInfinity;
    forEachLeaf(part, part.root,
                [&](const Volume& leaf) { height = std::min(height, heightOf(of, leaf, part.pieces[leaf.piece], n)); });
    return height;
  };
  const auto solid = [&](Displacements& of, const Volume&, const Piece& piece, const Vector3d& n) {
    countAlong(of, piece.shape);
    return work_.isOver() ? -kInfinity : of.lowest(piece, n, from).displaced;
  };
  const auto ball = [&](Displacements& of, const Volume& leaf, const Piece& piece, const Vector3d& n) {
    const double radius = std::max(0.0, piece.shape.innerRadius()) + piece.shape.margin();
    return leaf.has_representative ? of.displacedHeight(piece.body_T_piece * piece.shape.centre(), n, from) - radius
                                   : kInfinity;
  };
  double bound = kInfinity;
  if (b_.part.whole().has_interior)
    bound = lowest(chains.of_a, a_.part, -known.normal, ball) + lowest(chains.of_b, b_.part, known.normal, solid);
  if (a_.part.whole().has_interior)
    bound = std::min(
        bound, lowest(chains.of_a, a_.part, -known.normal, solid) + lowest(chains.of_b, b_.part, known.normal, ball));
  return bound - margins;
}

/// Lowers the bound of all pieces to that of two of them.
void PairBounds::boundPieces(const LeafPair& leaves, const Known& known, double& lowest) {
  Along best{-kInfinity, -kInfinity, 0.0, frame_, {leaves, Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()}};
  if (known.hasNormal()) best = along(leaves, known.normal, frame_);
  if (best.bound >= lowest) return;
  const double present = best.present;
  if (known.hasNormal()) improve(best, lowest, known.little);
  if (best.bound >= lowest) return;
  // [m] Two pieces that are as close as the closest ones along their normal have this normal, too.
  constexpr double kAsClose = 1e-9;
  if (present < known.lower_bound - kAsClose) {
    const SignedDistance own = measured(leaves, a_T_b_, lowest + loss_);
    if (own.lower_bound - loss_ >= lowest) return;
    if (own.normal.allFinite()) {
      Along along_own = along(leaves, a_.pose.linear() * own.normal, frame_);
      improve(along_own, lowest, known.little);
      if (along_own.bound > best.bound) best = along_own;
    }
    best.bound = std::max(best.bound, own.lower_bound - loss_);
    if (best.bound >= lowest) return;
  }
  lowest = best.bound;
  deciding_ = best.where;
}

void PairBounds::boundHalfSpace(int volume, int number, double& lowest) {
  const PlacedHalfSpace& half_space = b_.part.halfSpaces()[number];
  const Volume& a = a_.part[volume];
  const double rounding = PlacedRobot::rounding(a_.part.whole(), b_.part.whole(), a_T_b_);
  const double own = halfSpaceGap(a, half_space, a_T_b_, rounding) - padding_ - loss_;
  if (own >= lowest) return;
  work_.count(kStepsOfVisit);
  if (work_.isOver()) {
    lowest = own;
    return;
  }
  if (!a.isLeaf()) {
    for (const int part : a.parts) boundHalfSpace(part, number, lowest);
    return;
  }
  const Vector3d up = (b_.pose.linear() * half_space.normal).normalized(), from = b_.pose.translation();
  countAlong(chains_[kOfB].of_a, a_.part.pieces[a.piece].shape);
  const Displacements::Lowest found = chains_[kOfB].of_a.lowest(a_.part.pieces[a.piece], up, from);
  const double bound =
      found.displaced - half_space.offset - chains_[kOfB].of_a.remainder(up) - 2.0 * rounding - surfaces();
  if (bound >= lowest) return;
  lowest = bound;
  LeafPair leaves;
  leaves.a = volume;
  leaves.half_space = number;
  const Vector3d below = found.point - (up.dot(found.point) - half_space.offset) * up;
  deciding_ = {leaves, -up, from + found.point, from + below};
}

/// The distance of two pieces, or of a piece and a half-space, in the frame of the body of a.
SignedDistance PairBounds::measured(const LeafPair& leaves, const RelativePose& a_T_b, double stop_above) {
  work_.count(kStepsOfQuery);
  const Leaf a(a_.part, leaves.a);
  narrowphase::Options options;
  options.stop_above = stop_above + padding_;
  if (leaves.hasHalfSpace()) {
    const double rounding = PlacedRobot::rounding(a_.part.whole(), b_.part.whole(), a_T_b);
    return padded(halfSpaceDistance(a.piece, b_.part.halfSpaces()[leaves.half_space], a_T_b, rounding,
                                    options.distance_tolerance),
                  padding_);
  }
  narrowphase::WarmStart cold;
  return padded(PlacedRobot::distanceInBodyA(a, Leaf(b_.part, leaves.b), a_T_b, options, cold), padding_);
}

}  // namespace proximity_server::scene
