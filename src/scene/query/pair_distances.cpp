#include "proximity_server/scene/query/pair_distances.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace proximity_server::scene {

void PairDistances::setPair(int link_a, int link_b, double distance) {
  set(own_pairs_, {std::min(link_a, link_b), std::max(link_a, link_b), distance});
}

void PairDistances::setWithObjects(int link, double distance) { set(own_with_objects_, {link, 0, distance}); }

void PairDistances::setObject(int number, double distance) { set(own_objects_, {number, 0, distance}); }

void PairDistances::set(std::vector<Own>& all, const Own& own) {
  const auto comes_before = [](const Own& p, const Own& q) {
    return std::make_pair(p.link_a, p.link_b) < std::make_pair(q.link_a, q.link_b);
  };
  const auto place = std::lower_bound(all.begin(), all.end(), own, comes_before);
  if (place != all.end() && !comes_before(own, *place))
    place->distance = own.distance;
  else
    all.insert(place, own);
}

const PairDistances::Own* PairDistances::find(const std::vector<Own>& all, int link_a, int link_b) {
  const auto place = std::lower_bound(
      all.begin(), all.end(), std::make_pair(link_a, link_b),
      [](const Own& own, const std::pair<int, int>& asked) { return std::make_pair(own.link_a, own.link_b) < asked; });
  return place != all.end() && place->link_a == link_a && place->link_b == link_b ? &*place : nullptr;
}

double PairDistances::ofLinks(int link_a, int link_b) const {
  const Own* own = find(own_pairs_, std::min(link_a, link_b), std::max(link_a, link_b));
  return own ? own->distance : links;
}

double PairDistances::withObject(const ShapeRefPair& pair) const {
  const Own *a = find(own_objects_, pair.a.object(), 0), *b = find(own_objects_, pair.b.object(), 0);
  if (a && b) return std::max(a->distance, b->distance);
  if (a || b) return a ? a->distance : b->distance;
  const Own* own = find(own_with_objects_, std::max(pair.a.link(), pair.b.link()), 0);  // two objects have none
  return own ? own->distance : objects;
}

double PairDistances::largestOfObjects() const {
  double largest = -std::numeric_limits<double>::infinity();
  for (const Own& own : own_objects_) largest = std::max(largest, own.distance);
  return largest;
}

PairDistances::Range PairDistances::range(PairKind kind) const {
  if (kind == PairKind::Any) {
    const Range p = range(PairKind::OfLinks), q = range(PairKind::WithObject);
    return {std::min(p.smallest, q.smallest), std::max(p.largest, q.largest)};
  }
  const bool with_object = kind == PairKind::WithObject;
  Range range{with_object ? objects : links, with_object ? objects : links};
  const auto include = [&](const std::vector<Own>& all) {
    for (const Own& own : all) range = {std::min(range.smallest, own.distance), std::max(range.largest, own.distance)};
  };
  include(with_object ? own_with_objects_ : own_pairs_);
  if (with_object) include(own_objects_);
  return range;
}

bool PairDistances::areFinite() const {
  const auto are_finite = [](const std::vector<Own>& all) {
    return std::all_of(all.begin(), all.end(), [](const Own& own) { return std::isfinite(own.distance); });
  };
  return std::isfinite(links) && std::isfinite(objects) && are_finite(own_pairs_) && are_finite(own_with_objects_) &&
         are_finite(own_objects_);
}

bool PairDistances::areEqual(PairKind kind) const {
  if (kind == PairKind::OfLinks) return own_pairs_.empty();
  if (kind == PairKind::WithObject) return haveEqualObjects();
  return own_pairs_.empty() && haveEqualObjects() && links == objects;
}

bool PairDistances::operator==(const PairDistances& other) const {
  return links == other.links && objects == other.objects && own_pairs_ == other.own_pairs_ &&
         own_with_objects_ == other.own_with_objects_ && own_objects_ == other.own_objects_;
}

PairDistances paddingsOf(const PairTable& table) {
  PairDistances paddings;
  for (const LinkPair& pair : table.pairs)
    if (pair.padding != 0.0) paddings.setPair(pair.link_a, pair.link_b, pair.padding);
  return paddings;
}

}  // namespace proximity_server::scene
