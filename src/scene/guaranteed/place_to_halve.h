#pragma once

#include "proximity_server/scene/model/joint_ranges.h"
#include "scene/model/numbers.h"

#include <cstddef>

namespace proximity_server::scene {

/// The place of the interval that can be halved for which `measure` returns the most; -1 if no interval can be halved.
template <class Measure>
int placeToHalve(const JointRange* box, std::size_t count, const Measure& measure) {
  int place = -1;
  double most = -kInfinity;
  for (std::size_t i = 0; i < count; ++i) {
    const double middle = 0.5 * (box[i].lower + box[i].upper);
    if (!(box[i].lower < middle && middle < box[i].upper)) continue;
    const double own = measure(box[i]);
    if (place >= 0 && !(own > most)) continue;
    most = own;
    place = static_cast<int>(i);
  }
  return place;
}

}  // namespace proximity_server::scene
