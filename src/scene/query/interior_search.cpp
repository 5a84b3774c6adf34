#include "scene/query/interior_search.h"

#include "scene/pieces/interior.h"

#include <algorithm>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;
using narrowphase::SignedDistance;
using narrowphase::Status;

/// Tells which of the two parts has the interior.
enum class Outer : unsigned char { A, B };

RelativePose inverse(const RelativePose& a_T_b) {
  RelativePose b_T_a;
  b_T_a.rotation = a_T_b.rotation.transpose();
  b_T_a.translation = -(b_T_a.rotation * a_T_b.translation);
  return b_T_a;
}

/// [m] The signed distance of a point from a box, negative inside. It is a lower bound of the distance from the content
/// of the box.
double signedDistance(const Eigen::AlignedBox3d& box, const Vector3d& p) {
  const double depth = std::min((p - box.min()).minCoeff(), (box.max() - p).minCoeff());
  return depth >= 0.0 ? -depth : box.exteriorDistance(p);
}

class InteriorSearch {
 public:
  InteriorSearch(const PlacedPair& pair, double limit, const Question& question, Skipping skipping, double within,
                 ClosestPieces& closest, const ClosestPieces* pieces)
      : a_(pair.a),
        b_(pair.b),
        a_T_b_(pair.a_T_b),
        // Twice for the poses, because the chain of transforms into the frame of the mesh is longer than that between
        // two pieces. Twice again, because a point that is this near to the surface may be taken for one on the other
        // side of it.
        rounding_(4.0 * PlacedRobot::rounding(a_.whole(), b_.whole(), a_T_b_)),
        limit_(limit),
        padding_(pair.padding),
        question_(question),
        skipping_(skipping),
        within_(within),
        closest_(closest),
        pieces_(pieces) {}

  void run() {
    outer_T_inner_ = a_T_b_;
    outer_ = Outer::A;
    visitOuter(a_.root);
    outer_T_inner_ = inverse(a_T_b_);
    outer_ = Outer::B;
    visitOuter(b_.root);
  }

 private:
  const Part& outer() const { return outer_ == Outer::A ? a_ : b_; }
  const Part& inner() const { return outer_ == Outer::A ? b_ : a_; }

  void visitOuter(int volume) {
    const Volume& here = outer()[volume];
    if (!here.has_interior) return;
    if (!here.isLeaf()) {
      for (const int part : here.parts) visitOuter(part);
      return;
    }
    outer_leaf_ = volume;
    mesh_T_outer_ = solid().body_T_piece.inverse(Eigen::Isometry);
    visitInner(inner().root);
  }

  /// The piece whose interior is looked at.
  const Piece& solid() const { return outer().pieces[outer()[outer_leaf_].piece]; }

  /// A point of the body of the inner one in the frame of the mesh.
  Vector3d inMesh(const Vector3d& p) const {
    return mesh_T_outer_ * (outer_T_inner_.rotation * p + outer_T_inner_.translation);
  }

  /// True if something with this lower bound [m], without padding, cannot change the answer.
  bool isLeftOut(double lower_bound) {
    if (lower_bound >= within_) return true;
    if (skipping_ == Skipping::Off || !(lower_bound - padding_ > closest_.limit(limit_, question_))) return false;
    closest_.leaveOut(lower_bound - padding_);
    return true;
  }

  /// True if a ball about a point of the mesh is less deep than pieces or another ball are.
  bool isShallow(const Vector3d& centre, double radius) const {
    if (!pieces_) return false;
    // Rounding twice, so that the two differ by more than it.
    const double depth = -(std::min(pieces_->upper_bound, closest_.upper_bound) + padding_);
    return solid().interior->hasSurfaceWithin(centre, depth - radius - 2.0 * rounding_);
  }

  void visitInner(int volume) {
    const Volume& here = inner()[volume];
    if (!here.has_representative) return;
    const Eigen::AlignedBox3d& box = solid().interior->box();
    const Vector3d centre = inMesh(here.bounds.centre);
    if (isLeftOut(signedDistance(box, centre) - here.bounds.radius - solid().shape.margin() - rounding_)) return;
    if (here.isLeaf()) return measure(volume);
    for (const int part : here.parts) visitInner(part);
  }

  void measure(int inner_leaf) {
    const Piece& representative = inner().pieces[inner()[inner_leaf].piece];
    const Vector3d centre = inMesh(representative.body_T_piece * representative.shape.centre());
    const double radius =
        std::max(0.0, representative.shape.innerRadius()) + representative.shape.margin() + solid().shape.margin();
    if (isLeftOut(signedDistance(solid().interior->box(), centre) - radius - rounding_)) return;
    if (isShallow(centre, radius)) return;
    const Interior::Place place = solid().interior->placeOf(centre, radius + within_);
    SignedDistance result;
    result.lower_bound = place.lower_bound - radius - rounding_;
    result.upper_bound = place.upper_bound - radius + rounding_;
    result.distance = 0.5 * (result.lower_bound + result.upper_bound);
    if (!(result.distance < within_)) return;
    const bool is_narrow = result.upper_bound - result.lower_bound <= narrowphase::usableTolerance(question_.tolerance);
    result.status = is_narrow ? Status::Converged : Status::Degenerate;
    offer(place, inner_leaf, result);
  }

  /// Adds points and normal to a result, and offers it.
  void offer(const Interior::Place& place, int inner_leaf, SignedDistance result) {
    const Vector3d outwards = (solid().body_T_piece.linear() * place.outwards).normalized();
    const Vector3d on_solid = solid().body_T_piece * place.nearest + solid().shape.margin() * outwards;
    result.has_points = true;
    result.unique = false;
    LeafPair leaves{outer_leaf_, inner_leaf};
    if (outer_ == Outer::A) {
      result.normal = outwards;
      result.point_a = on_solid;
    } else {
      std::swap(leaves.a, leaves.b);
      result.normal = -(a_T_b_.rotation * outwards).normalized();
      result.point_a = a_T_b_.rotation * on_solid + a_T_b_.translation - result.distance * result.normal;
    }
    result.point_b = result.point_a + result.distance * result.normal;
    closest_.offer(leaves, padded(result, padding_), limit_);
  }

  const Part &a_, &b_;
  const RelativePose& a_T_b_;
  const double rounding_, limit_, padding_;
  const Question& question_;
  const Skipping skipping_;
  const double within_;
  ClosestPieces& closest_;
  const ClosestPieces* const pieces_;  ///< nullptr: not known
  RelativePose outer_T_inner_;
  Outer outer_ = Outer::A;
  int outer_leaf_ = -1;  ///< the leaf of the solid
  Eigen::Isometry3d mesh_T_outer_;
};

}  // namespace

void findInteriorDepths(const PlacedPair& pair, double limit, const Question& question, Skipping skipping,
                        double within, ClosestPieces& closest, const ClosestPieces* pieces) {
  InteriorSearch(pair, limit, question, skipping, within, closest, pieces).run();
}

}  // namespace proximity_server::scene
