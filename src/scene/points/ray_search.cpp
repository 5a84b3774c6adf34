#include "proximity_server/scene/points/ray_search.h"

#include "proximity_server/narrowphase/motion/motion.h"
#include "proximity_server/scene/points/point_search.h"
#include "scene/points/placed_shapes.h"
#include "scene/points/point_part.h"
#include "scene/query/interior_search.h"
#include "scene/scene_model/given_model.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;
using narrowphase::Status;

/// A ray in some frame.
struct Line {
  Vector3d origin, direction;  ///< of unit length

  Line in(const RelativePose& frame) const {
    return {frame.rotation.transpose() * (origin - frame.translation), frame.rotation.transpose() * direction};
  }
  Vector3d at(double distance) const { return origin + distance * direction; }
};

/// [m] Where a line enters a box about the origin, along the axes of its frame; at least 0. Infinity if it does not.
double entry(const Line& line, const Vector3d& half) {
  double first = 0.0, last = kInfinity;
  for (int i = 0; i < 3; ++i) {
    const double from = line.origin[i], along = line.direction[i];
    if (along == 0.0) {
      if (std::abs(from) > half[i]) return kInfinity;
      continue;
    }
    const double to_low = (-half[i] - from) / along, to_high = (half[i] - from) / along;
    first = std::max(first, std::min(to_low, to_high));
    last = std::min(last, std::max(to_low, to_high));
  }
  return first <= last ? first : kInfinity;
}

}  // namespace

void requireValid(const std::vector<Ray>& rays) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Ray& ray = rays[i];
    const std::string number = "[" + std::to_string(i) + "]";
    if (!ray.origin.allFinite()) throw std::invalid_argument("origins" + number + " is not finite");
    if (!ray.direction.allFinite() || !(ray.direction.stableNorm() > 0.0))
      throw std::invalid_argument("directions" + number + " is not finite, or has no length");
    if (!(ray.range > 0.0)) throw std::invalid_argument("ranges" + number + " is not positive");
  }
}

std::vector<ShapeRef> allShapes(const RobotModel& robot, const Objects& objects) {
  std::vector<ShapeRef> shapes = shapesOfRobot(robot, objects);
  for (const int number : objects.numbers())
    if (objects.placed(number)->kind != PlacedObject::Kind::Attached) shapes.push_back(ShapeRef::ofObject(number));
  return shapes;
}

class RaySearch::Work {
 public:
  explicit Work(std::shared_ptr<const SceneModel> model) : model_(std::move(model)) { given(model_); }

  const std::vector<RayHit>& firstHits(const State& state, const std::vector<Ray>& rays,
                                       const std::vector<ShapeRef>& shapes, const Question& question) {
    state.requireModel(*model_);
    requireValid(rays);
    shapes_.take(state, shapes, &allShapes);
    hits_.clear();
    hits_.reserve(rays.size());
    for (const Ray& ray : rays) {
      const bool is_late = question.deadline.hasPassed();
      hits_.push_back(is_late ? RayHit() : firstHit(ray, narrowphase::usableTolerance(question.tolerance)));
    }
    return hits_;
  }

  const std::vector<ShapeRef>& unplaced() const { return shapes_.unplaced(); }

 private:
  /// A shape, with the ray in the frame of its body.
  struct Target {
    Target(const PlacedShapes::Place& shape, const Line& ray) : place(shape), line(ray.in(shape.pose)) {}

    const PlacedShapes::Place& place;
    const Line line;
    const double rounding = kPoseRounding * (line.origin.norm() + place.part.whole().bounds.reach);  ///< [m] of places
  };

  RayHit firstHit(const Ray& ray, double tolerance) {
    ray_ = {ray.origin, ray.direction.stableNormalized()};
    tolerance_ = tolerance;
    end_ = undecided_ = ray.range;
    undecided_status_ = Status::Converged;
    hit_ = {};
    hit_.free = ray.range;
    for (const PlacedShapes::Place& place : shapes_.unbounded()) visitPart(place);
    const auto entryOf = [&](const Eigen::AlignedBox3d& box) {
      const double rounding = kPoseRounding * (ray_.origin.norm() + box.center().norm());
      return entry({ray_.origin - box.center(), ray_.direction}, 0.5 * box.sizes() + Vector3d::Constant(rounding));
    };
    const auto before_end = [&] { return std::nextafter(end_, 0.0); };
    shapes_.visitNearest(entryOf, before_end, [&](const PlacedShapes::Place& place) { visitPart(place); });
    if (undecided_status_ == Status::Unknown) return {};
    // Parts that are undecided do not matter behind the first hit.
    hit_.status = undecided_ < end_ ? undecided_status_ : Status::Converged;
    hit_.free = std::min(hit_.free, undecided_);
    return hit_;
  }

  void visitPart(const PlacedShapes::Place& place) {
    const Target target(place, ray_);
    if (place.part.isUnbounded()) meetHalfSpaces(target);
    if (place.part.whole().isEmpty()) return;
    const double begin = entryOf(target, place.part.root);
    if (place.part.whole().has_interior && begin == 0.0) meetInterior(target);
    visit(target, place.part.root, begin);
  }

  /// [m] Where the ray enters the box of a volume.
  static double entryOf(const Target& target, int volume) {
    const Bounds& bounds = target.place.part[volume].bounds;
    const Eigen::Matrix3d to_box = bounds.axes.transpose();
    return entry({to_box * (target.line.origin - bounds.centre), to_box * target.line.direction},
                 bounds.half + Vector3d::Constant(target.rounding));
  }

