// ./dev stress clouds: clouds of points around robots. The self filter and the answers about the voxels of what it leaves are
// held against the distances of all points from all pieces, in long double.
#include "chance.h"
#include "proximity_server/scene/answers/assessment.h"
#include "proximity_server/scene/points/self_filter.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/sensed/voxel_grid.h"
#include "scene/example_robots.h"
#include "scene/random_states.h"
#include "scene/small_robots.h"
#include "scene/solids.h"
#include "stress/campaign.h"
#include "stress/point_truth.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::Shape;
using Model = std::shared_ptr<const SceneModel>;
using Cloud = std::vector<Vector3d>;

constexpr int kPoints = 100, kManyPoints = 300000;
constexpr long double kTolerance = 2e-9L;  // [m] of answers, and of the rounding of poses

// ---- robots

std::string text(double number) { return std::to_string(number); }

/// A few links of up to three balls, boxes and cylinders.
Model primitives(Chance& chance) {
  const auto where = [&] {
    return text(chance.between(-0.2, 0.2)) + " " + text(chance.between(-0.2, 0.2)) + " " + text(chance.between(-3, 3));
  };
  const auto size = [&] { return text(chance.decades(-2, -0.3)); };
  std::vector<std::string> links(1 + chance.below(4));
  for (std::string& link : links)
    for (int i = chance.below(3); i >= 0; --i) switch (chance.below(3)) {
        case 0:
          link += ball(size());
          break;
        case 1:
          link += box(size() + " " + size() + " " + size(), "0 0.1 0", where());
          break;
        default:
          link += cylinder(size(), size(), "0.1 0 0", where());
      }
  return modelOf(floatingLinks(links));
}

/// Closed meshes as their triangles with an inside, or as convex pieces.
Model meshes(double tolerance) {
  Meshes files;
  ModelOptions options;
  options.mesh_tolerance = tolerance;
  const std::vector<std::string> links{files.of(scaled(bracket(), 0.2)), files.of(scaled(thickShell(), 0.1)),
                                       files.of(dentedBall())};
  return modelOf(floatingLinks(links, options));
}

Model example(const ExampleRobot& robot) {
  const MeshResolver resolve = exampleRobotsResolver();
  RobotModel model = loadRobotModel(readFile(exampleRobotFile(resolve, robot.urdf)), resolve, quickLoading());
  PairTable pairs = filterPairs(model, readFile(exampleRobotFile(resolve, robot.srdf)));
  return std::make_shared<const SceneModel>(SceneModel{std::move(model), std::move(pairs)});
}

/// `make` makes a robot for each cell, or the one of all of them.
struct CloudFamily {
  std::string name;
  int rarity;
  int points;
  std::function<Model(Chance&)> make;
};

/// Makes the robot when it is asked for first.
std::function<Model(Chance&)> once(const std::function<Model()>& make) {
  struct Lazy {
    std::once_flag flag;
    Model model;
  };
  return [make, lazy = std::make_shared<Lazy>()](Chance& /*chance*/) {
    std::call_once(lazy->flag, [&] { lazy->model = make(); });
    return lazy->model;
  };
}

const std::vector<CloudFamily>& families() {
  static const std::vector<CloudFamily> all = [] {
    std::vector<CloudFamily> found{{"primitives", 1, kPoints, primitives},
                                   {"triangles", 1, kPoints, once([] { return meshes(0.0); })},
                                   {"pieces", 1, kPoints, once([] { return meshes(0.02); })},
                                   {"many points", 1000, kManyPoints, primitives}};
    if (kIsSanitized || !findsExampleRobots(exampleRobotsResolver())) return found;
    for (const ExampleRobot& robot : kExampleRobots)
      found.push_back({robot.name, 4, kPoints, once([&robot] { return example(robot); })});
    return found;
  }();
  return all;
}

// ---- cells

/// A robot in a random state, which holds something one time in two, with a cloud.
class CloudCell {
 public:
  CloudCell(const CloudFamily& family, Chance chance, stress::Tally& tally)
      : chance_(std::move(chance)), tally_(tally), model_(family.make(chance_)), state_(model_), scene_(model_) {
    poses_ = somePoses();
    links_ = oraclePiecesOf(robot());
    hold();
    state_.set(poses_);
    for (int i = 0; i < family.points; ++i) cloud_.push_back(somePoint());
    const PointTruth truth(links_, poses_), of_held(held_pieces_.empty() ? links_ : held_, poses_);
    for (int link = 0; link < static_cast<int>(robot().links.size()); ++link)
      if (robot().hasGeometry(link)) with_geometry_.push_back(link);
    for (const Vector3d& point : cloud_) {
      distances_.emplace_back();
      for (const int link : with_geometry_)
        distances_.back().push_back(truth.placeOf(point.cast<long double>(), link).distance);
      held_distances_.push_back(held_pieces_.empty() ? DistanceBounds{}
                                                     : of_held.placeOf(point.cast<long double>(), holder_).distance);
    }
  }

