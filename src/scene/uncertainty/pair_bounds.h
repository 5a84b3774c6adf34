#pragma once

#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/state/state.h"
#include "proximity_server/scene/uncertainty/reached_state.h"
#include "proximity_server/scene/uncertainty/uncertainty.h"
#include "scene/query/closest_pieces.h"
#include "scene/state/placed_robot.h"
#include "scene/state/volumes.h"
#include "scene/uncertainty/displacements.h"
#include "scene/uncertainty/limited_work.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// Bounds the distance of one pair after the other over an uncertainty; see GuaranteedDistances.
class PairBounds {
 public:
  explicit PairBounds(const std::shared_ptr<const SceneModel>& model);

  void assume(const Uncertainty& uncertainty);
  void divideInto(int most_parts) { most_parts_ = most_parts; }
  const Uncertainty& uncertainty() const { return uncertainty_; }
  void limit(const GuaranteeLimits& limits) {
    work_.begin(limits);
    bounded_.clear();
  }
  LimitedWork& work() { return work_; }

  double of(const State& state, const PairProximity& pair, double enough);
  const ReachedState* reached(const State& state, const PairProximity& pair, double threshold);
  double largestLoss(const State& state);
  double largestLoss(const State& state, const std::vector<double>& travel);
  void forget() {
    likely_ = {};
    bounded_.clear();
  }

 private:
  /// The two largest of some numbers that are not negative.
  struct TwoLargest {
    double largest = 0.0, second = 0.0;

    void offer(double value) {
      second = std::max(second, std::min(value, largest));
      largest = std::max(largest, value);
    }
    double sum() const { return largest + second; }
  };

  struct Side {
    Part part;
    Eigen::Isometry3d pose;           ///< of the frame of the part
    std::vector<Displacement> chain;  ///< from the shape to the common body
  };

  /// The displacements of a body relative to its parent.
  struct Place {
    bool is_found = false;  ///< for the present poses and uncertainty
    bool is_known = false;  ///< false if a pose is missing that is needed
    std::vector<Displacement> displacements;
  };

  /// Upper bounds of the ways of a shape's points, found as far as they have been needed.
  struct Ways {
    bool is_begun = false;  ///< for the present poses and uncertainty
    Eigen::Vector3d centre;
    double radius, rounding;  ///< [m] of the ball around the shape, and of the distance of its centre from an axis
    int body;                 ///< what displaces it relative to its parent comes next
    std::vector<double> relative_to;  ///< [m] its body, the parent of its body, and so on; NaN: a pose is missing

    void add(const std::vector<Displacement>& displacements, double& sum) const;
  };

  /// The pair of pieces whose bound is the smallest, and where it is attained.
  struct Deciding {
    LeafPair leaves;
    Eigen::Vector3d normal, point_a, point_b;  ///< in the frame of the poses
  };

  /// The closest pieces of the pair in the state about which it is bounded. The normal may be missing.
  struct Known {
    Eigen::Vector3d normal;  ///< in the frame of the poses
    double lower_bound;      ///< [m] of the whole pair now, or of two of its pieces in the middle of a part
    double without_pieces;   ///< [m] a bound of the whole pair; where pieces give a lower one, it is the better one
    double little;           ///< [m] is not worth the steps of turn()
    // Only if there is a normal:
    Eigen::Vector3d in_a = Eigen::Vector3d::Zero(), in_b = Eigen::Vector3d::Zero();  ///< in the frames of the parts
    double between = 0.0;  ///< [m] from the origin of a to that of b, along the normal, less padding and rounding
    double loss = 0.0;     ///< [m] no pieces come closer by more than this along the normal; not known of single pieces

    bool hasNormal() const { return normal.allFinite(); }
  };

  /// The gap of two pieces along a direction, now and over all displacements [m].
  struct Along {
    double present, bound;
    double loss;  ///< [m] to first order, of the points that are the closest now
    int frame;
    Deciding where;
  };

