#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/motion/motion_question.h"
#include "proximity_server/scene/motion/robot_motion.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/pairs.h"
#include "scene/motion/moving_bodies.h"
#include "scene/objects/placed_object.h"
#include "scene/parts/placed_robot.h"
#include "scene/parts/volumes.h"

namespace proximity_server::scene {

/// Two parts in motion: what a pair of a question consists of, or a link or object and all fixed objects.
struct PairInMotion {
  ShapeRefPair asked;  ///< without b if b is all fixed objects
  int number;          ///< of the pair of the question; an object with half-spaces makes several with one number
  double padding;      ///< [m]
  /// [m] By how much the distance may be off: MovingBodies::chainRounding(), and of a half-space that of what stands for
  /// it, see HalfSpaceBox.
  double error;
  Part a, b;
  MovingBodies bodies;
  enum class Kind : unsigned char { Shapes, HalfSpace, FixedObjects };
  Kind kind = Kind::Shapes;
  double contact_distance = 0.0;  ///< [m] of the question, for this pair; infinity if it asks for none
  bool is_compound = false;       ///< one of the two has several parts
  bool is_examined = false;       ///< one bound for the whole motion did not settle it

  bool isOfShapes() const { return kind != Kind::FixedObjects; }
};

/// A box that stands for a half-space. No point of the other shape is farther than `reach` from the origin during the
/// motion, so that its lateral distance from the middle of the box's upper face, the point of the plane next to the
/// origin, is at most `reach`, and so is any depth below the plane, with |offset| added: D.
///
/// 1. Apart, the point of the half-space that is next to a point of the shape is below that point, on the face if the face
///    extends farther than `reach`.
/// 2. In overlap by d <= D, take the deepest point of the shape. To get out in another unit direction u than up takes at
///    least (w - reach) |u_lateral| + d u_up, or (w - reach) |u_lateral| + (h - d) |u_up| if u points down, where w is half the
///    width of the box and h its height. With w = reach + D and h = 2 D neither is less than d.
///
/// So the box has the distance of the half-space, up to the rounding of the box's pose (PairInMotion::error).
struct HalfSpaceBox {
  HalfSpaceBox(const PlacedHalfSpace& half_space, double reach);

  Piece piece;
  Volume volume;
  double error;  ///< [m]
};

/// The pairs of a question about a motion. Pairs with fixed objects are made when a search has come to their leaf of the
/// tree of fixed objects; all others are made at once.
class MovingPairs {
 public:
  MovingPairs(std::shared_ptr<const SceneModel> model, std::shared_ptr<const Volumes> volumes);

  void use(std::shared_ptr<const Objects> objects) { objects_ = std::move(objects); }
  /// nullptr before the first use().
  const std::shared_ptr<const Objects>& objects() const { return objects_; }

  /// `contact` is the question about a contact, which has to outlive the pairs; nullptr if there is none.
  ///
  /// Throws std::invalid_argument for a motion of another number of bodies or frames, and for what does not exist.
  void begin(const Pairs& pairs, const RobotMotion& motion, const MotionQuestion* contact = nullptr);

  int size() const { return static_cast<int>(pairs_.size()); }
  PairInMotion& operator[](int pair) { return pairs_[static_cast<std::size_t>(pair)]; }
  PosesInTime& poses() { return *poses_; }

  /// Of the pairs of the list, how many have no pose or no geometry; and how many candidates with objects have no answer
  /// although all poses are known: the motion leads too far away.
  int unknownOfList() const { return unknown_; }
  int tooFar() const { return too_far_; }

  /// How many candidates with objects have an answer, those with fixed objects left out that are in the tree.
  int withObjects() const { return asked_ - of_list_; }

  /// [m] See PairInMotion::contact_distance.
  double contactDistanceOf(const ShapeRefPair& pair) const;

  /// How many pairs of the question one bound did not settle.
  int examined() const;

  /// [m] See MovingBodies::roundingAt(); of a pair whose poses are known.
  double roundingOf(const ShapeRefPair& pair, double time);

  /// The tree of the fixed objects, in the world.
  const BoxTree& tree() const { return objects_->fixed().tree(); }

  /// The pair of the link or object of a pair with all fixed objects, and the fixed object of a leaf of the tree; -1 if
  /// the object is not there any more, or the two are not checked.
  int pairAt(int with_all, int item);

  /// The <collision> or the shape of a leaf, counted from 1.
  int collisionNumber(const ShapeRef& ref, const Piece& piece) const;

 private:
  /// A part whose body is a frame of PosesInTime.
  struct Participant : Part {
    ShapeRef ref;
  };

  Participant participant(const ShapeRef& ref);
  int frameOf(int number, const PlacedObject& object);
  bool isKnown(const Participant& who) const;
  bool add(const Participant& a, const Participant& b);
  void addSolids(const Participant& a, const Participant& b);
  void addHalfSpaces(const Participant& a, const Participant& b);
  void addObjectPairs();
  void addPairsOf(const Participant& walker);
  void addIfChecked(const Participant& walker, int number);
  void addFixedObjects(const Participant& walker);
  void requireFrames(const RobotMotion& motion) const;

  const std::shared_ptr<const SceneModel> model_;
  const std::shared_ptr<const Volumes> volumes_;
  const PairDistances paddings_;
  std::shared_ptr<const Objects> objects_;

  std::optional<PosesInTime> poses_;
  const MotionQuestion* contact_ = nullptr;
  std::vector<PairInMotion> pairs_;
  std::deque<HalfSpaceBox> half_spaces_;        ///< to which pairs refer
  std::map<int, int> fixed_frames_;             ///< in PosesInTime, of fixed objects by their number
  std::map<std::pair<int, int>, int> at_leaf_;  ///< results of pairAt()
  bool has_frames_ = false;                     ///< the motion knows those of moving objects
  int asked_ = 0, of_list_ = 0, unknown_ = 0, too_far_ = 0;
};

}  // namespace proximity_server::scene
