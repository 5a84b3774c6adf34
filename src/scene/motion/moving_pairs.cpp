#include "scene/motion/moving_pairs.h"

#include "proximity_server/scene/model/kinematics.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr int kNoFrame = -2;  // the frame of a moving object, if the motion has no frames

// [m] A pair with a half-space is unknown in a motion that leads farther away from the half-space.
constexpr double kFarthestReach = 1e12;

constexpr double kMiddle = PosesInTime::kMiddle;

/// The box of HalfSpaceBox; its upper face is on the plane.
Piece boxBelow(const PlacedHalfSpace& half_space, double reach) {
  constexpr double kSmallest = 1e-3;  // [m] so that the box has a size even for a point at the origin
  const double deepest = std::max(reach + std::abs(half_space.offset), kSmallest);
  const double width = 2.0 * (reach + deepest), height = 2.0 * deepest;
  Isometry3d pose = Isometry3d::Identity();
  const Vector3d along = half_space.normal.unitOrthogonal();
  pose.linear() << along, half_space.normal.cross(along), half_space.normal;
  pose.translation() = (half_space.offset - 0.5 * height) * half_space.normal;
  return {narrowphase::Box{{width, width, height}}, pose, half_space.shape};
}

Volume leafOver(const Piece& piece) {
  Volume leaf;
  leaf.piece = 0;
  leaf.bounds = boundsOf(piece);
  return leaf;
}

}  // namespace

// The axes of the box are unit vectors and perpendicular within 8 eps. That moves a point of the face by the same
// fraction of its distance from the middle, which is at most `reach` for the points that matter. The middle itself is
// off by less than 8 eps of the height of the box.
HalfSpaceBox::HalfSpaceBox(const PlacedHalfSpace& half_space, double reach)
    : piece(boxBelow(half_space, reach)),
      volume(leafOver(piece)),
      error(kPoseRounding * (reach + half_space.chain_length)) {}

MovingPairs::MovingPairs(std::shared_ptr<const SceneModel> model, std::shared_ptr<const Volumes> volumes)
    : model_(std::move(model)), volumes_(std::move(volumes)), paddings_(paddingsOf(model_->pairs)) {}

void MovingPairs::begin(const Pairs& pairs, const RobotMotion& motion, const JointDeviations& deviations,
                        const MotionQuestion* contact, double limit) {
  requireFrames(motion);
  contact_ = contact;
  limit_ = limit;
  deviations_ = deviations;
  slide_ = 0.0;
  for (const JointDeviation& joint : deviations) slide_ += joint.turns ? 0.0 : joint.most;
  size_ = 0;
  half_spaces_.clear();
  fixed_frames_.clear();
  at_leaf_.clear();
  asked_ = unknown_ = too_far_ = 0;
  poses_.follow(motion);
  has_frames_ = !motion.objectFrames().moving.empty();
  if (pairs.includeLinks())
    for (const ShapeRefPair& pair : pairs.list()) unknown_ += !add(participant(pair.a), participant(pair.b));
  of_list_ = asked_;
  if (pairs.includeObjects(objects_.get())) addObjectPairs();
}

void MovingPairs::requireFrames(const RobotMotion& motion) const {
  const std::size_t bodies = model_->robot.bodies.size(), frames = objects_ ? objects_->frames().size() : 0;
  if (motion.segments().size() != bodies)
    throw std::invalid_argument("the robot has " + std::to_string(bodies) + " bodies, but the motion is of " +
                                std::to_string(motion.segments().size()));
  const std::size_t given = motion.objectFrames().moving.size();
  if (given != 0 && given != frames)
    throw std::invalid_argument("the objects have " + std::to_string(frames) + " frames, but the motion is of " +
                                std::to_string(given));
}

int MovingPairs::examined() const {
  int count = 0, last = -1;
  for (int i = 0; i < size_; ++i) {
    const PairInMotion& pair = pairs_[i];
    if (!pair.is_examined || pair.kind == PairInMotion::Kind::FixedObjects || pair.number == last) continue;
    last = pair.number;
    ++count;
  }
  return count;
}

