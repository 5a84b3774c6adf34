#pragma once

#include "peers/scene_library.h"
#include "proximity_server/scene/model/kinematics.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace proximity_server::peers {

using namespace narrowphase;
using namespace scene;

/// FCL 0.7 as its best users use it: a dynamic AABB tree over the parts of the links, a distance callback that leaves
/// out what the filter leaves out, and in each query of two parts the best distance so far as the bound. Fixed objects
/// are in a second tree, which is built once; the search for the minimum then begins with the bound of the pair of
/// parts that was nearest the last time.
///
/// The first contact is FCL's collision query with the same filter. It begins with the two parts that overlapped the
/// last time.
///
/// The parts are the very pieces of the robot. Spheres, capsules, cylinders, cones and ellipsoids are FCL's primitives.
/// A pair whose query throws or aborts counts as far, and failures() as one more.
/// Failure: throws std::invalid_argument naming the link of a piece that FCL cannot describe (a padding).
/// Source:  how Drake bounds a search (its distance callback sets the reach of the broadphase) and MoveIt a query (it
///          begins with the bound in the result).
class FclScene : public SceneLibrary {
 public:
  enum class Method {
    Triangles,    ///< boxes and hulls of a link are one tree of triangles (OBBRSS); else libccd
    HullsLibccd,  ///< boxes and solid hulls are convex shapes, for the solver that FCL uses by default
    HullsIndep    ///< the same for FCL's own solver, which begins with the last simplex of the same two parts
  };
  /// `objects` are fixed; nullptr: none. HullsIndep takes none.
  FclScene(const SceneModel& model, Method method, const Objects* objects = nullptr);

  void ask(const BodyPoses& poses, SceneQuestion question) override;
  void giveAnswer(SceneAnswer& answer) const override;
  int failures() const override { return failures_; }

  /// A candidate pair with its nearest points in the frame of the poses.
  struct PairWithPoints {
    int candidate;
    double distance;  ///< [m]; in overlap zero or negative, and the points mean nothing
    Eigen::Vector3d point_a, point_b;
  };
  /// Takes the poses, and returns the `most` closest pairs of links within a distance [m], sorted; valid until the next
  /// call. Their boxes leave out those farther apart. Not for HullsIndep.
  const std::vector<PairWithPoints>& closest(const BodyPoses& poses, std::size_t most, double within);

  /// Returns how many candidate pairs have parts whose boxes, along the axes of the world, are no farther apart than
  /// `distance` [m] in the poses of the last question.
  int pairsWithBoxesWithin(double distance) const;

 private:
  struct Part {
    int link;  ///< for an object: the number of links plus the object's own
    int body;  ///< for an object: -1
    Eigen::Isometry3d body_T_part;
    std::unique_ptr<fcl::CollisionObjectd> object;
  };

  void addLink(const RobotModel& robot, int link);
  void addObjects(const Objects& objects);
  void addPieces(const std::vector<const Piece*>& pieces, int link, int body, const Eigen::Isometry3d& frame_T_pieces);
  void addPart(int link, int body, const Eigen::Isometry3d& body_T_part,
               const std::shared_ptr<fcl::CollisionGeometryd>& geometry);
  bool goesAsTriangles(const Shape& shape) const;
  void update(const BodyPoses& poses);

  static bool visit(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* self, double& reach);
  static bool visitTouching(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* self);
  void askFirstContact();
  void offerToContact(std::size_t a, std::size_t b);
  void offer(std::size_t a, std::size_t b);
  void offerToClosest(int candidate, std::size_t a, std::size_t b);
  double reach() const;
  bool isDone() const;
  std::size_t most() const { return question_ == SceneQuestion::Minimum ? 1 : kClosest; }
  void askEach();

  std::size_t indexOf(const fcl::CollisionObjectd& object) const;
  int candidateOf(int link_a, int link_b) const;
  template <typename Visit>
  void forParts(std::size_t candidate, const Visit& visit) const;
  double measure(std::size_t a, std::size_t b, double bound);
  double solve(std::size_t a, std::size_t b, double bound);
  void offerPoints(std::size_t a, std::size_t b, PairWithPoints& best);

  Method method_;
  std::size_t links_;
  std::vector<Part> parts_;
  std::vector<std::vector<std::size_t>> parts_of_link_;
  std::vector<std::pair<int, int>> candidates_;  // links
  std::vector<int> candidate_of_;                // by both links; -1: not checked
  std::vector<Eigen::Vector3d> guesses_;         // by both parts
  std::size_t objects_ = 0;                      // all their numbers are smaller than this
  std::vector<bool> is_checked_;                 // by link and object
  fcl::DynamicAABBTreeCollisionManagerd manager_, environment_;
  SceneQuestion question_ = SceneQuestion::All;
  std::optional<std::pair<std::size_t, std::size_t>> nearest_parts_;  // of the last minimum or contact
  std::vector<double> within_;                                        // [m] by candidate, of Below
  std::vector<PairDistance> answer_;                                  // sorted while Minimum and Closest search
  bool is_any_below_ = false;
  std::vector<PairWithPoints> closest_;
  int failures_ = 0;
};

}  // namespace proximity_server::peers
