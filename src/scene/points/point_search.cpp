#include "proximity_server/scene/points/point_search.h"

#include "scene/points/placed_shapes.h"
#include "scene/points/point_part.h"
#include "scene/query/part_distance.h"
#include "scene/scene_model/given_model.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;

/// The answer about a point that bounds prove to be beyond the threshold.
PairProximity farther(double lower_bound) {
  PairProximity proximity;
  proximity.result.status = narrowphase::Status::Threshold;
  proximity.result.distance = proximity.result.lower_bound = lower_bound;
  return proximity;
}

}  // namespace

void requireValid(const Points& points) {
  const std::size_t radii = points.radii.size(), count = points.centres.size();
  if (radii > 1 && radii != count)
    throw std::invalid_argument("there are " + std::to_string(count) + " points, but " + std::to_string(radii) +
                                " radii");
  for (std::size_t i = 0; i < count; ++i)
    if (!points.centres[i].allFinite()) throw std::invalid_argument("points[" + std::to_string(i) + "] is not finite");
  for (std::size_t i = 0; i < radii; ++i)
    if (!(points.radii[i] >= 0.0 && std::isfinite(points.radii[i])))
      throw std::invalid_argument("radii[" + std::to_string(i) + "] is negative or not finite");
}

std::vector<ShapeRef> shapesOfRobot(const RobotModel& robot, const Objects& objects) {
  std::vector<ShapeRef> shapes;
  for (int link = 0; link < static_cast<int>(robot.links.size()); ++link)
    if (robot.hasGeometry(link)) shapes.push_back(link);
  for (const int number : objects.numbers())
    if (objects.placed(number)->kind == PlacedObject::Kind::Attached) shapes.push_back(ShapeRef::ofObject(number));
  return shapes;
}

class PointSearch::Work {
 public:
  Work(std::shared_ptr<const SceneModel> model, Skipping skipping)
      : model_(std::move(model)), search_(given(model_).robot.pieces.size(), skipping, Memory::None) {}

  const std::vector<PairProximity>& closest(const State& state, const Points& points, const Question& question) {
    state.requireModel(*model_);
    requireValid(points);
    shapes_.take(state, points.shapes, &shapesOfRobot);
    counts_ = {};
    answers_.clear();
    answers_.reserve(points.centres.size());
    const std::vector<double>& radii = points.radii;
    for (std::size_t i = 0; i < points.centres.size(); ++i) {
      const double radius = radii.empty() ? 0.0 : radii[radii.size() == 1 ? 0 : i];
      answers_.push_back(answerTo(points.centres[i], radius, question));
      answers_.back().asked.b = ShapeRef::ofPoint(static_cast<int>(i));
      count(answers_.back());
    }
    return answers_;
  }

  const std::vector<ShapeRef>& unplaced() const { return shapes_.unplaced(); }
  const PairCounts& counts() const { return counts_; }

 private:
  void count(const PairProximity& answer) {
    ++counts_.total;
    ++(answer.result.status == narrowphase::Status::Unknown ? counts_.unknown
       : answer.asked.a.kind() == ShapeRef::Kind::None      ? counts_.by_bounds
                                                            : counts_.computed);
  }

  PairProximity answerTo(const Vector3d& point, double radius, const Question& question) {
    if (shapes_.empty() || question.deadline.hasPassed()) return {};
    PairProximity best;
    const double ball = (1.0 + kPoseRounding) * radius;  // [m] not less with any rounding
    bool is_known = true;
    double lower = kInfinity, upper = kInfinity;
    const auto limit = [&] {
      return search_.skipping() == Skipping::On ? std::min(question.threshold, upper) : kInfinity;
    };
    const auto measure = [&](const PlacedShapes::Place& place) {
      const Vector3d in_body = place.pose.rotation.transpose() * (point - place.pose.translation);
      if (!place.part.isUnbounded() && gapTo(place.part.whole().bounds, in_body) - ball > limit()) return;
      const PairProximity found = distanceFrom(place, point, radius, limit(), question);
      is_known = is_known && found.result.status != narrowphase::Status::Unknown;
      if (found.result.lower_bound > std::min(question.threshold, upper)) return;
      lower = std::min(lower, found.result.lower_bound);
      upper = std::min(upper, found.result.upper_bound);
      if (!(best.result.distance <= found.result.distance)) best = found;
    };
    for (const PlacedShapes::Place& place : shapes_.unbounded()) measure(place);
    const auto gap = [&](const Eigen::AlignedBox3d& box) { return gapTo(box, point) - ball; };
    shapes_.visitNearest(gap, limit, measure);
    if (!is_known) return {};
    if (lower == kInfinity) {
      const double beyond = std::nextafter(question.threshold, kInfinity);
      return farther(shapes_.unbounded().empty() ? std::max(beyond, gap(shapes_.box())) : beyond);
    }
    best.result.lower_bound = lower;
    best.result.upper_bound = upper;
    if (best.result.status == narrowphase::Status::Converged &&
        upper - lower > narrowphase::usableTolerance(question.tolerance))
      best.result.status = narrowphase::Status::Degenerate;
    return best;
  }

  /// The distance of one shape from a ball: the distance from its centre, less the radius.
  PairProximity distanceFrom(const PlacedShapes::Place& place, const Vector3d& point, double radius, double limit,
                             const Question& question) {
    const PlacedPair pair = point_.pairAt(point, place.part, place.pose, radius);
    const ClosestPieces pieces = closestOf(search_, pair, {}, limit + radius, question);
    PairProximity found = answerOf(model_->robot, pair, pieces, limit + radius, question);
    std::swap(found.collision_a, found.collision_b);
    found.asked.a = place.ref;
    narrowphase::SignedDistance& result = found.result;
    result.distance -= radius;
    if (radius > 0.0) {
      result.lower_bound = std::nextafter(result.lower_bound - radius, -kInfinity);
      result.upper_bound = std::nextafter(result.upper_bound - radius, kInfinity);
    }
    result.normal = -result.normal;
    result.point_a = point + result.point_b;
    result.point_b = result.point_a + result.distance * result.normal;
    found.depth_is_lower_bound = result.distance < 0.0 && !depthIsExact(pair.a, pair.b);
    return found;
  }

  std::shared_ptr<const SceneModel> model_;
  PieceSearch search_;
  const PointPart point_;
  PlacedShapes shapes_;
  std::vector<PairProximity> answers_;
  PairCounts counts_;
};

PointSearch::PointSearch(std::shared_ptr<const SceneModel> model, Skipping skipping)
    : work_(std::make_unique<Work>(std::move(model), skipping)) {}
PointSearch::~PointSearch() = default;
PointSearch::PointSearch(PointSearch&&) noexcept = default;
PointSearch& PointSearch::operator=(PointSearch&&) noexcept = default;

const std::vector<PairProximity>& PointSearch::closest(const State& state, const Points& points,
                                                       const Question& question) {
  return work_->closest(state, points, question);
}

const std::vector<ShapeRef>& PointSearch::unplaced() const { return work_->unplaced(); }
const PairCounts& PointSearch::counts() const { return work_->counts(); }

}  // namespace proximity_server::scene
