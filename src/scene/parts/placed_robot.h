#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/objects/objects.h"
#include "scene/objects/placed_object.h"
#include "scene/parts/pair_memory.h"
#include "scene/parts/volumes.h"

namespace proximity_server::scene {

using WarmStarts = PairMemory<narrowphase::WarmStart>;  ///< of pairs of pieces

/// Bounds how far two bodies moved relative to each other between two poses.
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
  int number;  ///< of the piece in WarmStarts
};

/// A robot with its objects in one set of poses: bounds and distances of its volumes.
///
/// Parts:   links, <collision> elements and objects by their numbers, see Volumes::of().
/// Frame:   results are in the frame of the body of part a. Only the difference of two bodies' origins enters a
///          distance, so that a robot far from the origin of the poses' frame gives the same answers. The body of an
///          attached object is that of its link; every other object is a body of its own.
class PlacedRobot {
 public:
  PlacedRobot(const RobotModel& model, std::shared_ptr<const Volumes> volumes);

  /// Takes the next objects of the robot. Fixed ones stand in their places at once. An attached one has the last pose of
  /// its body; if that has no geometry of its own, and for a moving object, the pose is missing until the next update.
  /// Returns the numbers of objects whose geometry is not that of before, if they had any.
  std::vector<int> use(std::shared_ptr<const Objects> objects);

  /// nullptr before the first use().
  const Objects* objects() const { return objects_.get(); }

  /// A pose that is not finite, or whose matrix is no rotation within single precision, counts as missing. Throws
  /// std::invalid_argument if there is not one pose for each body.
  void update(const BodyPoses& poses);

  /// The steps of update(), for a caller who needs few of the bodies: first all that are needed, then the origin, which is
  /// that of the first body with geometry whose pose is known, then the spheres of the needed parts. What is not placed
  /// anew stands where it stood.
  void place(int body, const Eigen::Isometry3d& pose) { placeBody(pose, bodies_[body]); }
  bool hasGeometry(int body) const { return bodies_[body].is_used; }
  bool isKnown(int body) const { return bodies_[body].known; }
  void takeOriginOf(int body) { origin_ = bodies_[body].origin; }
  void placeSphere(int part);

  /// Throws std::invalid_argument if the objects have another number of frames.
  void requireFrames(std::size_t count) const;

  /// Takes one pose for each of Objects::frames(), in the frame of the body poses; nullopt if it is not known.
  /// Throws as requireFrames() does.
  void updateFrames(const std::vector<std::optional<Eigen::Isometry3d>>& poses);

  /// From now on none of them is known.
  void forgetFrames();

  const Volumes& volumes() const { return *volumes_; }

  bool isObject(int part) const { return part >= volumes_->rootCount(); }
  int numberOf(const ShapeRef& ref) const { return volumes_->of(ref); }
  int numberOfObject(int object) const { return volumes_->rootCount() + object; }
  ShapeRef refOf(int part) const;

  /// Whether a part has geometry, and its pose is known. Throws std::invalid_argument for an object that does not exist.
  bool isPlaced(int part) const {
    return isObject(part) ? bodies_[existing(part).body].known : spheres_[part].is_placed;
  }

  const Part& operator[](int part) const { return parts_[static_cast<std::size_t>(part)]; }

  /// The <collision> of the link, or the shape of the object, that a leaf or a half-space belongs to; counted from 1.
  int collisionNumber(int part, int leaf) const;
  int shapeNumber(int object, int half_space) const { return 1 + (*this)[object].halfSpaces()[half_space].shape; }

  /// The pose of part b's body in the frame of part a's body.
  RelativePose relative(int a, int b) const;

  /// Lower bounds [m] of the signed distance of two parts, of which only the second may have half-spaces.
  double sphereGap(int a, int b) const;

  /// The box of the sphere of a placed link or <collision>, in the frame of the poses moved to one of the bodies.
  Eigen::AlignedBox3d boxAround(int part) const;

  /// The box along the axes of the frame of the poses that holds a placed link, or a placed object without half-spaces.
  Eigen::AlignedBox3d worldBox(int part) const;

  /// Whether boxGap costs less than the query that it may save.
  static bool boxesPay(const Volume& a, const Volume& b) { return !a.has_closed_form || !b.has_closed_form; }

  /// If b has half-spaces it is bounded by the motion of a alone.
  static RelativeMotionBound relativeMotion(const Part& a, const Part& b, const RelativePose& before,
                                            const RelativePose& now);

  /// The certified distance of two leaves; the bounds allow for the rounding of the poses, also where they decide
  /// a threshold.
  static narrowphase::SignedDistance distance(const Leaf& a, const Leaf& b, const RelativePose& a_T_b,
                                              const narrowphase::Options& options, narrowphase::WarmStart& warm_start);

  /// [m] Upper bound of the effect of the rounding of poses on a distance.
  static double rounding(const Volume& a, const Volume& b, const RelativePose& a_T_b);

  /// A result in the frame of the body of part a, as seen in the frame of the poses.
  narrowphase::SignedDistance inPosesFrame(int a, narrowphase::SignedDistance result) const;

 private:
  struct BodyPlace {
    bool is_used = false;  ///< something with geometry is fixed to it
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

  const BodyPlace& bodyOf(int part) const { return bodies_[(*this)[part].body]; }
  const Part& existing(int object) const;
  Sphere sphereOf(int part) const { return isObject(part) ? sphereAround(part) : spheres_[part]; }
  Sphere sphereAround(int part) const;
  double halfSpaceGap(const Sphere& sphere, int object) const;
  static void placeBody(const std::optional<Eigen::Isometry3d>& pose, BodyPlace& body);
  void placeSpheres();
  void occupy(int number, const PlacedObject& object);

  const RobotModel& model_;
  const std::shared_ptr<const Volumes> volumes_;
  std::vector<Part> parts_;                           ///< without an object where one has gone
  std::vector<BodyPlace> bodies_;                     ///< of the robot, then one for each number of an object
  std::vector<Sphere> spheres_;                       ///< of the parts of the robot
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();  ///< from which the spheres are seen
  std::shared_ptr<const Objects> objects_;
  int next_piece_;
};

}  // namespace proximity_server::scene