double MovingPairs::roundingOf(const ShapeRefPair& pair, double time) {
  const Participant a = participant(pair.a), b = participant(pair.b);
  return MovingBodies(poses_, a.body, a.whole().bounds, b.body, b.whole().bounds).roundingAt(time, poses_);
}

// --- participants

MovingPairs::Participant MovingPairs::participant(const ShapeRef& ref) {
  Participant who{volumes_->part(ref, objects_.get()), ref};
  if (who.object) who.body = frameOf(ref.object(), *who.object);
  return who;
}

int MovingPairs::frameOf(int number, const PlacedObject& object) {
  switch (object.kind) {
    case PlacedObject::Kind::Attached:
      return object.body;
    case PlacedObject::Kind::Moving:
      return has_frames_ ? poses_.moving(objects_->frameOf(number)) : kNoFrame;
    case PlacedObject::Kind::Fixed:
      break;
  }
  const auto [place, is_new] = fixed_frames_.emplace(number, 0);
  if (is_new) place->second = poses_.add(object.world_T_object);
  return place->second;
}

bool MovingPairs::isKnown(const Participant& who) const {
  if (who.isFree() && !poses_.isKnown(poses_.world())) return false;
  return who.body != kNoFrame && poses_.isKnown(who.body);
}

// --- pairs

/// Adds the pairs in motion for a pair of the question. Returns false if a pose or all geometry is missing.
bool MovingPairs::add(const Participant& a, const Participant& b) {
  if (a.isUnbounded() && b.isUnbounded()) throw std::invalid_argument("the distance of two half-spaces is not defined");
  if (!isKnown(a) || !isKnown(b)) return false;
  const double contact_distance = contactDistanceOf({a.ref, b.ref});
  if (stayApart(a, b, std::max(0.0, std::min(limit_, contact_distance)))) {
    ++asked_;
    return true;
  }
  const int before = size_;
  addSolids(a, b);
  if (a.isUnbounded() || b.isUnbounded()) addHalfSpaces(a, b);
  if (size_ == before) return false;
  for (int i = before; i < size_; ++i) pairs_[i].contact_distance = contact_distance;
  ++asked_;
  return true;
}

/// True if two solids are farther apart than `limit` during the whole motion, by their spheres in its middle and by how
/// far the frames between them, with the deviations of joints, move them from there. In a slow motion that holds for most
/// pairs, and costs a fraction of their exact motion.
///
/// A point moves from its place in the middle of a motion by at most half of the way of its frame's origin, which has a
/// constant speed, and half of the turn times its distance from this origin. The frames move one after the other, the
/// ones next to the geometry last: so each distance is taken in the middle of the motion.
bool MovingPairs::stayApart(const Participant& a, const Participant& b, double limit) {
  if (a.isUnbounded() || b.isUnbounded() || a.whole().isEmpty() || b.whole().isEmpty()) return false;
  const Bounds &of_a = a.whole().bounds, &of_b = b.whole().bounds;
  const Isometry3d pose_a = poses_.pose(a.body, kMiddle), pose_b = poses_.pose(b.body, kMiddle);
  const BodyPoses& middle = poses_.at(kMiddle);
  const auto originOf = [&](int frame) -> Vector3d {
    if (frame < static_cast<int>(middle.size())) return middle[frame]->translation();
    return poses_.pose(frame, kMiddle).translation();
  };
  const Vector3d centre_a = pose_a * of_a.centre, centre_b = pose_b * of_b.centre;
  const double between = (centre_b - centre_a).norm() - of_a.radius - of_b.radius - paddings_.of({a.ref, b.ref});
  if (!(between > limit)) return false;
  double lengths = of_a.reach + of_b.reach + 4.0 * std::max(pose_a.translation().norm(), pose_b.translation().norm());
  const auto effect = [&](int frame, const Vector3d& centre, double radius) {
    const narrowphase::ScrewMotion& motion = poses_.segment(frame).motion;
    double slide = 0.5 * motion.linear.norm(), turn = 0.5 * motion.angular.norm();
    if (frame < static_cast<int>(deviations_.size()))
      (deviations_[frame].turns ? turn : slide) += deviations_[frame].most;
    return turn > 0.0 ? slide + turn * ((centre - originOf(frame)).norm() + radius) : slide;
  };
  const PosesInTime::Way& way = poses_.wayBetween(a.body, b.body);
  for (std::size_t i = 0; i < way.size(); ++i) {
    const narrowphase::ScrewMotion& motion = poses_.segment(way.frame(i)).motion;
    lengths += 2.0 * (motion.start.translation().norm() + motion.linear.norm());
  }
  const double of_joints = way.smallestSum(
      effects_, [&](int frame) { return effect(frame, centre_a, of_a.radius); },
      [&](int frame) { return effect(frame, centre_b, of_b.radius); });
  return between - (1.0 + kPoseRounding) * of_joints - kPoseRounding * lengths > limit;
}

