#include "proximity_server/scene/points/self_filter.h"

#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/points/point_search.h"
#include "proximity_server/scene/sensed/voxel_grid.h"
#include "scene/points/placed_shapes.h"
#include "scene/points/point_part.h"
#include "scene/query/interior_search.h"
#include "scene/scene_model/given_model.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Array3i;
using Eigen::Vector3d;

/// The robot with what it holds, and the objects with a padding of their own.
std::vector<ShapeRef> shapesFor(const State& state, const SelfPadding& padding) {
  std::vector<ShapeRef> shapes = shapesOfRobot(state.robot(), *state.objects());
  for (const auto& [id, of_object] : padding.of_objects) {
    const int number = state.objects()->find(id);
    if (number >= 0 && !std::holds_alternative<Attached>(state.objects()->object(number)->placement))
      shapes.push_back(ShapeRef::ofObject(number));
  }
  return shapes;
}

/// [m] The padding of a shape.
double paddingOf(const ShapeRef& shape, const State& state, const SelfPadding& padding) {
  int link = shape.isLink() ? shape.link() : -1;
  if (!shape.isLink()) {
    const Object& object = *state.objects()->object(shape.object());
    const auto own = padding.of_objects.find(object.id);
    if (own != padding.of_objects.end()) return own->second;
    link = state.robot().findLink(std::get<Attached>(object.placement).link);
  }
  const auto of_link = padding.of_links.find(link);
  return of_link == padding.of_links.end() ? padding.of_all : of_link->second;
}

/// [m] The paddings of the shapes.
std::vector<double> paddingsOf(const std::vector<ShapeRef>& shapes, const State& state, const SelfPadding& padding) {
  std::vector<double> paddings;
  for (const ShapeRef& shape : shapes) {
    paddings.push_back(paddingOf(shape, state, padding));
    if (!(paddings.back() >= 0.0) || !std::isfinite(paddings.back()))
      throw std::invalid_argument("the padding of " + nameOf(shape, state.robot(), state.objects().get()) +
                                  " is negative or not finite");
  }
  return paddings;
}

void requireTime(const Question& question) {
  if (question.deadline.hasPassed()) throw std::runtime_error("the time for the self filter is over");
}

}  // namespace

class SelfFilter::Work {
 public:
  Work(std::shared_ptr<const SceneModel> model, double resolution)
      : model_(std::move(model)), search_(model_), grid_(resolution) {
    given(model_);
  }

