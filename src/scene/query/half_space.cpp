#include "scene/query/half_space.h"

#include "proximity_server/narrowphase/shape/support.h"
#include "scene/bounds/box_tree.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;
using narrowphase::SignedDistance;
using narrowphase::Status;

/// The plane in the frame of the body of the piece.
struct Plane {
  Plane(const PlacedHalfSpace& half_space, const RelativePose& a_T_b)
      : normal((a_T_b.rotation * half_space.normal).normalized()),
        offset(half_space.offset + normal.dot(a_T_b.translation)) {}
  Vector3d normal;
  double offset;  ///< [m]
};

/// Walks the volumes of a, the nearer one first.
class HalfSpaceSearch {
 public:
  HalfSpaceSearch(const PlacedPair& pair, double limit, const Question& question, Skipping skipping)
      : a_(pair.a),
        half_spaces_(pair.b.halfSpaces()),
        a_T_b_(pair.a_T_b),
        rounding_(PlacedRobot::rounding(a_.whole(), pair.b.whole(), a_T_b_)),
        limit_(limit),
        padding_(pair.padding),
        question_(question),
        skipping_(skipping) {}

  ClosestPieces run() {
    for (; half_space_ < static_cast<int>(half_spaces_.size()); ++half_space_) visit(a_.root, gap(a_.root));
    return closest_;
  }

 private:
  const PlacedHalfSpace& halfSpace() const { return half_spaces_[half_space_]; }
  double gap(int volume) const { return halfSpaceGap(a_[volume], halfSpace(), a_T_b_, rounding_) - padding_; }

  void visit(int volume, double lower_bound) {
    if (skipping_ == Skipping::On && lower_bound > closest_.limit(limit_, question_)) {
      closest_.leaveOut(lower_bound);
      return;
    }
    const Volume& here = a_[volume];
    if (here.isLeaf()) {
      const SignedDistance result = halfSpaceDistance(a_.pieces[here.piece], halfSpace(), a_T_b_, rounding_,
                                                      narrowphase::usableTolerance(question_.tolerance));
      LeafPair leaves;
      leaves.a = volume;
      leaves.half_space = half_space_;
      closest_.offer(leaves, padded(result, padding_), limit_);
      return;
    }
    for (const auto& [bound, part] : smallerFirst(here.parts, [&](int volume_of) { return gap(volume_of); }))
      visit(part, bound);
  }

  const Part& a_;
  const std::vector<PlacedHalfSpace>& half_spaces_;
  const RelativePose& a_T_b_;
  const double rounding_, limit_, padding_;
  const Question& question_;
  const Skipping skipping_;
  int half_space_ = 0;  ///< the one that is looked at
  ClosestPieces closest_;
};

}  // namespace

SignedDistance halfSpaceDistance(const Piece& piece, const PlacedHalfSpace& half_space, const RelativePose& a_T_b,
                                 double rounding, double tolerance) {
  const Plane plane(half_space, a_T_b);
  const Vector3d down = -(piece.body_T_piece.linear().transpose() * plane.normal);
  int vertex = 0;
  const Vector3d lowest = piece.body_T_piece * supportPoint(piece.shape, down, vertex);
  SignedDistance result;
  result.distance = plane.normal.dot(lowest) - plane.offset - piece.shape.margin();
  // Besides the rounding of the poses there is the rounding of the support point, less than 4 eps of the piece's
  // radius, and the rounding of the sums here. Both are smaller than the rounding of the poses.
  result.lower_bound = result.distance - 2.0 * rounding;
  result.upper_bound = result.distance + 2.0 * rounding;
  result.normal = -plane.normal;
  result.point_a = lowest - piece.shape.margin() * plane.normal;
  result.point_b = result.point_a + result.distance * result.normal;
  result.has_points = true;
  result.unique = supportFeature(piece.shape, down.normalized(), tolerance, vertex).dimension == 0;
  result.status = result.upper_bound - result.lower_bound <= tolerance ? Status::Converged : Status::Degenerate;
  return result;
}

double halfSpaceGap(const Volume& a, const PlacedHalfSpace& half_space, const RelativePose& a_T_b, double rounding) {
  const Plane plane(half_space, a_T_b);
  const double height = plane.normal.dot(a.bounds.centre) - plane.offset;
  const double width = (a.bounds.axes.transpose() * plane.normal).cwiseAbs().dot(a.bounds.half);
  return height - std::min(width, a.bounds.radius) - 2.0 * rounding;
}

ClosestPieces closestToHalfSpaces(const PlacedPair& pair, double limit, const Question& question, Skipping skipping) {
  return HalfSpaceSearch(pair, limit, question, skipping).run();
}

}  // namespace proximity_server::scene
