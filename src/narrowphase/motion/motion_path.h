#pragma once

#include "narrowphase/motion/screw_path.h"
#include "proximity_server/narrowphase/motion/motion.h"

#include <array>

namespace proximity_server::narrowphase {

/// AboutZ: the body looks the same after any turn about the z axis of its frame.
enum class Symmetry : unsigned char { None, AboutZ };

/// A chain of screws with their precomputed data. An empty chain is a frame at rest.
class MotionPath {
 public:
  /// Allocates only for more than 8 screws.
  explicit MotionPath(const MotionChain& chain, const Eigen::Vector3d& from = Eigen::Vector3d::Zero());
  MotionPath(const MotionPath&) = delete;
  MotionPath& operator=(const MotionPath&) = delete;

  ScrewPath::Pose at(double time) const;

  /// See motionBound(). A symmetric body, whose centre is on its axis, occupies the same space as a body that follows
  /// the axis but does not spin about it. So the bound is about the points of the latter, if their acceleration is
  /// smaller.
  MotionBound bound(const Eigen::Vector3d& centre, double radius, double begin, double end,
                    Symmetry symmetry = Symmetry::None) const;

 private:
  std::array<ScrewPath, 8> few_;
  std::vector<ScrewPath> many_;
  ScrewPath* screws_;
  std::size_t size_;
};

}  // namespace proximity_server::narrowphase