  void see(const State& state);
  double largestLossWith(const std::vector<double>& travel);
  void placeObjects();
  void forgetState();
  bool begin(const ShapeRefPair& pair);
  Eigen::Vector3d originAt(int number, const Eigen::Isometry3d& pose) const;
  bool place(const ShapeRef& ref, int number, Side& side);
  bool addPlace(int body, std::vector<Displacement>& chain) const;
  const Place& placeOf(int body);
  void begin(const ShapeRef& ref, Ways& ways);
  double wayOf(const ShapeRef& ref, std::size_t steps);
  bool isUnbounded(const ShapeRef& ref) const {
    return ref.isObject() && state_->objects()->placed(ref.object())->isUnbounded();
  }
  double quickLossOf(const PairProximity& pair);
  double boundOf(const PairProximity& pair, double enough);
  Eigen::Vector3d jointOrigin(int body) const;
  double swellingOf(const ShapeRef& ref) const { return ref.isLink() ? uncertainty_.swellings[ref.link()] : 0.0; }
  /// [m] What brings the surfaces closer, though no point moves.
  double surfaces() const { return padding_ + swelling_; }
  static double lossOf(double way, double lower_bound);
  bool hasInterior() const { return a_.part.whole().has_interior || b_.part.whole().has_interior; }

  Along along(const LeafPair& leaves, const Eigen::Vector3d& normal, int frame);
  void countAlong(const Displacements& of, const narrowphase::Shape& shape);
  void improve(Along& best, double enough, double little);
  void turn(Along& best, double enough, double little);
  static RelativePose relative(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
    RelativePose a_T_b;
    a_T_b.rotation.noalias() = a.linear().transpose() * b.linear();
    a_T_b.translation.noalias() = a.linear().transpose() * (b.translation() - a.translation());
    return a_T_b;
  }
  void placeSides();
  void place(int frame);
  void findGaps(Known& known);
  static double gapAlong(const Volume& a, const Volume& b, const Known& known);
  double gapAlong(const LeafPair& leaves, const Known& known) const;
  double ofAllPieces(const Known& known, double enough);
  double ofInteriors(const Known& known);
  double ofVolumes(const PartPair& volumes, const Known& known, double enough) const;
  void boundVolumes(const PartPair& volumes, double own, const Known& known, double& lowest);
  void boundPieces(const LeafPair& leaves, const Known& known, double& lowest);
  void boundHalfSpace(int volume, int half_space, double& lowest);
  narrowphase::SignedDistance measured(const LeafPair& leaves, const RelativePose& a_T_b, double stop_above);

  /// A part of the uncertainty of a pair: an interval for each of leaders_between_.
  struct Box {
    std::size_t intervals;  ///< the place of the first one
    double bound;           ///< [m] of the pair
    LeafPair leaves;        ///< those that decide it
  };
  double divided(double whole, const Known& known, double enough);
  bool findLeadersBetween();
  std::size_t widestOf(const Box& box) const;
  std::pair<Box, Box> halve(const Box& box);
  void boundPart(Box& box, double enough, double& nearest);
  double placeInMiddle(const Box& box);
  double displaceSide(const Side& whole, const Box& box, Side& side) const;
  const Joint::Mimic* leaderOf(const Displacement& own) const;

  void displace(const Displacement& own, const Eigen::Vector3d& point, const Eigen::Vector3d& towards);
  void moveLeaders(const std::vector<double>& positions);
  double bringTogether(Deciding& where);
  Eigen::Isometry3d motionOf(const Side& side) const;
  double upperBoundDisplaced(Deciding& where);
  bool isReachedBelow(double threshold, const LeafPair& leaves);
  void placeDisplaced();
  void findRadii();
  void reachCarriedObjects();
  struct TravelWays {
    double of_all = 0.0, of_slides = 0.0;  ///< [m]
  };
  TravelWays waysOf(const std::vector<double>& travel) const;
  double reachOfBodies(const Eigen::Vector3d& from, double way) const;
  double reachOfFreeObjects(const Eigen::Vector3d& from, int checked_against) const;
  double lossOfHalfSpaces(const std::vector<double>& travel) const;

