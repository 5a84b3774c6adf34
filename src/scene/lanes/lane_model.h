#pragma once

#include "proximity_server/scene/scene_model/scene_model.h"
#include "scene/kernels/lane_kernels.h"
#include "scene/lanes/link_outline.h"
#include "scene/state/volumes.h"

#include <Eigen/Core>

#include <array>
#include <memory>
#include <vector>

namespace proximity_server::scene {

/// An upper bound of the error of a frame that the lanes compute in double, in any state within the limits of
/// LaneModel::Column. That of a link is rounded to float in the end, which adds 2^-24 of its rotation, and of the reach.
///
/// Let u be 2^-53, and measure matrices by their Frobenius norm. Let A + sine B + cosine C be the rotation of a body on
/// its parent. Its constants, products and sums have an error of at most 4 u (|A| + |B| + |C|), and sine and cosine add
/// lanes::kSineError (|B| + |C|). Let a frame with the error e stand on a parent R with the error E, with the rotation
/// M and the origin at the distance m from the parent's. The product of the two rotations has the error E (1 + e)
/// + e, and 3 u |R| |M| from its dot products of three terms. The origin has the error E m, plus the error of its own
/// position, 3 u |R| m, and u of the sum.
///
/// Source: Higham, Accuracy and Stability of Numerical Algorithms, 2002, sections 3.1 and 3.5 (dot and matrix
///         products).
struct LaneError {
  double rotation = 0.0;
  double origin = 0.0;  ///< [m]
  double reach = 0.0;   ///< [m] upper bound of the distance from the origin of the root
};

/// The constants of a robot in float, and bounds of their errors. It never changes; the batches of all threads share
/// it.
class LaneModel {
 public:
  LaneModel(const SceneModel& model, const Volumes& volumes);
  LaneModel(const LaneModel&) = delete;
  LaneModel& operator=(const LaneModel&) = delete;

  /// A column of the states that is read: the position of a joint, or of its leader if it is a mimic joint.
  struct Column {
    int joint;                  ///< index into RobotModel::joints, and column of the states
    double multiplier, offset;  ///< of the mimic joint
    double limit;               ///< [rad] or [m] Beyond this the errors do not hold
  };
  std::vector<Column> turns, slides;  ///< the rows that lanes::BodyPlan refers to
  std::vector<int> unread;            ///< the joints of all other columns
  std::vector<lanes::BodyPlan> bodies;
  std::vector<lanes::LinkPlan> links;  ///< the links of the candidates
  std::vector<LaneError> link_errors;
  std::vector<lanes::LinkBall> link_balls;
  std::vector<LaneError> body_errors;

  /// Balls in the frame of a link: their centres, and their radii.
  using BallRows = std::array<std::vector<float>, 4>;

  /// Boxes along the axes of the frame of a link: their centres, and halves of their edges.
  using BoxRows = std::array<std::vector<float>, 6>;

  /// One convex piece of a link.
  struct Piece {
    BallRows corners;
    double margin;  ///< [m]
    bool is_exact;  ///< see PieceOutline
  };

  /// The pieces of a link, and boxes around these, the interiors and the representatives, see LinkOutline.
  struct Pieces {
    std::vector<Piece> list;
    BoxRows boxes, interiors, representatives;
  };
  std::vector<Pieces> pieces;  ///< for each of `links`

  struct Pair {
    int a = -1, b = -1;  ///< indices into `links`; -1: no geometry
    double padding;      ///< [m]
    double depth;        ///< [m] The links overlap by at most this
    double reach;        ///< [m] If the origins of the links are farther apart in the lanes, the links do not touch
    lanes::PairShapes shapes;
    int coarse_corners_a, coarse_corners_b;  ///< the number of corners that are searched first
    float coarse_uncovered;
    float gap_error;  ///< [m] of the gap of two boxes

    bool hasGeometry() const { return a >= 0; }
  };
  std::vector<Pair> pairs;  ///< index: the number of the candidate

  /// True if boxes and GJK can bound the pieces of a pair: they are not too many.
  bool hasFewPieces(const Pair& pair) const;

  lanes::Cores coresOf(const Pair& pair, std::size_t piece_a, std::size_t piece_b) const;

 private:
  struct Link {
    LinkOutline outline;
    double extent;  ///< [m] how far the link extends from the origin of its frame
    BallRows corners, inner;
    int number;
  };

  void findUnread(int joints);
  void addBodies(const RobotModel& robot);
  void addRoot();
  void addCarried(const RobotModel& robot, const Body& body);
  int rowOf(const RobotModel& robot, int joint, std::vector<Column>& columns);
  void addLink(const RobotModel& robot, int link, const Bounds& bounds);
  Pair pairOf(const Link& a, const Link& b, double padding) const;

  std::vector<std::unique_ptr<Link>> outlines_;  ///< index into RobotModel::links; nullptr if not needed
};

}  // namespace proximity_server::scene