double MovingPairs::contactDistanceOf(const ShapeRefPair& pair) const {
  if (!contact_) return std::numeric_limits<double>::infinity();
  double distance = contact_->contact_distance + (contact_->thresholds ? contact_->thresholds->of(pair) : 0.0);
  for (const PairContactDistance& own : contact_->nearer_pairs)
    if (own.pair.isSameAs(pair)) distance = std::min(distance, own.contact_distance);
  return distance;
}

/// A new pair of parts, as yet without motion. The memory of a pair of an earlier motion is used again.
PairInMotion& MovingPairs::next(const ShapeRefPair& asked, const Part& a, const Part& b) {
  if (size_ == static_cast<int>(pairs_.size())) pairs_.emplace_back();
  PairInMotion& pair = pairs_[size_++];
  MovingBodies bodies = std::move(pair.bodies);
  pair = PairInMotion();
  pair.bodies = std::move(bodies);
  pair.asked = asked;
  pair.number = asked_;
  pair.a = a;
  pair.b = b;
  return pair;
}

void MovingPairs::addSolids(const Participant& a, const Participant& b) {
  const Volume &root_a = a.whole(), &root_b = b.whole();
  if (root_a.isEmpty() || root_b.isEmpty()) return;
  PairInMotion& pair = next({a.ref, b.ref}, a, b);
  pair.padding = paddings_.of(pair.asked);
  const SeenFrom from = b.isFree() ? SeenFrom::B : a.isFree() ? SeenFrom::A : SeenFrom::Middle;
  pair.bodies.follow(poses_, a.body, root_a.bounds, b.body, root_b.bounds, from);
  pair.error = pair.bodies.chainRounding();
  for (const Participant* who : {&a, &b})
    if (who->object) pair.error += who->object->geometry->excessRounding();
  pair.is_compound = !root_a.isLeaf() || !root_b.isLeaf() || a.isUnbounded() || b.isUnbounded();
  pair.deviation = deviationOf(a, root_a.bounds, b, root_b.bounds);
}

/// Adds the pairs of a solid and half-spaces. The half-spaces are seen at rest.
void MovingPairs::addHalfSpaces(const Participant& a, const Participant& b) {
  const bool in_a = a.isUnbounded();
  const Participant &solid = in_a ? b : a, &unbounded = in_a ? a : b;
  if (solid.whole().isEmpty()) return;
  const SeenFrom from = in_a ? SeenFrom::A : SeenFrom::B;
  const auto follow = [&](const Bounds& stand_in, MovingBodies& bodies) {
    bodies.follow(poses_, a.body, in_a ? stand_in : a.whole().bounds, b.body, in_a ? b.whole().bounds : stand_in, from);
  };
  MovingBodies without_box;
  follow(Bounds(), without_box);
  const double reach = without_box.reach() + slide_, rounding = without_box.chainRounding();
  const double rounding_of_solid = solid.object ? solid.object->geometry->excessRounding() : 0.0;
  if (!(reach <= kFarthestReach)) return;
  const std::vector<PlacedHalfSpace>& half_spaces = unbounded.halfSpaces();
  for (const PlacedHalfSpace& half_space : half_spaces) {
    const HalfSpaceBox& box = half_spaces_.emplace_back(half_space, reach);
    const Part stand_in{&box.volume, &box.piece};
    PairInMotion& pair = next({a.ref, b.ref}, in_a ? stand_in : a, in_a ? b : stand_in);
    follow(box.volume.bounds, pair.bodies);
    pair.error = box.error + rounding + rounding_of_solid;
    pair.kind = PairInMotion::Kind::HalfSpace;
    // The way out of one half-space is the same for all pieces.
    pair.is_compound = half_spaces.size() > 1 || !unbounded.whole().isEmpty();
    const Bounds &box_bounds = box.volume.bounds, &solid_bounds = solid.whole().bounds;
    pair.deviation = deviationOf(a, in_a ? box_bounds : solid_bounds, b, in_a ? solid_bounds : box_bounds);
  }
}

