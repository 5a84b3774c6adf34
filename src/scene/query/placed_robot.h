#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/objects/objects.h"
#include "scene/objects/placed_object.h"
#include "scene/query/pair_memory.h"
#include "scene/query/relative_pose.h"
#include "scene/query/volumes.h"

namespace proximity_server::scene {

using WarmStarts = PairMemory<narrowphase::WarmStart>;  ///< of pairs of pieces

/// Bounds how far two bodies moved relative to each other between two poses.
struct RelativeMotionBound {
  double distance_change;  ///< [m] upper bound of the change of the signed distance, with rounding; 0 for equal poses
  bool is_rest;            ///< no point of b has moved in the frame of a by more than the rounding of the poses
};

/// What a link, a <collision> or an object consists of: the volumes and pieces among which its own are.
struct Compound {
  const Volume* volumes;
  const Piece* pieces;
  int root;         ///< its number among the volumes, of which it and its parts are meant
  int first_piece;  ///< the number of the first of the pieces in WarmStarts

  const Volume& operator[](int volume) const { return volumes[volume]; }
};

/// A leaf of a compound.
struct Leaf {
  Leaf(const Compound& compound, int leaf)
      : volume(compound[leaf]), piece(compound.pieces[volume.piece]), number(compound.first_piece + volume.piece) {}

  const Volume& volume;
  const Piece& piece;
  int number;  ///< of the piece in WarmStarts
};

/// A robot with its objects in one set of poses: bounds and distances of its volumes.
///
/// Numbers: a volume of the robot has its number in Volumes; an object as a whole has firstObject() plus its number in
///          Objects. A volume within an object is named by the object's Compound only.
/// Frame:   results are in the frame of the body of volume a. Only the difference of two bodies' origins enters a
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
  /// that of the first body with geometry whose pose is known, then the spheres of the needed roots. What is not placed
  /// anew stands where it stood.
  void place(int body, const Eigen::Isometry3d& pose) { placeBody(pose, bodies_[body]); }
  bool hasGeometry(int body) const { return bodies_[body].is_used; }
  bool isKnown(int body) const { return bodies_[body].known; }
  void takeOriginOf(int body) { origin_ = bodies_[body].origin; }
  void placeSphere(int root);

  /// Throws std::invalid_argument if the objects have another number of frames.
  void requireFrames(std::size_t count) const;

  /// Takes one pose for each of Objects::frames(), in the frame of the body poses; nullopt if it is not known.
  /// Throws as requireFrames() does.
  void updateFrames(const std::vector<std::optional<Eigen::Isometry3d>>& poses);

  /// From now on none of them is known.
  void forgetFrames();

  const Volumes& volumes() const { return *volumes_; }

  int firstObject() const { return first_object_; }
  bool isObject(int volume) const { return volume >= first_object_; }

  /// Whether a volume that Volumes::of returned has geometry, and its pose is known. Throws std::invalid_argument for an
  /// object that does not exist.
  bool isPlaced(int root) const { return isObject(root) ? isObjectPlaced(root) : sphereOf(root).is_placed; }

  bool isLinkPlaced(int root) const { return sphereOf(root).is_placed; }

  /// Whether an object with half-spaces has this number. Its bounds are infinite, and it has to be the second of a pair.
  bool isUnbounded(int root) const { return isObject(root) && placedAt(root).isUnbounded(); }
  const std::vector<PlacedHalfSpace>& halfSpacesOf(int object) const { return placedAt(object).geometry->halfSpaces(); }

  const Volume& at(int volume) const {
    return isObject(volume) ? places_[static_cast<std::size_t>(volume - first_object_)].root : (*volumes_)[volume];
  }
  Compound compoundOf(int volume) const {
    return isObject(volume) ? compoundOfObject(volume) : Compound{volumes_->data(), model_.pieces.data(), volume, 0};
  }

  /// The <collision> of the link, or the shape of the object, that a leaf, or a half-space as LeafPair numbers it,
  /// belongs to; counted from 1.
  int collisionNumber(int root, int leaf) const {
    return isObject(root) ? shapeNumber(root, leaf) : collisionOf(model_, (*volumes_)[leaf].piece).number;
  }

  /// Of such a leaf, or Exact of a half-space.
  Representation representationOf(int root, int leaf) const {
    if (!isObject(root)) return (*volumes_)[leaf].representation;
    return leaf < 0 ? Representation::Exact : compoundOfObject(root)[leaf].representation;
  }

