#include "scene/points/point_part.h"

#include <algorithm>

namespace proximity_server::scene {

using Eigen::Vector3d;

PointPart::PointPart()
    : pieces_{{narrowphase::Shape(narrowphase::Sphere{1.0}).padded(-1.0), Eigen::Isometry3d::Identity(), 0}},
      volumes_(1) {
  volumes_.front() = VolumeBuilder(pieces_, {Representation::Exact}).over({0}, volumes_);
  addWideVolumes(volumes_, 0, wide_volumes_);
  part_.volumes = volumes_.data();
  part_.pieces = pieces_.data();
  part_.wide_volumes = wide_volumes_.data();
}

double gapTo(const Bounds& bounds, const Vector3d& point) {
  const Vector3d from_centre = point - bounds.centre;
  const Vector3d beyond = (bounds.axes.transpose() * from_centre).cwiseAbs() - bounds.half;
  const double largest = beyond.maxCoeff();
  const double of_box = largest > 0.0 ? beyond.cwiseMax(0.0).norm() : largest;
  const double rounding = kPoseRounding * (point.norm() + bounds.reach);
  return std::max(of_box, from_centre.norm() - bounds.radius) - rounding;
}

double gapTo(const Eigen::AlignedBox3d& box, const Vector3d& point) {
  const Vector3d beyond = (box.min() - point).cwiseMax(point - box.max());
  const double largest = beyond.maxCoeff();
  return (largest > 0.0 ? beyond.cwiseMax(0.0).norm() : largest) - kPoseRounding * point.norm();
}

}  // namespace proximity_server::scene
