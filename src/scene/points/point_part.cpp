#include "scene/points/point_part.h"

namespace proximity_server::scene {

PointPart::PointPart()
    : pieces_{{narrowphase::Shape(narrowphase::Sphere{1.0}).padded(-1.0), Eigen::Isometry3d::Identity(), 0}},
      volumes_(1) {
  volumes_.front() = VolumeBuilder(pieces_, {Representation::Exact}).over({0}, volumes_);
  addWideVolumes(volumes_, 0, wide_volumes_);
  part_.volumes = volumes_.data();
  part_.pieces = pieces_.data();
  part_.wide_volumes = wide_volumes_.data();
}

}  // namespace proximity_server::scene
