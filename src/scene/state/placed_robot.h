#pragma once

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/objects/objects.h"
#include "scene/objects/placed_object.h"
#include "scene/state/pair_memory.h"
#include "scene/state/volumes.h"

#include <Eigen/Geometry>

#include <memory>
#include <optional>
#include <vector>

namespace proximity_server::scene {

using WarmStarts = PairMemory<narrowphase::WarmStart>;  ///< for pairs of pieces

/// An upper bound of how far two bodies have moved relative to each other between two poses.
struct RelativeMotionBound {
  double distance_change;  ///< [m] upper bound of the change of the signed distance, with rounding; 0 for equal poses
  bool is_rest;            ///< no point of b has moved in the frame of a by more than the rounding of the poses
};

/// A leaf of a part.
struct Leaf {
  Leaf(const Part& part, int leaf)
      : volume(part[leaf]), piece(part.pieces[volume.piece]), number(part.first_piece + volume.piece) {}

  const Volume& volume;
  const Piece& piece;
  int number;  ///< the number of the piece in WarmStarts
};

/// A robot with its objects in one set of poses, and the bounds and distances of its volumes.
///
/// Parts:   links, <collision> elements and objects by their numbers, see Volumes::of().
/// Frame:   results are in the frame of the body of part a. Only the difference of two bodies' origins matters to a
///          distance, so that a robot far from the origin of the poses' frame gives the same answers. The body of an
///          attached object is the body of its link; every other object is a body of its own.
class PlacedRobot {
 public:
  PlacedRobot(const RobotModel& model, std::shared_ptr<const Volumes> volumes);

  /// Takes the next objects of the robot. A fixed object stands in its place at once, and an attached object has the
  /// pose of its body; a moving object has none until the next update.
  void use(std::shared_ptr<const Objects> objects);

  /// nullptr before the first use().
  const std::shared_ptr<const Objects>& objects() const { return objects_; }

  /// Takes the poses of all bodies and of Objects::frames(), each as usablePose() returns it.
  void update(const BodyPoses& poses, const FramePoses& frames);

  /// The steps of update(), for a caller who needs only a few bodies, with any poses. First place() all bodies that are
  /// needed; then takeOriginOf() the first body with geometry whose pose is known; then placeSphere() for each part
  /// that is needed. Parts that are not placed anew stay where they were.
  void place(int body, const Eigen::Isometry3d& pose);
  void placeFrames(const FramePoses& frames);
  bool hasGeometry(int body) const { return bodies_[body].has_geometry; }
  bool isKnown(int body) const { return bodies_[body].known; }
  void takeOriginOf(int body) { origin_ = bodies_[body].origin; }
  void placeSphere(int part);

  const std::shared_ptr<const Volumes>& volumes() const { return volumes_; }

  bool isObject(int part) const { return part >= volumes_->rootCount(); }
  int numberOf(const ShapeRef& ref) const { return volumes_->of(ref); }
  int numberOfObject(int object) const { return volumes_->rootCount() + object; }
  ShapeRef refOf(int part) const;

  /// True if a part has geometry, and its pose is known. Throws std::invalid_argument for an object that does not
  /// exist.
  bool isPlaced(int part) const {
    return isObject(part) ? bodies_[existing(part).body].known : spheres_[part].is_placed;
  }

  const Part& operator[](int part) const { return parts_[part]; }

  /// The pose of the body of a placed part in the frame of the poses.
  RelativePose poseOf(int part) const { return {bodyOf(part).rotation, bodyOf(part).origin}; }

  /// The pose of part b's body in the frame of part a's body.
  RelativePose relative(int a, int b) const;

  /// True if the first of two has half-spaces, which only the second may have. Throws std::invalid_argument if both have.
  bool isUnboundedFirst(int a, int b) const;

  /// [m] A lower bound of the signed distance of two parts. Only the second one may have half-spaces.
  double sphereGap(int a, int b) const {
    return isObject(a) || isObject(b) ? gapWithObject(a, b) : gapOf(spheres_[a], spheres_[b]);
  }

