#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/scene/model/kinematics.h"
#include "scene/query/pair_memory.h"
#include "scene/query/volumes.h"

namespace proximity_server::scene {

using WarmStarts = PairMemory<narrowphase::WarmStart>;  ///< of pairs of pieces

/// Where the body of one volume stands in the frame of the body of another.
struct RelativePose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

/// Bounds how far two bodies moved relative to each other between two poses.
struct RelativeMotionBound {
  double distance_change;  ///< [m] upper bound of the change of the signed distance, with rounding; 0 for equal poses
  bool is_rest;            ///< the motion is no larger than the rounding of the poses
};

/// A robot in one set of poses: bounds and distances of its volumes.
///
/// Frame: results are in the frame of the body of volume a. Only the difference of two bodies' origins enters a
///        distance, so that a robot far from the origin of the poses' frame gives the same answers.
class PlacedRobot {
 public:
  PlacedRobot(const RobotModel& model, std::shared_ptr<const Volumes> volumes);

  /// A pose that is not finite, or whose matrix is no rotation within single precision, counts as missing. Throws
  /// std::invalid_argument if there is not one pose for each body.
  void update(const BodyPoses& poses);

  const Volumes& volumes() const { return *volumes_; }

  /// Whether a volume that Volumes::of returned has geometry, and its pose is known.
  bool isPlaced(int root) const { return sphereOf(root).is_placed; }

  /// The pose of volume b's body in the frame of volume a's body.
  RelativePose relative(int a, int b) const;

  /// Lower bounds [m] of the signed distance of two volumes; the first is for those that Volumes::of returns.
  double sphereGap(int a, int b) const;
  double sphereGap(int a, int b, const RelativePose& a_T_b) const;
  double boxGap(int a, int b, const RelativePose& a_T_b) const;

  /// The box of the sphere of a root, see Volumes::rootCount, in the frame of the poses moved to one of the bodies.
  Eigen::AlignedBox3d boxAround(int root) const;

  /// Whether boxGap costs less than the query that it may save.
  bool boxesPay(int a, int b) const { return !at(a).has_closed_form || !at(b).has_closed_form; }

  RelativeMotionBound relativeMotion(int a, int b, const RelativePose& before, const RelativePose& now) const;

  /// The certified distance of two leaves; the bounds allow for the rounding of the poses, also where they decide
  /// a threshold.
  narrowphase::SignedDistance distance(int a, int b, const RelativePose& a_T_b, const narrowphase::Options& options,
                                       WarmStarts& warm_starts) const;

  /// A result in the frame of volume a, as seen in the frame of the poses.
  narrowphase::SignedDistance inPosesFrame(int a, narrowphase::SignedDistance result) const;

 private:
  struct BodyPlace {
    bool known = false;
    Eigen::Matrix3d rotation;
    Eigen::Vector3d origin;
  };

  /// In the frame of the poses, moved to one of the bodies, so that its numbers are small. Holds its own rounding.
  struct Sphere {
    bool is_placed = false;
    double radius;
    Eigen::Vector3d centre;
  };

  const Volume& at(int volume) const { return (*volumes_)[volume]; }
  const BodyPlace& bodyOf(int volume) const { return bodies_[at(volume).body]; }
  void placeSpheres();
  double rounding(int a, int b, const RelativePose& a_T_b) const;

  const Sphere& sphereOf(int root) const { return spheres_[root]; }

  const RobotModel& model_;
  const std::shared_ptr<const Volumes> volumes_;
  std::vector<BodyPlace> bodies_;
  std::vector<Sphere> spheres_;  ///< by root, see Volumes::rootCount
};

}  // namespace proximity_server::scene
