#pragma once

#include "scene/state/part.h"

#include <Eigen/Geometry>

#include <vector>

namespace proximity_server::scene {

/// A point as a part: the origin of its own frame.
class PointPart {
 public:
  PointPart();
  PointPart(const PointPart&) = delete;
  PointPart& operator=(const PointPart&) = delete;

  const Part& part() const { return part_; }
  const narrowphase::Shape& shape() const { return pieces_.front().shape; }

  /// The pair of it at a place and a part with this pose, both in one frame. The distances of the pair are distances of
  /// the point; `radius` [m] is added to the threshold of the question, which is about a ball.
  PlacedPair pairAt(const Eigen::Vector3d& place, const Part& part, const RelativePose& pose, double radius) const {
    return {part_, part, {pose.rotation, pose.translation - place}, 0.0, radius};
  }

 private:
  std::vector<Piece> pieces_;
  std::vector<Volume> volumes_;
  std::vector<WideVolume> wide_volumes_;
  Part part_;
};

/// [m] A lower bound of the signed distance of a point from the content of a volume, in the frame of its body.
double gapTo(const Bounds& bounds, const Eigen::Vector3d& point);

/// [m] The same for a box in the frame of the poses.
double gapTo(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& point);

}  // namespace proximity_server::scene