double MovingPairs::deviationOf(const Participant& a, const Bounds& bounds_a, const Participant& b,
                                const Bounds& bounds_b) {
  return distanceDeviation(deviations_, {a.body, bounds_a}, {b.body, bounds_b}, poses_, effects_);
}

// --- candidates with objects

void MovingPairs::addObjectPairs() {
  for (int link = 0; link < static_cast<int>(model_->robot.links.size()); ++link)
    if (model_->robot.hasGeometry(link)) addPairsOf(participant(link));
  for (const int searcher : objects_->searchers()) addPairsOf(participant(ShapeRef::ofObject(searcher)));
}

/// Adds the pairs that ObjectVisits visits; but here moving objects are in no tree.
void MovingPairs::addPairsOf(const Participant& searcher) {
  if (!isKnown(searcher)) return;
  const auto addAll = [&](const std::vector<int>& numbers) {
    for (const int number : numbers) addIfChecked(searcher, number);
  };
  if (searcher.isUnbounded()) return addAll(objects_->numbers());
  addFixedObjects(searcher);
  addAll(objects_->fixed().loose());
  addAll(objects_->unbounded());
  for (const int number : objects_->moving())
    if (!objects_->placed(number)->isUnbounded()) addIfChecked(searcher, number);
  for (const int number : objects_->searchers())
    if (objects_->placed(number)->kind == PlacedObject::Kind::Attached) addIfChecked(searcher, number);
}

void MovingPairs::addFixedObjects(const Participant& searcher) {
  if (tree().empty() || !poses_.isKnown(poses_.world())) return;
  const Bounds bounds = searcher.whole().bounds;
  Participant all;
  all.body = poses_.world();
  const Bounds of_all = boundsOf(tree()[0].box);
  PairInMotion& pair = next({searcher.ref, ShapeRef()}, searcher, {});
  pair.number = -1;
  pair.kind = PairInMotion::Kind::FixedObjects;
  pair.bodies.follow(poses_, searcher.body, bounds, all.body, of_all, SeenFrom::B);
  pair.deviation = deviationOf(searcher, bounds, all, of_all);
  pair.contact_distance = contactDistanceOf(pair.asked);
  if (contact_ && contact_->thresholds)  // the distance of each object counts
    pair.contact_distance =
        std::max(pair.contact_distance, contact_->contact_distance + contact_->thresholds->largestOfObjects());
}

void MovingPairs::addIfChecked(const Participant& searcher, int number) {
  if (!objects_->isCheckedBy(searcher.ref, number)) return;
  const Participant other = participant(ShapeRef::ofObject(number));
  const bool is_first = searcher.ref.isLink() || searcher.ref.object() < number;
  const bool is_added = is_first ? add(searcher, other) : add(other, searcher);
  too_far_ += !is_added && isKnown(other);
}

int MovingPairs::pairAt(int with_all, const BoxTree::Node& leaf) {
  const auto [found, is_new] = at_leaf_.emplace(std::make_pair(with_all, leaf.item), -1);
  if (!is_new) return found->second;
  const FixedObjects::Item& entry = objects_->fixed().item(leaf.item);
  const PlacedObject* object = objects_->placed(entry.number);
  if (!object || object->serial != entry.serial) return -1;
  const int before = size();
  addIfChecked(participant(pairs_[with_all].asked.a), entry.number);
  if (size() > before) found->second = before;
  return found->second;
}

}  // namespace proximity_server::scene
