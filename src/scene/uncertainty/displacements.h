#pragma once

#include "scene/bounds/bounds.h"
#include "scene/bounds/seen_bounds.h"

#include <Eigen/Geometry>

#include <vector>

namespace proximity_server::scene {

/// One of the displacements of all that a joint, a base or an object carries, on the way from a common frame to a shape.
/// Axis and origin are in the frame of the poses.
struct Displacement {
  enum class Kind : unsigned char {
    Turn,   ///< about `axis` through `origin`
    Slide,  ///< along `axis`
    Tilt,   ///< about any axis through `origin`
    Shift   ///< in any direction
  };
  Kind kind;
  int place;     ///< what is displaced; the bounds do not use it
  double width;  ///< [rad] or [m] how far at most, with the multiplier; it may be infinite
  Eigen::Vector3d origin;
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< a unit vector
  /// Slides of the same group [0, groups) are the same number times their multipliers; a turn is alone in its group.
  int group = -1;
  double multiplier = 1.0;

  bool turns() const { return kind == Kind::Turn || kind == Kind::Tilt; }

  /// The velocity [m] at which a turn or a slide moves a point, for one unit of the position, without the multiplier.
  Eigen::Vector3d velocityAt(const Eigen::Vector3d& point) const {
    return kind == Kind::Slide ? axis : Eigen::Vector3d(axis.cross(point - origin));
  }

  /// Turns or slides, by a position [rad] or [m], what `motion` moves after it.
  void displaceAfter(Eigen::Isometry3d& motion, double position) const;
};

/// A bound of where the points of a shape can be, over a box of displacements: lower bounds of their coordinates along
/// a direction that is fixed in the common frame. Two shapes are farther apart than the sum of the bounds of one shape
/// along a direction, and of the other one against it, whether they overlap or not.
///
/// 1. Let E_1 ... E_k be the rigid motions of the displacements, that next to the common frame first, about their
///    present axes. They move a point x to E_1 ... E_k x, whatever the positions of the joints are now (Brockett,
///    Robotic Manipulators and the Product of Exponentials Formula, 1984).
/// 2. So x moves by at most sum w_j u_j, where w_j is its present distance from the axis, or 1 for a translation, and
///    u_j the width of the displacement. That holds for motions of any size: see FreeMotion.
/// 3. To first order x moves along a unit vector n by sum d_j n.v_j(x), where v_j is its velocity for one unit of the
///    displacement. That is at least -sum u_j |n.v_j(x)|, for a shift -u_j, for a tilt -u_j |n x (x - o_j)|. The
///    displacements of one group are added before the absolute value is taken.
/// 4. All of these are convex in x, because they are absolute values and norms of affine functions. So the lower bound
///    of n.x is concave, and on a convex shape it is smallest at one of its vertices. A ball about each point, the
///    margin, reaches equally far in all directions and in all states.
/// 5. The remainder is at most half the largest second derivative of E_1(s) ... E_k(s) x along s, where s scales all
///    displacements. Its terms are u_i u_j n.(a_i x v_j) for each pair i <= j, twice for i < j, where a_i is the axis of
///    i and v_j the velocity of x for j, both in the displaced state. If i does not turn, they are 0. The axis a_i is
///    turned by all displacements within it, so |n x a_i| is larger by at most the sum of their angles. No |v_j| is
///    larger than the present one, plus the way of x by all displacements beyond j, as in 2.
/// 6. If that is much, n.(a_i x v_j) is bounded in the present state, over the box of the geometry and for i = j with
///    its sign; then a_i and v_j change in the displaced state by terms of third order. The change by the turn t itself
///    is in point 3: it moves x by n.v_i sin t, which is no more than t |n.v_i|. So a turn has a group of its own: in a
///    sum with others, n.v_i t could cancel what n.v_i sin t does not.
/// 7. The displacements of an inverse chain are the same ones in the opposite order, with opposite signs.
class Displacements {
 public:
  explicit Displacements(int groups)
      : speed_(static_cast<std::size_t>(groups)), sum_of_group_(static_cast<std::size_t>(groups), -1) {}