  void visit(const Target& target, int volume, double begin) {
    if (!(begin < end_)) return;
    const Volume& here = target.place.part[volume];
    if (here.isLeaf()) return meetPiece(target, target.place.part.pieces[here.piece], begin);
    const auto entry_of_part = [&](int part) { return entryOf(target, part); };
    for (const auto& [of_part, part] : smallerFirst(here.parts, entry_of_part)) visit(target, part, of_part);
  }

  /// Moves a point from where the ray enters the box of a piece, in the frame of the piece. It need not go farther than the
  /// farthest point of the part can be.
  void meetPiece(const Target& target, const Piece& piece, double begin) {
    const Eigen::Isometry3d piece_T_body = piece.body_T_piece.inverse(Eigen::Isometry);
    const double length =
        std::min(end_ - begin, target.line.origin.norm() + 2.0 * target.place.part.whole().bounds.reach - begin);
    narrowphase::ScrewMotion& along = point_chain_.front();
    along.start.translation() = piece_T_body * target.line.at(begin);
    along.linear = length * (piece_T_body.linear() * target.line.direction);
    narrowphase::ContactOptions options;
    options.contact_distance = target.rounding;
    options.tolerance = tolerance_;
    const narrowphase::TimeOfContact found =
        narrowphase::timeOfContact(piece.shape, piece_chain_, point_.shape(), point_chain_, options);
    const int number = collisionNumber(model_->robot, piece, target.place.part.object);
    if (found.contact) {
      const Vector3d normal = piece.body_T_piece.linear() * found.at_contact.normal;
      return meet(target, number, begin + found.t_free * length, begin + found.t_contact * length, normal);
    }
    if (found.status == Status::Converged) return;
    undecided_ = std::min(undecided_, begin + found.t_free * length);
    if (undecided_status_ != Status::Unknown) undecided_status_ = found.status;
  }

  /// The ray may begin inside a closed mesh, where no piece is.
  void meetInterior(const Target& target) {
    const PlacedPair pair = point_.pairAt(ray_.origin, target.place.part, target.place.pose, 0.0);
    ClosestPieces inside;
    findInteriorDepths(pair, 0.0, {}, Skipping::On, 0.0, inside);
    if (inside.empty()) return;
    const Part& part = target.place.part;
    const Vector3d outwards = target.place.pose.rotation.transpose() * -inside.result.normal;
    meet(target, collisionNumber(model_->robot, part.pieces[part[inside.leaves.b].piece], part.object), 0.0, 0.0,
         outwards);
  }

  void meetHalfSpaces(const Target& target) {
    const std::vector<PlacedHalfSpace>& half_spaces = target.place.part.halfSpaces();
    for (std::size_t i = 0; i < half_spaces.size(); ++i) {
      const PlacedHalfSpace& half_space = half_spaces[i];
      const double height = half_space.normal.dot(target.line.origin) - half_space.offset;
      const double margin = 2.0 * (target.rounding + kPoseRounding * half_space.chain_length);
      const double closing = -half_space.normal.dot(target.line.direction);
      const int number = target.place.part.shapeNumber(static_cast<int>(i));
      if (height <= margin)
        meet(target, number, 0.0, 0.0, half_space.normal);
      else if (closing > 0.0 && (height - margin) / closing < end_)
        meet(target, number, (height - margin) / closing, std::min(height / closing, end_), half_space.normal);
    }
  }

  /// Takes a hit of a shape if it is the first one so far. `normal`: in the frame of its body.
  void meet(const Target& target, int collision, double free, double distance, const Vector3d& normal) {
    hit_.free = std::min(hit_.free, free);
    if (hit_.shape.kind() != ShapeRef::Kind::None && !(distance < end_)) return;
    end_ = hit_.distance = distance;
    hit_.shape = target.place.ref.part(collision);
    hit_.normal = (target.place.pose.rotation * normal).normalized();
  }

  std::shared_ptr<const SceneModel> model_;
  const PointPart point_;
  narrowphase::MotionChain piece_chain_{1}, point_chain_{1};
  PlacedShapes shapes_;
  std::vector<RayHit> hits_;
  // The ray that is asked about, and what is known of it so far:
  Line ray_;
  double tolerance_ = 0.0;  ///< [m]
  double end_ = 0.0;        ///< [m] what is not before the end cannot be the first hit
  double undecided_ = 0.0;  ///< [m] from here on it is not known whether there is a hit
  Status undecided_status_ = Status::Converged;
  RayHit hit_;
};

RaySearch::RaySearch(std::shared_ptr<const SceneModel> model) : work_(std::make_unique<Work>(std::move(model))) {}
RaySearch::~RaySearch() = default;
RaySearch::RaySearch(RaySearch&&) noexcept = default;
RaySearch& RaySearch::operator=(RaySearch&&) noexcept = default;

const std::vector<RayHit>& RaySearch::firstHits(const State& state, const std::vector<Ray>& rays,
                                                const std::vector<ShapeRef>& shapes, const Question& question) {
  return work_->firstHits(state, rays, shapes, question);
}

const std::vector<ShapeRef>& RaySearch::unplaced() const { return work_->unplaced(); }

}  // namespace proximity_server::scene