  void observe() {
    tally_.add("clouds");
    tally_.add("points", static_cast<double>(cloud_.size()));
    observeFilter();
    if (failure.empty()) observeVoxels();
  }

  std::string failure;  ///< says which promise is broken; empty: none

 private:
  const RobotModel& robot() const { return model_->robot; }

  BodyPoses somePoses() {
    Isometry3d root = chance_.pose(1.0);
    if (chance_.happens(0.1)) root.translation() *= chance_.decades(0, 3);
    BodyPoses poses = placedAt(robot(), forwardKinematics(robot(), randomPositions(robot(), chance_)), {root});
    for (const Joint& joint : robot().joints)
      if (joint.type == Joint::Type::Floating) {
        // forwardKinematics() has no positions of these.
        const int body = robot().links[joint.child_link].body;
        poses[body] = root * chance_.pose(0.5);
      }
    return poses;
  }

  Shape someShape() {
    const double size = chance_.decades(-2, -0.7);
    switch (chance_.below(5)) {
      case 0:
        return narrowphase::Sphere{size};
      case 1:
        return narrowphase::Capsule{size, 2.0 * size};
      case 2:
        return narrowphase::Cylinder{size, 2.0 * size};
      case 3: {
        std::vector<Vector3d> corners;
        for (int i = 0; i < 10; ++i) corners.push_back(size * chance_.direction());
        return narrowphase::ConvexHull(corners);
      }
      default:
        return narrowphase::Box{{size, 2.0 * size, 0.7 * size}};
    }
  }

  void hold() {
    std::vector<ObjectChange> changes;
    if (chance_.happens(0.5)) {
      const OraclePiece& at = chance_.oneOf(links_);
      const Isometry3d link_T_object = chance_.pose(0.3), object_T_shape = chance_.pose(0.1);
      const Shape shape = someShape();
      holder_ = at.link;
      changes.emplace_back(AddObject{
          makeObject("held", {{shape, object_T_shape}}, Attached{robot().links[holder_].name, {}, link_T_object})});
      const Isometry3d body_T_link = robot().links[holder_].body_T_link;
      held_pieces_.push_back({shape, body_T_link * link_T_object * object_T_shape, 0});
      held_.emplace_back(held_pieces_.back(), holder_, at.body);
    }
    state_.set(std::make_shared<const Objects>(Objects(model_).changed(changes)));
  }

  /// A point in, on or near a piece, or around the robot.
  Vector3d somePoint() {
    const bool is_of_held = !held_.empty() && chance_.happens(0.2);
    const OraclePiece& piece = chance_.oneOf(is_of_held ? held_ : links_);
    const Vector3d centre = piece.oracle.centre().cast<double>();
    const double radius = static_cast<double>(piece.oracle.radius());
    const double reach = chance_.happens(0.7) ? chance_.between(0.0, 1.2) * radius : radius + chance_.decades(-3, 0);
    return *poses_[piece.body] * (piece.piece.body_T_piece * (centre + reach * chance_.direction()));
  }

  template <typename... Parts>
  void fail(const Parts&... parts) {
    if (!failure.empty()) return;
    std::ostringstream sentence;
    sentence.precision(17);
    (sentence << ... << parts);
    failure = sentence.str();
  }

  /// How far a point is from a padding: `low` and `high` of the smallest difference of a shape.
  DistanceBounds beyondPadding(std::size_t point, const SelfPadding& padding) const {
    const auto paddingOf = [&](int link) {
      const auto own = padding.of_links.find(link);
      return own == padding.of_links.end() ? padding.of_all : own->second;
    };
    DistanceBounds beyond{std::numeric_limits<long double>::infinity(), std::numeric_limits<long double>::infinity()};
    const auto offer = [&](const DistanceBounds& distance, int link) {
      beyond.low = std::min(beyond.low, distance.low - paddingOf(link));
      beyond.high = std::min(beyond.high, distance.high - paddingOf(link));
    };
    for (std::size_t i = 0; i < with_geometry_.size(); ++i) offer(distances_[point][i], with_geometry_[i]);
    if (!held_.empty()) offer(held_distances_[point], holder_);
    return beyond;
  }

