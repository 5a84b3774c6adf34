#include "tools/pair_audit/box_growth.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::tools {

void extend(scene::JointBox& box, std::size_t at, End end, const scene::JointRange& limits,
            const std::function<bool(const scene::JointBox&)>& isProven) {
  double scene::JointRange::*const place = end == End::Lower ? &scene::JointRange::lower : &scene::JointRange::upper;
  const auto isProvenAt = [&](double position) {
    scene::JointBox larger = box;
    larger[at].*place = position;
    if (!isProven(larger)) return false;
    box = std::move(larger);
    return true;
  };
  double open = limits.*place;
  if (open == box[at].*place || isProvenAt(open)) return;
  while (std::abs(open - box[at].*place) > limits.width() / 64.0) {
    const double middle = limits.typeable(0.5 * (open + box[at].*place));
    if (!isProvenAt(middle)) open = middle;
  }
}

bool contains(const scene::JointBox& box, const scene::JointBox& part) {
  return std::all_of(part.begin(), part.end(), [&](const scene::JointRange& inner) {
    const scene::JointRange* outer = scene::intervalOf(box, inner.joint);
    return outer && outer->lower <= inner.lower && inner.upper <= outer->upper;
  });
}

double shareOf(const scene::JointBox& part, const scene::JointBox& whole) {
  double share = 1.0;
  for (const scene::JointRange& inner : part)
    if (const scene::JointRange* outer = scene::intervalOf(whole, inner.joint); outer && outer->width() > 0.0)
      share *= inner.width() / outer->width();
  return share;
}

}  // namespace proximity_server::tools
