#pragma once

#include "peers/scene_library.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <Eigen/Geometry>

#include <vector>

namespace proximity_server::peers {

/// Spheres that cover each link: planners ask them instead of the geometry, in one state after the other. Plain scalar
/// code.
///
/// 1. Sample the surfaces of the link's pieces.
/// 2. Divide the samples into clusters (k-means), and take a small enclosing sphere of each. The next sphere goes to
///    the link that has the largest one, until there are kSpheresPerLink of them a link in the mean.
/// 3. Place the bodies by a product of matrices for each joint, in which all that is constant is precomputed.
/// 4. Compare one sphere around each link of a pair first, then all spheres. The search for anything below a distance
///    ends at the first two spheres that are; the search for the closest begins with the pair whose outer spheres are
///    closest.
///
/// Error:   no bounds: between spheres and surface is what the fit leaves, and between samples a surface may stick out.
/// Source:  how MoveIt, cuRobo and VAMP describe robots; the robots are spherized here by clusters of surface samples.
/// Failure: throws std::invalid_argument for floating and planar joints.
class SphereScene {
 public:
  static constexpr int kSpheresPerLink = 6;

  explicit SphereScene(const SceneModel& model);

  /// Positions as forwardKinematics() takes them.
  void place(const double* positions, std::ptrdiff_t stride);

  // Questions about the candidate pairs in the last place. The lists are sorted, and valid until the next question.
  bool anyBelow(double within);
  PairDistance minimum();
  const std::vector<PairDistance>& closest(std::size_t most);
  const std::vector<PairDistance>& below(double within);

  int sphereCount() const { return static_cast<int>(spheres_.size()); }

  struct Sphere {
    Eigen::Vector3d centre;
    double radius;
  };
  /// Returns the spheres of a link in the frame of its body; none for a link that is in no candidate pair.
  std::vector<Sphere> spheresOf(int link) const;

 private:
  /// The pose of a body in its parent at joint position q: the rotation is constant + cos(q) * even + sin(q) * odd, and
  /// the translation is origin + q * slide.
  struct Step {
    int parent;  ///< -1: a root
    int joint;   ///< the leader
    double multiplier, offset;
    Eigen::Matrix3d constant, even, odd;
    Eigen::Vector3d origin, slide;
    bool turns;
  };
  struct LinkSpheres {
    int body = -1;
    Sphere around;  ///< holds all
    std::size_t begin = 0, end = 0;
    Eigen::Vector3d centre;  ///< of `around`, placed
    bool is_placed = false;  ///< whether its spheres are
  };

  void addSteps(const RobotModel& robot);
  void addLinks(const RobotModel& robot);
  void placeSpheres(LinkSpheres& link);
  double gapAround(int pair) const;
  double distanceOf(int pair, double enough);
  void offer(std::size_t pair, std::size_t most);

  std::vector<Step> steps_;
  std::vector<std::pair<int, int>> candidates_;
  std::vector<LinkSpheres> links_;
  std::vector<Sphere> spheres_;
  std::vector<Eigen::Vector3d> centres_;  // placed
  std::vector<Eigen::Matrix3d> rotations_;
  std::vector<Eigen::Vector3d> origins_;
  std::vector<double> gaps_;  // [m] of the spheres around, by pair
  std::vector<PairDistance> list_;
};

}  // namespace proximity_server::peers