  void observeFilter() {
    SelfPadding padding{chance_.happens(0.2) ? 0.0 : chance_.decades(-3, -1)};
    for (const int link : with_geometry_)
      if (chance_.happens(0.3)) padding.of_links[link] = chance_.happens(0.2) ? 0.0 : chance_.decades(-3, -0.5);
    SelfFilter filter(model_, chance_.decades(-2.5, 0));
    Cloud left = cloud_;
    const std::size_t removed = filter.remove(state_, padding, left);
    if (removed + left.size() != cloud_.size()) return fail("the filter counts ", removed, " points");
    std::size_t next = 0;
    for (std::size_t i = 0; i < cloud_.size(); ++i) {
      const bool is_left = next < left.size() && left[next] == cloud_[i];
      const DistanceBounds beyond = beyondPadding(i, padding);
      next += is_left ? 1 : 0;
      tally_.add("removed", !is_left);
      tally_.add("at padding", beyond.low <= 1e-3L && beyond.high >= -1e-3L);
      const long double rounding = kTolerance + 1e-14L * cloud_[i].norm();
      if (is_left && beyond.high < -rounding)
        return fail("the point ", cloud_[i].transpose(), " is within the padding by ",
                    static_cast<double>(-beyond.high), " m, and stays");
      if (!is_left && beyond.low > rounding)
        return fail("the point ", cloud_[i].transpose(), " is beyond the padding by ", static_cast<double>(beyond.low),
                    " m, and is removed");
      if (is_left) left_.push_back(i);
    }
    if (next != left.size()) fail("the filter changes the order");
  }

  /// What all points are as an object of voxels, or all points that the filter leaves.
  void observeVoxels() {
    if (!chance_.happens(0.2)) {
      seen_ = left_;
    } else {
      for (std::size_t i = 0; i < cloud_.size(); ++i) seen_.push_back(i);
    }
    if (seen_.empty()) return;
    VoxelGrid grid(chance_.decades(seen_.size() > kPoints ? -2 : -3, -0.5));
    for (const std::size_t i : seen_) grid.add(cloud_[i]);
    const long double diagonal = std::sqrt(3.0L) * grid.resolution();
    state_.set(std::make_shared<const Objects>(
        Objects(model_).changed({AddObject{makeObject("camera", {{Boxes{grid.boxes()}}}, Fixed{})}})));
    const ShapeRef camera = ShapeRef::ofObject(state_.objects()->find("camera"));
    std::vector<DistanceBounds> of_links;
    DistanceBounds least{std::numeric_limits<long double>::infinity(), std::numeric_limits<long double>::infinity()};
    for (std::size_t link = 0; link < with_geometry_.size(); ++link) {
      of_links.push_back({std::numeric_limits<long double>::infinity(), std::numeric_limits<long double>::infinity()});
      if (!state_.objects()->isChecked(with_geometry_[link], camera)) continue;
      for (const std::size_t i : seen_) {
        of_links.back().low = std::min(of_links.back().low, distances_[i][link].low);
        of_links.back().high = std::min(of_links.back().high, distances_[i][link].high);
      }
      least.low = std::min(least.low, of_links.back().low);
      least.high = std::min(least.high, of_links.back().high);
    }
    const long double rounding = kTolerance + 1e-13L * poses_.front()->translation().norm();
    const Pairs with_camera(scene_.candidates(), PairKind::WithObject);
    const PairProximity* const found = scene_.minimum(state_, with_camera);
    if (!found) {
      if (least.high < std::numeric_limits<long double>::infinity()) fail("there is no minimum");
      return;
    }
    tally_.add("overlaps", least.high < 0);
    const narrowphase::SignedDistance& result = found->result;
    // An overlap may be deeper than that of any two pieces, see PairProximity.
    const long double shallowest = found->depth_is_lower_bound ? std::max(least.high, 0.0L) : least.high;
    if (result.lower_bound > shallowest + rounding)
      return fail("the minimum has the lower bound ", result.lower_bound, ", and a point is at ",
                  static_cast<double>(least.high), " m, ", grid.resolution(), " m voxels");
    // In overlap the depth is that of a box of many voxels: only that there is an overlap follows from a voxel.
    if (least.low > 0 && std::max(result.upper_bound, 0.0) < least.low - diagonal - rounding)
      return fail("the minimum has the upper bound ", result.upper_bound, ", and no point is within ",
                  static_cast<double>(least.low), " m, ", grid.resolution(), " m voxels");
    checkPoint(result, diagonal + rounding);
    checkBelow(with_camera, of_links, diagonal, rounding);
    checkLevel(least.high, rounding);
  }