  const std::shared_ptr<const SceneModel> model_;
  const State* state_ = nullptr;            ///< that of the question
  std::uint64_t revision_ = 0;              ///< its revision in the last question; 0: the objects are not placed
  std::shared_ptr<const Objects> objects_;  ///< in the last question
  const PairDistances paddings_;
  Uncertainty uncertainty_;
  std::vector<Joint::Mimic> leaders_;  ///< by joint

  /// The place of an object by its number: its uncertainty, and its origin in the frame of what carries it.
  struct ObjectFrame {
    PoseUncertainty uncertainty;
    Eigen::Vector3d origin;
  };
  std::vector<ObjectFrame> object_frames_;
  double objects_lose_ = 0.0;  ///< [m] two objects by their own uncertainties, without those that have half-spaces
  double swellings_ = 0.0;     ///< [m] the two largest

  /// A bound of this state, which was improved up to `enough`.
  struct Bounded {
    ShapeRefPair pair;
    double enough, bound;
  };
  std::vector<Bounded> bounded_;
  std::vector<Place> places_;  ///< by body
  std::vector<Ways> ways_;     ///< by the numbers of Volumes
  Side seen_;                  ///< working memory of begin()
  std::optional<double> largest_loss_;

  // The pair that is looked at. The second shape is the first side if the first one has half-spaces.
  Side a_, b_;
  bool is_exchanged_ = false;
  RelativePose a_T_b_;
  double padding_ = 0.0, swelling_ = 0.0, loss_ = 0.0;

  /// The displacements of the two as they are seen from one of three frames. Where a face meets a corner, the frame of
  /// the face is the best one: the corner moves, and the face does not turn.
  static constexpr int kCommon = 0, kOfA = 1, kOfB = 2, kFrames = 3;
  struct Chains {
    explicit Chains(int groups) : of_a(groups), of_b(groups) {}
    Displacements of_a, of_b;
    bool is_placed = false;
  };
  std::vector<Chains> chains_;
  int frame_ = kCommon;  ///< that of the first bound of all pieces
  int visits_ = 0;       ///< of pairs of volumes
  LimitedWork work_;
  Deciding deciding_;
  ShapeRefPair asked_;  ///< the pair that is looked at
  /// The pieces that decided the last pair. They are looked at first if the pair is asked for again.
  struct {
    ShapeRefPair pair;
    LeafPair leaves;
  } likely_;

  // The parts of the uncertainty of the pair, see divided().
  static constexpr std::size_t kNoColumn = static_cast<std::size_t>(-1);
  static constexpr double kNegligible = 1e-6;  ///< [m] a loss that is not worth a part; links are known to 1e-4 at best
  int most_parts_ = 64;
  Side whole_a_, whole_b_;              ///< the two in the present state
  std::vector<int> leaders_between_;    ///< the joints whose positions displace the two relative to each other
  std::vector<double> levers_;          ///< [m/rad] or [m/m] of each of them, an upper bound of the ways of all points
  std::vector<std::size_t> column_of_;  ///< by joint, its place among them
  std::vector<std::array<double, 2>> intervals_;
  std::vector<Box> boxes_;             ///< a heap: the lowest bound first
  std::vector<double> nearest_state_;  ///< by joint, of leaders; empty: the middle of no part is nearer than the corner

  /// The displacements of one place in a state.
  struct Moved {
    double position = 0.0;
    Eigen::Vector3d shift = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero(), origin = Eigen::Vector3d::Zero();
    Eigen::Isometry3d displacement = Eigen::Isometry3d::Identity();
  };
  std::vector<Moved> moved_;        ///< by body; then the objects of the two sides, if they are objects
  std::vector<double> closing_;     ///< by leader, the change of the gap to first order, and then its position
  std::vector<double> held_reach_;  ///< [m] of the geometry of each body and of what its links hold, from its origin
  std::vector<double> reach_;       ///< [m] the same, also of the objects in the frames of its links in these poses
  std::vector<double> radius_;      ///< working memory of largestLoss()
  /// The same: the losses [m] along two branches of what each body carries, those of the roots first.
  std::vector<TwoLargest> branches_;
  ReachedState reached_;
};

}  // namespace proximity_server::scene
