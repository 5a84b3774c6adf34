#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "proximity_server/scene/filter/scene_model.h"
#include "scene/lanes/lane_kernels.h"
#include "scene/lanes/link_outline.h"
#include "scene/parts/volumes.h"

namespace proximity_server::scene {

/// How far what the lanes compute of a frame in float is from the truth, in any state in the ranges of LaneModel::columns.
///
/// Let u be 2^-24. A matrix counts by its Frobenius norm. With A + sine B + cosine C as the rotation of a body on its parent:
/// its constants, products and sums have an error of at most 4 u (|A| + |B| + |C|), and sine and cosine add
/// lanes::kSineError (|B| + |C|). Where a frame with the error e stands on one with the error E, the product of the two
/// rotations has E (1 + e) + e, and 3 u |R| |M| from its dot products of three terms; the origin, at the distance m from that
/// of the parent, adds E m, the error of m, 3 u |R| m, and u of the sum.
///
/// Source: Higham, Accuracy and Stability of Numerical Algorithms, 2002, sections 3.1 and 3.5 (dot and matrix products).
struct LaneError {
  double rotation = 0.0;
  double origin = 0.0;  ///< [m]
  double reach = 0.0;   ///< [m] upper bound of the distance of the origin from that of the root
};

/// What the lanes know of a robot: constants in float, and bounds of their errors. Never changes; twins share it.
class LaneModel {
 public:
  LaneModel(const SceneModel& model, const Volumes& volumes);
  LaneModel(const LaneModel&) = delete;
  LaneModel& operator=(const LaneModel&) = delete;

  /// A position that is read: of a joint that moves itself, or of the leader of one that follows.
  struct Column {
    int joint;                  ///< index into RobotModel::joints, and column of the states
    double multiplier, offset;  ///< of the one that follows
    double limit;               ///< [rad] or [m] Beyond this the errors do not hold.
  };
  std::vector<Column> turns, slides;  ///< rows of lanes::BodyPlan
  std::vector<int> unread;            ///< the other joints
  std::vector<lanes::BodyPlan> bodies;
  std::vector<lanes::LinkPlan> links;  ///< of the candidates
  std::vector<LaneError> link_errors;
  std::vector<LaneError> body_errors;

  struct Pair {
    int a = -1, b = -1;   ///< indices into `links`; -1: no geometry
    double padding;       ///< [m]
    double centre_error;  ///< [m] of the distance of the origins of the links
    double radius_a, radius_b;
    lanes::PairShapes shapes;
    int few_a, few_b;  ///< corners that are searched first
    float uncovered_by_few;

    bool hasGeometry() const { return a >= 0; }
  };
  std::vector<Pair> pairs;  ///< by number of the candidate

 private:
  struct Link {
    LinkOutline outline;
    double extent;  ///< [m] of the link from the origin of its frame
    std::array<std::vector<float>, 4> corners, inner;
    int number;
  };

  void findUnread(int joints);
  void addBodies(const RobotModel& robot);
  int rowOf(const RobotModel& robot, int joint, std::vector<Column>& columns);
  void addLink(const RobotModel& robot, int link, const Bounds& bounds);
  Pair pairOf(const Link& a, const Link& b, double padding) const;

  std::vector<std::unique_ptr<Link>> outlines_;  ///< by index into RobotModel::links; nullptr: not needed
};

}  // namespace proximity_server::scene