  /// The closest point is in a voxel: a point of the cloud is within its diagonal.
  void checkPoint(const narrowphase::SignedDistance& result, long double within) {
    if (!(result.distance > 0.0)) return;
    for (const std::size_t i : seen_)
      if ((cloud_[i] - result.point_b).norm() <= within) return;
    fail("the closest point ", result.point_b.transpose(), " is in no voxel");
  }

  /// Below a threshold are all links of which a point is, and none of which no point is, within the diagonal of a voxel.
  void checkBelow(const Pairs& pairs, const std::vector<DistanceBounds>& of_links, long double diagonal,
                  long double rounding) {
    Question question;
    question.threshold = chance_.decades(-3, 0);
    std::vector<int> below;
    for (const PairProximity& pair : scene_.below(state_, pairs, question)) below.push_back(pair.asked.a.link());
    for (std::size_t i = 0; i < of_links.size(); ++i) {
      const bool is_below = std::count(below.begin(), below.end(), with_geometry_[i]) > 0;
      tally_.add("below", is_below);
      if (!is_below && of_links[i].high < question.threshold - rounding)
        return fail("the link ", robot().links[with_geometry_[i]].name, " is not below ", question.threshold);
      if (is_below && of_links[i].low > 0 && of_links[i].low - diagonal > question.threshold + rounding)
        return fail("the link ", robot().links[with_geometry_[i]].name, " is below ", question.threshold);
    }
  }

  void checkLevel(long double distance, long double rounding) {
    LevelThresholds thresholds;
    thresholds.stop = {0.05, 0.05};
    thresholds.warn = {0.1, 0.1};
    Assessment assessment;
    const std::vector<std::optional<double>> stated(robot().joints.size());
    assess(scene_, state_, {thresholds, stated}, assessment);
    const ClearanceLevel level = assessment.level ? assessment.level->level : ClearanceLevel::Clear;
    tally_.add("clear", level == ClearanceLevel::Clear);
    if (distance < 0.05L - rounding && level < ClearanceLevel::Stop) fail("the level is below STOP");
    if (distance < 0.1L - rounding && level == ClearanceLevel::Clear) fail("the level is CLEAR");
  }

  Chance chance_;
  stress::Tally& tally_;
  const Model model_;
  State state_;
  Scene scene_;
  BodyPoses poses_;
  std::vector<OraclePiece> links_;
  std::deque<Piece> held_pieces_;  ///< of held_
  std::vector<OraclePiece> held_;
  int holder_ = -1;
  Cloud cloud_;
  std::vector<int> with_geometry_;                      ///< links
  std::vector<std::vector<DistanceBounds>> distances_;  ///< of the points, from each of with_geometry_
  std::vector<DistanceBounds> held_distances_;
  std::vector<std::size_t> left_, seen_;  ///< points by their numbers
};

void askCloud(const stress::Part& part, stress::Tally& tally) {
  const stress::Stopwatch watch;
  CloudCell cell(families()[part.family], Chance(part.seed, part.family, part.number), tally);
  cell.observe();
  tally.add("seconds", watch.seconds());
  if (!cell.failure.empty()) tally.fail({part.number, cell.failure, {}});
}

}  // namespace
}  // namespace proximity_server::scene

namespace proximity_server::stress {

Campaign cloudCampaign() {
  Campaign campaign{"cloud_stress", "Looks for clouds of points whose filter or voxels are wrong.", "clouds", "cloud"};
  campaign.option = "--clouds";
  campaign.usual = 10000;
  campaign.record_file = "recorded_clouds.jsonl";
  campaign.families = namesOf(scene::families());
  campaign.ask = scene::askCloud;
  campaign.name_width = 12;
  campaign.columns = {count("clouds", 8, "clouds"),
                      count("points", 10, "points"),
                      count("removed", 10, "removed"),
                      count("at padding", 11, "at padding"),
                      count("overlaps", 9, "overlaps"),
                      count("below", 8, "below"),
                      count("clear", 8, "clear"),
                      ratio("ms", 7, "%*.1f", "seconds", "clouds", 1e3),
                      failures(8)};
  campaign.legend =
      "removed: by the self filter; at padding: within 1 mm of it; overlaps: clouds with a point in a link; below: "
      "links "
      "near\nvoxels; clear: levels; ms: time of a cloud, truth included. Clouds have 100 points, \"many points\" have "
      "300,000.";
  return campaign;
}

}  // namespace proximity_server::stress