  /// The pose of volume b's body in the frame of volume a's body.
  RelativePose relative(int a, int b) const { return relative(at(a), at(b)); }
  RelativePose relative(const Volume& a, const Volume& b) const;

  /// Lower bounds [m] of the signed distance of two volumes; the first is for those of the robot that Volumes::of
  /// returns, the second is the same where one of them is an object.
  double sphereGap(int a, int b) const;
  double objectGap(int a, int b) const;
  double sphereGap(int a, int b, const RelativePose& a_T_b) const { return sphereGap(at(a), at(b), a_T_b); }
  double boxGap(int a, int b, const RelativePose& a_T_b) const { return boxGap(at(a), at(b), a_T_b); }
  static double sphereGap(const Volume& a, const Volume& b, const RelativePose& a_T_b);
  static double boxGap(const Volume& a, const Volume& b, const RelativePose& a_T_b);

  /// The box of the sphere of a root, see Volumes::rootCount, in the frame of the poses moved to one of the bodies.
  Eigen::AlignedBox3d boxAround(int root) const;

  /// The box along the axes of the frame of the poses that holds a placed link, or a placed object without half-spaces.
  Eigen::AlignedBox3d worldBox(int root) const;

  /// Whether boxGap costs less than the query that it may save.
  bool boxesPay(int a, int b) const { return boxesPay(at(a), at(b)); }
  static bool boxesPay(const Volume& a, const Volume& b) { return !a.has_closed_form || !b.has_closed_form; }

  /// If b has half-spaces it is bounded by the motion of a alone.
  RelativeMotionBound relativeMotion(int a, int b, const RelativePose& before, const RelativePose& now) const {
    return relativeMotion(at(a), at(b), before, now);
  }
  static RelativeMotionBound relativeMotion(const Volume& a, const Volume& b, const RelativePose& before,
                                            const RelativePose& now);

  /// The certified distance of two leaves; the bounds allow for the rounding of the poses, also where they decide
  /// a threshold.
  narrowphase::SignedDistance distance(int a, int b, const RelativePose& a_T_b, const narrowphase::Options& options,
                                       WarmStarts& warm_starts) const {
    return distance(Leaf(compoundOf(a), a), Leaf(compoundOf(b), b), a_T_b, options, warm_starts);
  }
  static narrowphase::SignedDistance distance(const Leaf& a, const Leaf& b, const RelativePose& a_T_b,
                                              const narrowphase::Options& options, WarmStarts& warm_starts) {
    return distance(a, b, a_T_b, options, warm_starts.of(a.number, b.number));
  }
  static narrowphase::SignedDistance distance(const Leaf& a, const Leaf& b, const RelativePose& a_T_b,
                                              const narrowphase::Options& options, narrowphase::WarmStart& warm_start);

  /// [m] Upper bound of the effect of the rounding of poses on a distance.
  static double rounding(const Volume& a, const Volume& b, const RelativePose& a_T_b);

  /// A result in the frame of volume a, as seen in the frame of the poses.
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

  /// What is kept of an object while it is there.
  struct ObjectPlace {
    const PlacedObject* object = nullptr;
    Volume root;          ///< with its body; of infinite radius if the object has half-spaces
    int first_piece = 0;  ///< see Compound
    int frame = -1;       ///< of a moving object, index into Objects::frames()
  };

  const BodyPlace& bodyOf(int volume) const { return bodies_[at(volume).body]; }
  const Sphere& sphereOf(int root) const { return spheres_[root]; }
  const PlacedObject& placedAt(int root) const {
    return *places_[static_cast<std::size_t>(root - first_object_)].object;
  }
  bool isObjectPlaced(int root) const;
  Compound compoundOfObject(int root) const;
  int shapeNumber(int root, int leaf) const;
  static void placeBody(const std::optional<Eigen::Isometry3d>& pose, BodyPlace& body);
  void placeSpheres();
  Sphere sphereAround(int root) const;
  void occupy(int number, const PlacedObject& object);

  const RobotModel& model_;
  const std::shared_ptr<const Volumes> volumes_;
  const int first_object_;
  std::vector<BodyPlace> bodies_;                     ///< of the robot, then one for each number of an object
  std::vector<Sphere> spheres_;                       ///< by root, see Volumes::rootCount
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();  ///< from which the spheres are seen
  std::shared_ptr<const Objects> objects_;
  std::vector<ObjectPlace> places_;  ///< by number of the object
  int next_piece_;
};

}  // namespace proximity_server::scene