  std::size_t remove(const State& state, const SelfPadding& padding, std::vector<Vector3d>& points,
                     const Question& question) {
    take(state, padding);
    grid_.clear();
    voxels_.clear();
    for (const Vector3d& point : points) voxels_.push_back(grid_.add(point));
    fates_.clear();
    near_.assign(grid_.bricks(), kFar);
    open_.clear();
    open_ends_.assign(1, 0);
    for (std::uint32_t brick = 0; brick < grid_.bricks(); ++brick) {
      requireTime(question);
      settleBrick(brick, question);
    }
    is_removed_.assign(points.size(), false);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (i % kPointsPerLook == 0) requireTime(question);
      is_removed_[i] = isRemoved(points[i], voxels_[i], question);
    }
    for (const PlacedShapes::Place& place : shapes_.unbounded()) removeNear(state, place, points, question);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (!is_removed_[i]) points[kept++] = points[i];
    const std::size_t removed = points.size() - kept;
    points.resize(kept);
    return removed;
  }

 private:
  static constexpr int kInteriors = -1;  ///< takes the place of a leaf
  static constexpr int kFar = -1;
  static constexpr std::size_t kPointsPerLook = 256;  ///< at the clock

  /// A piece that may be within its padding of a ball, or the interiors of a part.
  struct Candidate {
    const PlacedShapes::Place* place;
    int leaf;
    double padding, gap;  ///< [m] `gap`: of its bounds from the ball
    narrowphase::WarmStart start{};

    /// Pieces before interiors, the nearest first.
    bool operator<(const Candidate& other) const {
      return (leaf < 0) != (other.leaf < 0) ? other.leaf < 0 : gap < other.gap;
    }
  };

  struct Ball {
    Vector3d centre;
    double radius;
  };

  /// What becomes of the points of a voxel. From kOpen on it is the number of the list of candidates to compare them with.
  using Fate = int;
  static constexpr Fate kKept = -2, kRemoved = -1, kOpen = 0;

  void take(const State& state, const SelfPadding& padding) {
    state.requireModel(*model_);
    const std::vector<ShapeRef> shapes = shapesFor(state, padding);
    paddings_ = paddingsOf(shapes, state, padding);
    most_padding_ = paddings_.empty() ? 0.0 : *std::max_element(paddings_.begin(), paddings_.end());
    shapes_.take(state, shapes, &shapesOfRobot);
    if (!shapes_.unplaced().empty())
      throw std::invalid_argument(nameOf(shapes_.unplaced().front(), state.robot(), state.objects().get()) +
                                  " has no pose");
  }

  /// The ball about a block of voxels, with rounding.
  Ball ballOf(std::uint32_t brick, const Array3i& corner, int edge) const {
    const Vector3d of_corner = grid_.centre({brick, bitOf(corner)});
    const Vector3d centre = of_corner.array() + 0.5 * (edge - 1) * grid_.resolution();
    return {centre, edge * std::max(grid_.radius(centre), grid_.radius(of_corner))};
  }

  static std::uint32_t bitOf(const Array3i& voxel) {
    return static_cast<std::uint32_t>(voxel.x() + VoxelGrid::kEdge * (voxel.y() + VoxelGrid::kEdge * voxel.z()));
  }

  template <class Visit>
  static void forCorners(const Array3i& corner, int edge, int step, const Visit& visit) {
    for (int z = 0; z < edge; z += step)
      for (int y = 0; y < edge; y += step)
        for (int x = 0; x < edge; x += step) visit(corner + Array3i(x, y, z));
  }

  /// [m] A lower bound of the distance of what a candidate names from a ball.
  static double gapOf(const PlacedShapes::Place& place, int leaf, const Ball& ball) {
    const Vector3d in_body = place.pose.rotation.transpose() * (ball.centre - place.pose.translation);
    const Volume& volume = leaf == kInteriors ? place.part.whole() : place.part[leaf];
    return gapTo(volume.bounds, in_body) - (1.0 + kPoseRounding) * ball.radius;
  }

  void settleBrick(std::uint32_t brick, const Question& question) {
    const Vector3d centre = grid_.centreOfBrick(brick);
    const Ball ball{centre, grid_.radiusOfBrick(centre)};
    list_.clear();
    const auto gap = [&](const Eigen::AlignedBox3d& box) { return gapTo(box, ball.centre) - ball.radius; };
    shapes_.visitNearest(
        gap, [&] { return most_padding_; },
        [&](const PlacedShapes::Place& place) {
          collect(place, place.part.root, ball);
          if (place.part.whole().has_interior) collect(place, kInteriors, ball);
        });
    if (list_.empty()) return;
    near_[brick] = static_cast<int>(fates_.size()) / VoxelGrid::kVoxels;
    fates_.resize(fates_.size() + VoxelGrid::kVoxels, kKept);
    settleParts(brick, Array3i::Zero(), VoxelGrid::kEdge, 0, question);
  }

  /// Lists the pieces below a volume that may be within their padding of a ball.
  void collect(const PlacedShapes::Place& place, int volume, const Ball& ball) {
    const double gap = gapOf(place, volume, ball), padding = paddings_[place.number];
    if (gap > padding) return;
    if (volume == kInteriors || place.part[volume].isLeaf()) {
      list_.push_back({&place, volume, padding, gap});
    } else {
      for (const int part : place.part[volume].parts) collect(place, part, ball);
    }
  }

  bool isOccupied(std::uint32_t brick, const Array3i& corner, int edge) const {
    bool is_occupied = false;
    forCorners(corner, edge, 1, [&](const Array3i& voxel) { is_occupied |= grid_.has({brick, bitOf(voxel)}); });
    return is_occupied;
  }

  void settleParts(std::uint32_t brick, const Array3i& corner, int edge, std::size_t first, const Question& question) {
    forCorners(corner, edge, edge / 2, [&](const Array3i& part) { settle(brick, part, edge / 2, first, question); });
  }

  /// Finds the fates of a block; its candidates are among those that list_ has from `first` on.
  void settle(std::uint32_t brick, const Array3i& corner, int edge, std::size_t first, const Question& question) {
    if (!isOccupied(brick, corner, edge)) return;
    const Ball ball = ballOf(brick, corner, edge);
    const std::size_t own = list_.size();
    for (std::size_t i = first; i < own; ++i) {
      Candidate candidate = list_[i];
      candidate.gap = gapOf(*candidate.place, candidate.leaf, ball);
      if (!(candidate.gap > candidate.padding)) list_.push_back(candidate);
    }
    std::sort(list_.begin() + static_cast<std::ptrdiff_t>(own), list_.end());
    Fate fate = list_.size() == own ? kKept : kOpen;
    // A larger ball that meets the surface cannot be within the padding.
    if (fate == kOpen && (edge == 1 || ball.radius <= most_padding_)) fate = fateOf(ball, own, question);
    Fate* const fates = &fates_[static_cast<std::size_t>(near_[brick]) * VoxelGrid::kVoxels];
    if (fate == kRemoved) {
      forCorners(corner, edge, 1, [&](const Array3i& voxel) { fates[bitOf(voxel)] = kRemoved; });
    } else if (fate == kOpen && edge > 1) {
      settleParts(brick, corner, edge, own, question);
    } else if (fate == kOpen) {
      fates[bitOf(corner)] = kOpen + static_cast<Fate>(open_ends_.size()) - 1;
      open_.insert(open_.end(), list_.begin() + static_cast<std::ptrdiff_t>(own), list_.end());
      open_ends_.push_back(open_.size());
    }
    list_.resize(own);
  }

  /// The fate of a ball; leaves out the candidates from `first` on that are beyond the padding.
  Fate fateOf(const Ball& ball, std::size_t first, const Question& question) {
    std::size_t left = first;
    for (std::size_t i = first; i < list_.size(); ++i) {
      const Fate beside = fateBeside(list_[i], ball, question);
      if (beside == kRemoved) return kRemoved;
      // Beside a surface the centre does not tell for the whole ball whether it is inside.
      const bool is_at_surface = list_[i].leaf == kInteriors && left > first;
      if (beside == kOpen || is_at_surface) list_[left++] = list_[i];
    }
    list_.resize(left);
    return left == first ? kKept : kOpen;
  }

  Fate fateBeside(Candidate& candidate, const Ball& ball, const Question& question) {
    const PlacedShapes::Place& place = *candidate.place;
    const PlacedPair pair = point_.pairAt(ball.centre, place.part, place.pose, 0.0);
    if (candidate.leaf == kInteriors) {
      ClosestPieces found;
      findInteriorDepths(pair, kInfinity, question, Skipping::On, 0.0, found);
      if (found.empty()) return kKept;
      return found.upper_bound <= candidate.padding - ball.radius ? kRemoved : kOpen;
    }
    narrowphase::Options options;
    options.distance_tolerance = question.tolerance;
    options.stop_above = candidate.padding + ball.radius;
    options.stop_below = candidate.padding - ball.radius;
    const narrowphase::SignedDistance found = PlacedRobot::distanceInBodyA(
        Leaf(pair.a, pair.a.root), Leaf(pair.b, candidate.leaf), pair.a_T_b, options, candidate.start);
    if (found.lower_bound > options.stop_above) return kKept;
    return found.upper_bound <= options.stop_below ? kRemoved : kOpen;
  }

  bool isRemoved(const Vector3d& point, const VoxelGrid::Voxel& voxel, const Question& question) {
    if (near_[voxel.brick] == kFar) return false;
    const Fate fate = fates_[static_cast<std::size_t>(near_[voxel.brick]) * VoxelGrid::kVoxels + voxel.bit];
    if (fate < kOpen) return fate == kRemoved;
    const auto list = static_cast<std::size_t>(fate - kOpen);
    for (std::size_t i = open_ends_[list]; i < open_ends_[list + 1]; ++i)
      if (fateBeside(open_[i], {point, 0.0}, question) != kKept) return true;
    return false;
  }

  /// Removes points near an object with half-spaces, which is near to no brick alone.
  void removeNear(const State& state, const PlacedShapes::Place& place, const std::vector<Vector3d>& points,
                  const Question& question) {
    Question within = question;
    within.threshold = paddings_[place.number];
    const std::vector<PairProximity>& found = search_.closest(state, {points, {}, {place.ref}}, within);
    requireTime(question);
    for (std::size_t i = 0; i < points.size(); ++i)
      if (found[i].result.status != narrowphase::Status::Threshold) is_removed_[i] = true;
  }

  std::shared_ptr<const SceneModel> model_;
  PointSearch search_;
  const PointPart point_;
  PlacedShapes shapes_;
  std::vector<double> paddings_;  ///< [m] of the shapes
  double most_padding_ = 0.0;
  VoxelGrid grid_;
  std::vector<VoxelGrid::Voxel> voxels_;  ///< of the points
  std::vector<bool> is_removed_;          ///< the points
  std::vector<int> near_;                 ///< for each brick its number among those with candidates, or kFar
  std::vector<Fate> fates_;               ///< of the voxels of these bricks
  std::vector<Candidate> list_;           ///< of a block, after those of the blocks that it is in
  std::vector<Candidate> open_;           ///< of the open voxels
  std::vector<std::size_t> open_ends_;    ///< list i of open_ is from entry i of this to the next one
};

SelfFilter::SelfFilter(std::shared_ptr<const SceneModel> model, double resolution)
    : work_(std::make_unique<Work>(std::move(model), resolution)) {}
SelfFilter::~SelfFilter() = default;
SelfFilter::SelfFilter(SelfFilter&&) noexcept = default;
SelfFilter& SelfFilter::operator=(SelfFilter&&) noexcept = default;

std::size_t SelfFilter::remove(const State& state, const SelfPadding& padding, std::vector<Vector3d>& points,
                               const Question& question) {
  return work_->remove(state, padding, points, question);
}

}  // namespace proximity_server::scene
