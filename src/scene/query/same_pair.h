#pragma once

#include "proximity_server/scene/query/question.h"

namespace proximity_server::scene {

inline bool isSame(const ShapeRef& p, const ShapeRef& q) {
  return p.link == q.link && p.collision == q.collision && (p.link >= 0 || p.object == q.object);
}

/// Whether two pairs are of the same shapes, in any order.
inline bool areSame(const ShapeRefPair& p, const ShapeRefPair& q) {
  return (isSame(p.a, q.a) && isSame(p.b, q.b)) || (isSame(p.a, q.b) && isSame(p.b, q.a));
}

}  // namespace proximity_server::scene
