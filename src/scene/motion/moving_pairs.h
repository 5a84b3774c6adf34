#pragma once

#include "proximity_server/scene/motion/motion_question.h"
#include "proximity_server/scene/motion/robot_motion.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/pairs.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "scene/motion/joint_deviations.h"
#include "scene/motion/moving_bodies.h"
#include "scene/objects/placed_object.h"
#include "scene/state/placed_robot.h"
#include "scene/state/volumes.h"

#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// Two parts in motion: a pair that a question is about, or a link or object together with all fixed objects.
struct PairInMotion {
  ShapeRefPair asked;  ///< b is missing if it stands for all fixed objects
  /// number of the pair in the question; the pairs that an object with half-spaces makes have the same number
  int number = 0;
  double padding = 0.0;  ///< [m]
  /// [m] How far the distance may be off: MovingBodies::chainRounding(), and for a half-space also the error of the box
  /// that stands for it, see HalfSpaceBox.
  double error = 0.0;
  Part a, b;
  MovingBodies bodies;
  enum class Kind : unsigned char { Shapes, HalfSpace, FixedObjects };
  Kind kind = Kind::Shapes;
  double contact_distance = 0.0;  ///< [m] for this pair; infinity if the question is not about a contact
  double deviation = 0.0;         ///< [m] see distanceDeviation()
  bool is_compound = false;       ///< one of the two has several pieces or half-spaces
  bool is_examined = false;       ///< one bound for the whole motion did not settle it
  /// [m] the smallest lower bound, minus the loss, of all parts that a search of the minimum has settled or left
  double nearest = std::numeric_limits<double>::infinity();

  bool isOfShapes() const { return kind != Kind::FixedObjects; }

  /// [m] What is taken off the distance of the shapes.
  double loss() const { return padding + deviation; }
};

/// A box that stands for a half-space. During the motion, no point of the other shape is farther than `reach` from the
/// origin. So its lateral distance from the middle of the upper face of the box, which is the point of the plane next
/// to the origin, is at most `reach`, and its depth below the plane is at most D = reach + |offset|.
///
/// 1. Apart: the point of the half-space nearest to a point of the shape is straight below it, and it is on the face if
///    the face extends farther than `reach`.
/// 2. In overlap by d <= D: take the deepest point of the shape. The way out in a unit direction u other than up is at
///    least (w - reach) |u_lateral| + d u_up, or (w - reach) |u_lateral| + (h - d) |u_up| if u points down. Here w is
///    half the width of the box and h its height. With w = reach + D and h = 2 D neither is less than d.
///
/// So the box has the distance of the half-space, up to the rounding of the box's pose (PairInMotion::error).
struct HalfSpaceBox {
  HalfSpaceBox(const PlacedHalfSpace& half_space, double reach);

  Piece piece;
  Volume volume;
  double error;  ///< [m]
};

/// The pairs of a question about a motion. Pairs with fixed objects are made when a search has reached their leaf of
/// the tree of fixed objects; all others are made at once.
class MovingPairs {
 public:
  MovingPairs(std::shared_ptr<const SceneModel> model, std::shared_ptr<const Volumes> volumes);

  const RobotModel& robot() const { return model_->robot; }

  void use(std::shared_ptr<const Objects> objects) { objects_ = std::move(objects); }
  /// nullptr before use().
  const std::shared_ptr<const Objects>& objects() const { return objects_; }

  /// `contact` is the question about a contact, and must outlive the pairs; nullptr if there is none. Some pairs may be
  /// left out that stay farther apart than `limit` [m] and than their contact distance.
  ///
  /// Throws std::invalid_argument for a motion with a different number of bodies or frames, and for a link, <collision>
  /// or object that does not exist.
  void begin(const Pairs& pairs, const RobotMotion& motion, const JointDeviations& deviations = {},
             const MotionQuestion* contact = nullptr, double limit = std::numeric_limits<double>::infinity());

  int size() const { return size_; }
  PairInMotion& operator[](int pair) { return pairs_[pair]; }
  PosesInTime& poses() { return poses_; }

  /// unknownOfList(): the number of pairs of the list without a pose or geometry. tooFar(): the number of candidates
  /// with objects that have no answer, although all poses are known, because the motion leads too far away.
  int unknownOfList() const { return unknown_; }
  int tooFar() const { return too_far_; }

  /// The number of candidates with objects that have an answer, without the pairs with fixed objects of the tree.
  int withObjects() const { return asked_ - of_list_; }

  /// [m] See PairInMotion::contact_distance.
  double contactDistanceOf(const ShapeRefPair& pair) const;

  /// The number of pairs of the question that one bound did not settle.
  int examined() const;

  /// [m] See MovingBodies::roundingAt(). The poses of the pair must be known.
  double roundingOf(const ShapeRefPair& pair, double time);

  /// The tree of the fixed objects, in the world.
  const BoxTree& tree() const { return objects_->fixed().tree(); }

  /// Returns the pair of the object of a leaf of the tree with the link or object a of the pair `with_all`. Returns -1
  /// if the object does not exist any more, or if the two are not checked.
  int pairAt(int with_all, const BoxTree::Node& leaf);

 private:
  /// A part whose body is a frame of PosesInTime.
  struct Participant : Part {
    ShapeRef ref;
  };

  Participant participant(const ShapeRef& ref);
  int frameOf(int number, const PlacedObject& object);
  bool isKnown(const Participant& who) const;
  bool add(const Participant& a, const Participant& b);
  bool stayApart(const Participant& a, const Participant& b, double limit);
  PairInMotion& next(const ShapeRefPair& asked, const Part& a, const Part& b);
  void addSolids(const Participant& a, const Participant& b);
  void addHalfSpaces(const Participant& a, const Participant& b);
  void addObjectPairs();
  void addPairsOf(const Participant& searcher);
  void addIfChecked(const Participant& searcher, int number);
  void addFixedObjects(const Participant& searcher);
  double deviationOf(const Participant& a, const Bounds& bounds_a, const Participant& b, const Bounds& bounds_b);
  void requireFrames(const RobotMotion& motion) const;

  const std::shared_ptr<const SceneModel> model_;
  const std::shared_ptr<const Volumes> volumes_;
  const PairDistances paddings_;
  std::shared_ptr<const Objects> objects_;

  PosesInTime poses_;
  JointDeviations deviations_;
  double slide_ = 0.0;  ///< [m] the deviations of all joints that do not turn, together
  const MotionQuestion* contact_ = nullptr;
  double limit_ = std::numeric_limits<double>::infinity();
  std::vector<PairInMotion> pairs_;  ///< those behind size_ are kept for the next motion
  int size_ = 0;
  std::vector<double> effects_;           ///< working memory of distanceDeviation()
  std::deque<HalfSpaceBox> half_spaces_;  ///< pairs refer to them
  std::map<int, int> fixed_frames_;       ///< the frame in PosesInTime of each fixed object, by the object's number
  std::map<std::pair<int, int>, int> at_leaf_;  ///< results of pairAt(), by pair and item
  bool has_frames_ = false;                     ///< true if the motion has the frames of moving objects
  int asked_ = 0, of_list_ = 0, unknown_ = 0, too_far_ = 0;
};

}  // namespace proximity_server::scene