  /// Takes the geometry that is displaced, and the pose of its body.
  void begin(const Bounds& bounds, const Eigen::Isometry3d& body);

  /// The displacement that is next to the geometry comes first.
  void add(const Displacement& displacement);

  int count() const { return static_cast<int>(list_.size()); }

  /// [m] An upper bound of the way of any point of the geometry.
  double travel() const { return travel_ * (1.0 + roundingOfSums()); }

  /// [m] An upper bound of what lowest() does not see: the terms of second order, and rounding. `n` is a unit vector.
  double remainder(const Eigen::Vector3d& n) const;

  struct Lowest {
    double present;         ///< [m] the lowest coordinate of the piece now
    double displaced;       ///< [m] a lower bound over all displacements, up to the remainder
    double loss;            ///< [m] the loss, to first order, of the point that is the lowest now
    Eigen::Vector3d point;  ///< of the core, where it was found: relative to the origin of the coordinates
  };
  /// The lowest coordinate of a piece along the unit vector n. It is one of the pieces of the geometry, and the
  /// coordinates are relative to `from`.
  Lowest lowest(const Piece& piece, const Eigen::Vector3d& n, const Eigen::Vector3d& from);

  /// To first order, how a point of the geometry moves where it comes down along the unit vector n as far as it can.
  Eigen::Vector3d lowestStep(const Eigen::Vector3d& point, const Eigen::Vector3d& n);

  /// [m] A lower bound, up to the remainder, of the coordinate of a point of the geometry over all displacements. The
  /// point is in the frame of the body, and the coordinate is relative to `from`.
  double displacedHeight(const Eigen::Vector3d& point, const Eigen::Vector3d& n, const Eigen::Vector3d& from);

  /// [m] To first order, no point of the geometry comes down along the unit vector n by more than this.
  double largestLoss(const Eigen::Vector3d& n);

 private:
  struct Placed : Displacement {
    explicit Placed(const Displacement& displacement) : Displacement(displacement), centre(Eigen::Vector3d::Zero()) {}
    double radius = 1.0;     ///< the largest |v_j| now
    double beyond = 0.0;     ///< [m] the way of a point by the displacements beyond this one
    double turned = 0.0;     ///< [rad] the angles of the displacements beyond this one, and its own
    double rounding = 0.0;   ///< [m] of a coordinate relative to the origin
    Eigen::Vector3d centre;  ///< of the box of the geometry, relative to the origin

    /// The largest |v_j| in all states.
    double speed() const { return turns() ? radius + beyond : radius; }
  };

  /// The first-order change of n.x by one group or tilt, in the frame of a piece.
  struct Change {
    double width;
    bool is_tilt;
    double constant;         ///< n.v at the origin of the piece, if it is no tilt
    Eigen::Vector3d vector;  ///< the gradient of n.v; for a tilt its origin
  };
  double simpleRemainder(const Eigen::Vector3d& n) const;
  double directedRemainder(const Eigen::Vector3d& n) const;
  double secondOrder(const Eigen::Vector3d& across, const Placed& outer, const Placed& own) const;
  void findChanges(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& from_body, const Eigen::Vector3d& n);
  double lossAt(const Eigen::Vector3d& point, const Eigen::Vector3d& n, double within) const;
  double steepness() const;
  double roundingOfSums() const {
    return static_cast<double>(list_.size() + 8) * std::numeric_limits<double>::epsilon();
  }

  Eigen::Isometry3d body_ = Eigen::Isometry3d::Identity();
  const Bounds* bounds_ = nullptr;
  std::vector<Placed> list_;
  Eigen::Matrix3d edges_ = Eigen::Matrix3d::Zero();      ///< from the centre of the box to the middles of its faces
  double travel_ = 0.0, rounding_ = 0.0, angles_ = 0.0;  ///< sums over the list
  double shift_ = 0.0;
  std::vector<Change> changes_;
  std::vector<double> speed_;      ///< working memory of lowestStep()
  std::vector<int> sum_of_group_;  ///< the place of a group in changes_; -1 outside of findChanges()
};

}  // namespace proximity_server::scene
