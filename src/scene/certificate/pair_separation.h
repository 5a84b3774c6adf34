#pragma once

#include "proximity_server/scene/certificate/certificate.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "scene/certificate/axis_heights.h"

#include <Eigen/Geometry>

#include <vector>

namespace proximity_server::scene {

/// The shape of a link or an object, in the frame of the body that carries it.
struct CarriedShape {
  struct CarriedPiece {
    const Piece* piece;
    Eigen::Isometry3d body_T_piece;
    double reach;  ///< [m] see AxisHeights::highest()
  };
  struct CarriedHalfSpace {
    Eigen::Vector3d normal;  ///< unit, outwards
    double offset;           ///< [m] of the plane from the origin, along the normal
    double reach;            ///< [m] the length of the transforms that place it
  };
  int body = 0;
  std::vector<CarriedPiece> pieces;
  std::vector<CarriedHalfSpace> half_spaces;
};

/// How far the pieces of two shapes are separated along axes, in all states of a box that has an interval for each of
/// leaders(). An axis is fixed to one of bodies().
class PairSeparation {
 public:
  /// The model and the objects must outlive it.
  /// Failure: throws std::invalid_argument for what does not exist, for parts of a link or object, for two half-spaces,
  ///          for shapes of two robots, and for a joint between the two that has more than one position.
  PairSeparation(const SceneModel& model, const Objects* objects, const ShapeRefPair& pair);

  /// The joints that move the two relative to each other, without mimic joints, ascending.
  const std::vector<int>& leaders() const { return leaders_; }

  /// The bodies from the body of a to the body of b.
  const std::vector<int>& bodies() const { return bodies_; }

  const CarriedShape& a() const { return a_; }
  const CarriedShape& b() const { return b_; }

  /// [m] What is subtracted from the distance of the two.
  double padding() const { return padding_; }

  /// [m] By piece of a (row) and of b (column): along one of the axes each point of the second is at least this far
  /// behind each one of the first.
  Eigen::MatrixXd along(const std::vector<SeparatingAxis>& axes, const std::vector<JointRange>& box) const;

  /// [m] The same of two pieces and one axis.
  double along(const SeparatingAxis& axis, const std::vector<JointRange>& box, int piece_a, int piece_b) const;

  /// [m] The least distance of a piece from a half-space of the other shape, along its normal; infinity if there are no
  /// half-spaces.
  double fromHalfSpaces(const std::vector<JointRange>& box) const;

  /// [m] The two are at least this far apart: the least of along() and fromHalfSpaces().
  double least(const std::vector<SeparatingAxis>& axes, const std::vector<JointRange>& box) const;

  /// True if a piece may lie inside of a mesh of the other shape without meeting its pieces.
  bool hasInterior() const;

  /// True if, in the state in the middle of the box, nothing lies inside of a mesh of the other shape. Points nearer to
  /// its surface than 1e-9 m count as inside.
  bool isOutside(std::vector<JointRange> box) const;

 private:
  Eigen::VectorXd highest(const CarriedShape& side, int body, const Eigen::Vector3d& direction,
                          const std::vector<JointRange>& box, int only = -1) const;
  bool isOutside(const CarriedShape& inner, const CarriedShape& outer, const std::vector<JointRange>& state) const;

  const RobotModel& robot_;
  CarriedShape a_, b_;
  std::vector<int> leaders_, bodies_;
  double padding_ = 0.0;
};

}  // namespace proximity_server::scene
