#pragma once

#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/query/pairs.h"
#include "proximity_server/scene/query/question.h"

#include <vector>

namespace proximity_server::scene {

/// A distance [m] for each pair: a threshold or a padding. Most robots have one distance for all pairs of a kind, and
/// then a look-up costs nothing.
class PairDistances {
 public:
  double links = 0.0;    ///< [m] for two links without a distance of their own
  double objects = 0.0;  ///< [m] for a pair with an object, if its link has no distance of its own

  PairDistances() = default;
  PairDistances(double of_links, double of_objects) : links(of_links), objects(of_objects) {}

  /// Gives two links a distance of their own. It replaces the distance of an earlier call.
  void setPair(int link_a, int link_b, double distance);

  /// Gives the pairs of a link with objects a distance of their own.
  void setWithObjects(int link, double distance);

  /// Gives all pairs with an object, by its number, a distance of their own. It counts before the distance of a link.
  /// If two objects have distances of their own, the larger one counts.
  void setObject(int number, double distance);

  /// Takes back all distances of setObject(). Keeps the memory for as many.
  void forgetObjects() { own_objects_.clear(); }

  /// The distance of a pair, in either order. A pair of <collision> elements has the distance of their links.
  double of(const ShapeRefPair& pair) const {
    if (!pair.areLinks()) return haveEqualObjects() ? objects : withObject(pair);
    return own_pairs_.empty() ? links : ofLinks(pair.a.link(), pair.b.link());
  }

  /// The largest distance of setObject(); -infinity if there is none.
  double largestOfObjects() const;

  struct Range {
    double smallest, largest;  ///< [m]
  };
  Range range(PairKind kind) const;  ///< over all pairs of a kind; the distances must not be NaN

  bool areFinite() const;

  /// True if all pairs of a kind have the same distance.
  bool areEqual(PairKind kind) const;

  bool operator==(const PairDistances& other) const;

 private:
  struct Own {
    int link_a, link_b;  ///< link_a < link_b; for pairs with objects link_b is 0, and link_a may be the number of an
                         ///< object
    double distance;
    bool operator==(const Own& other) const {
      return link_a == other.link_a && link_b == other.link_b && distance == other.distance;
    }
  };

  static const Own* find(const std::vector<Own>& all, int link_a, int link_b);
  static void set(std::vector<Own>& all, const Own& own);
  double ofLinks(int link_a, int link_b) const;
  double withObject(const ShapeRefPair& pair) const;
  bool haveEqualObjects() const { return own_with_objects_.empty() && own_objects_.empty(); }

  std::vector<Own> own_pairs_;         ///< sorted by links
  std::vector<Own> own_with_objects_;  ///< sorted by link
  std::vector<Own> own_objects_;       ///< sorted by the number of the object, which is link_a
};

/// The paddings of all pairs, see LinkPair::padding. They are subtracted from the distances.
PairDistances paddingsOf(const PairTable& table);

}  // namespace proximity_server::scene