  /// True if two links or <collision> elements are placed, and sphereGap() of them is above `limit` [m]. Takes no root.
  /// It may be false for a gap that is above the limit by no more than its rounding.
  bool areFar(int a, int b, double limit) const {
    const Sphere &of_a = spheres_[a], &of_b = spheres_[b];
    if (!of_a.is_placed || !of_b.is_placed) return false;
    const double reach = (1.0 + kPoseRounding) * (limit + (of_a.radius + of_b.radius));
    return reach < 0.0 || (of_b.centre - of_a.centre).squaredNorm() > reach * reach;
  }

  /// The box of the sphere of a placed link or <collision>, in the frame of the poses moved to the origin of one of the
  /// bodies.
  Eigen::AlignedBox3d boxAround(int part) const;

  /// The box along the axes of the frame of the poses that contains a placed link, or a placed object without
  /// half-spaces.
  Eigen::AlignedBox3d worldBox(int part) const;

  /// True if boxGap() costs less than the query that it may save.
  static bool boxesPay(const Volume& a, const Volume& b) { return !a.has_closed_form || !b.has_closed_form; }

  /// If b has half-spaces, the bound follows from the motion of a alone.
  static RelativeMotionBound relativeMotion(const Part& a, const Part& b, const RelativePose& before,
                                            const RelativePose& now);

  /// The certified distance of two leaves, in the frame of the body of a. The bounds allow for the rounding of the
  /// poses, even if they decide a threshold.
  static narrowphase::SignedDistance distanceInBodyA(const Leaf& a, const Leaf& b, const RelativePose& a_T_b,
                                                     const narrowphase::Options& options,
                                                     narrowphase::WarmStart& warm_start);

  /// [m] An upper bound of the effect of the rounding of poses on a distance.
  static double rounding(const Volume& a, const Volume& b, const RelativePose& a_T_b);

  /// Transforms a result from the frame of the body of part a into the frame of the poses.
  narrowphase::SignedDistance inPosesFrame(int a, const narrowphase::SignedDistance& in_body_a) const;

 private:
  struct BodyPlace {
    bool has_geometry = false;  ///< true if geometry is fixed to it, or has been
    bool known = false;
    Eigen::Matrix3d rotation;
    Eigen::Vector3d origin;
  };

  /// A sphere in the frame of the poses, moved to the origin of one of the bodies, so that its numbers are small. It
  /// includes its own rounding.
  struct Sphere {
    bool is_placed = false;
    double radius;
    Eigen::Vector3d centre;
  };

  static double gapOf(const Sphere& a, const Sphere& b) { return (b.centre - a.centre).norm() - (a.radius + b.radius); }
  double gapWithObject(int a, int b) const;
  const BodyPlace& bodyOf(int part) const { return bodies_[(*this)[part].body]; }
  const Part& existing(int object) const;
  Sphere sphereOf(int part) const { return isObject(part) ? sphereAround(part) : spheres_[part]; }
  Sphere sphereAround(int part) const;
  void putAround(int part, Sphere& sphere) const;
  double halfSpaceGap(const Sphere& sphere, int object) const;
  static void placeBody(const std::optional<Eigen::Isometry3d>& usable, BodyPlace& body);
  void placeSpheres();
  void occupy(int number, const PlacedObject& object);
  BodyPlace& ownBodyOf(int number) { return bodies_[model_.bodies.size() + static_cast<std::size_t>(number)]; }

  const RobotModel& model_;
  const std::shared_ptr<const Volumes> volumes_;
  std::vector<Part> parts_;        ///< a part whose object was removed has no object
  std::vector<BodyPlace> bodies_;  ///< the bodies of the robot, then one for each number of an object
  std::vector<Sphere> spheres_;    ///< of the parts of the robot
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();  ///< the origin of the frame of the spheres
  std::shared_ptr<const Objects> objects_;
  int next_piece_;
};

}  // namespace proximity_server::scene
