#include "proximity_server/scene/sensed/self_filter.h"

#include "proximity_server/scene/model/names.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;

bool isBeyond(const PairProximity& answer) { return answer.result.status == narrowphase::Status::Threshold; }

/// The link of a shape, or the link that holds it.
int linkOf(const ShapeRef& shape, const State& state) {
  if (shape.isLink()) return shape.link();
  const auto& held = std::get<Attached>(state.objects()->object(shape.object())->placement);
  return state.robot().findLink(held.link);
}

}  // namespace

SelfFilter::SelfFilter(std::shared_ptr<const SceneModel> model, double resolution)
    : search_(std::move(model)), grid_(resolution) {}

/// The shapes of the robot, those with the same padding together.
std::vector<SelfFilter::Same> SelfFilter::groupsOf(const State& state, const SelfPadding& padding) {
  std::vector<Same> groups;
  for (const ShapeRef& shape : shapesOfRobot(state.robot(), *state.objects())) {
    const auto own = padding.of_links.find(linkOf(shape, state));
    const double of_shape = own == padding.of_links.end() ? padding.of_all : own->second;
    if (!(of_shape >= 0.0) || !std::isfinite(of_shape))
      throw std::invalid_argument("the padding of " + nameOf(shape, state.robot(), state.objects().get()) +
                                  " is negative or not finite");
    auto group = std::find_if(groups.begin(), groups.end(), [&](const Same& g) { return g.padding == of_shape; });
    if (group == groups.end()) group = groups.insert(groups.end(), {of_shape, {}});
    group->shapes.push_back(shape);
  }
  return groups;
}

std::size_t SelfFilter::remove(const State& state, const SelfPadding& padding, std::vector<Vector3d>& points,
                               const Question& question) {
  grid_.clear();
  voxels_.clear();
  for (const Vector3d& point : points) voxels_.push_back(grid_.add(point));
  is_removed_.assign(points.size(), false);
  for (const Same& group : groupsOf(state, padding)) removeNear(state, group, points, question);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!is_removed_[i]) points[kept++] = points[i];
  const std::size_t removed = points.size() - kept;
  points.resize(kept);
  return removed;
}

/// How near the balls are to the shapes of a group, up to its padding.
const std::vector<PairProximity>& SelfFilter::ask(const State& state, const Same& group, const Question& question) {
  balls_.shapes = group.shapes;
  Question within = question;
  within.threshold = group.padding;
  const std::vector<PairProximity>& answers = search_.closest(state, balls_, within);
  if (!search_.unplaced().empty())
    throw std::invalid_argument(nameOf(search_.unplaced().front(), state.robot(), state.objects().get()) +
                                " has no pose");
  for (const PairProximity& answer : answers)
    if (answer.result.status == narrowphase::Status::Unknown)
      throw std::runtime_error("the time for the self filter is over");
  return answers;
}

SelfFilter::Fate SelfFilter::fateOf(const VoxelGrid::Voxel& voxel) const {
  const std::size_t brick = near_[voxel.brick];
  return brick == kFar ? Fate::Kept : fates_[brick * VoxelGrid::kVoxels + voxel.bit];
}

void SelfFilter::removeNear(const State& state, const Same& group, const std::vector<Vector3d>& points,
                            const Question& question) {
  const auto clear = [&] {
    balls_.centres.clear();
    balls_.radii.clear();
  };
  const auto add = [&](const Vector3d& centre, double radius) {
    balls_.centres.push_back(centre);
    balls_.radii.push_back(radius);
  };
  clear();
  for (std::size_t brick = 0; brick < grid_.bricks(); ++brick) {
    const Vector3d centre = grid_.centreOfBrick(brick);
    add(centre, grid_.radiusOfBrick(centre));
  }
  const std::vector<PairProximity>& of_bricks = ask(state, group, question);
  std::size_t count = 0;
  near_.clear();
  for (const PairProximity& brick : of_bricks) near_.push_back(isBeyond(brick) ? kFar : count++);

  clear();
  asked_voxels_.clear();
  for (std::uint32_t brick = 0; brick < near_.size(); ++brick) {
    if (near_[brick] == kFar) continue;
    for (std::uint32_t bit = 0; bit < VoxelGrid::kVoxels; ++bit) {
      const VoxelGrid::Voxel voxel{brick, bit};
      if (!grid_.has(voxel)) continue;
      asked_voxels_.push_back(voxel);
      const Vector3d centre = grid_.centre(voxel);
      add(centre, grid_.radius(centre));
    }
  }
  fates_.assign(VoxelGrid::kVoxels * count, Fate::Kept);
  const std::vector<PairProximity>& of_voxels = ask(state, group, question);
  for (std::size_t i = 0; i < asked_voxels_.size(); ++i) {
    if (isBeyond(of_voxels[i])) continue;
    const VoxelGrid::Voxel& voxel = asked_voxels_[i];
    const double farthest = of_voxels[i].result.upper_bound + 2.0 * balls_.radii[i];
    fates_[near_[voxel.brick] * VoxelGrid::kVoxels + voxel.bit] =
        farthest <= group.padding ? Fate::Removed : Fate::Open;
  }

  clear();
  asked_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_removed_[i]) continue;
    const Fate fate = fateOf(voxels_[i]);
    if (fate == Fate::Removed) is_removed_[i] = true;
    if (fate != Fate::Open) continue;
    asked_.push_back(i);
    balls_.centres.push_back(points[i]);
  }
  const std::vector<PairProximity>& of_points = ask(state, group, question);
  for (std::size_t i = 0; i < asked_.size(); ++i) is_removed_[asked_[i]] = !isBeyond(of_points[i]);
}

}  // namespace proximity_server::scene
