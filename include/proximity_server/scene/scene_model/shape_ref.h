#pragma once

namespace proximity_server::scene {

/// Names a link, one of its <collision> elements, an object, or a point of a question: anything whose distance can be
/// asked for.
class ShapeRef {
 public:
  enum class Kind : unsigned char { None, Link, Object, Point };

  /// Names nothing (Kind::None).
  ShapeRef() = default;

  /// A link, or its n-th <collision>, counted from 1; 0: the whole link. A link that was not found (-1) gives
  /// Kind::None.
  ShapeRef(int link, int collision = 0)  // NOLINT: implicit, as most pairs are of links
      : kind_(link < 0 ? Kind::None : Kind::Link), number_(link), collision_(collision) {}

  /// An object by its number, see Objects.
  static ShapeRef ofObject(int number) { return {Kind::Object, number}; }

  /// A point by its place in its question, see PointSearch. It belongs to no body.
  static ShapeRef ofPoint(int number) { return {Kind::Point, number}; }

  /// Its n-th <collision> or shape, counted from 1; for 0 the reference itself.
  ShapeRef part(int number) const {
    ShapeRef part = *this;
    if (number != 0) part.collision_ = number;
    return part;
  }

  Kind kind() const { return kind_; }
  bool isLink() const { return kind_ == Kind::Link; }  ///< also true for a <collision> of a link
  bool isObject() const { return kind_ == Kind::Object; }
  bool isPoint() const { return kind_ == Kind::Point; }

  /// The link of a link or <collision>; -1 for anything else.
  int link() const { return isLink() ? number_ : -1; }
  int collision() const { return collision_; }  ///< for an object: the shape, see part()
  /// The number of an object; -1 for anything else.
  int object() const { return isObject() ? number_ : -1; }
  /// The number of a point; -1 for anything else.
  int point() const { return isPoint() ? number_ : -1; }

  bool operator==(const ShapeRef& other) const {
    return kind_ == other.kind_ && number_ == other.number_ && collision_ == other.collision_;
  }
  bool operator!=(const ShapeRef& other) const { return !(*this == other); }

 private:
  ShapeRef(Kind kind, int number) : kind_(kind), number_(number) {}

  Kind kind_ = Kind::None;
  int number_ = -1;
  int collision_ = 0;
};

struct ShapeRefPair {
  ShapeRef a, b;

  bool areLinks() const { return a.isLink() && b.isLink(); }

  /// True if the two pairs are of the same shapes, in any order.
  bool isSameAs(const ShapeRefPair& other) const {
    return (a == other.a && b == other.b) || (a == other.b && b == other.a);
  }
};

}  // namespace proximity_server::scene
