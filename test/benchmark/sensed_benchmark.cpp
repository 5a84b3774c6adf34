// What a depth camera sees of a robot and around it: the self filter, the voxels, the object of them, and how far the robot
// is from it, beside FCL with an octree of octomap and beside FCL with our boxes. The distances are compared with those of
// all voxels, one by one, and with the nearest point. The results go into a JSON file. Times are those of the processor.
// ./dev bench sensed runs it pinned.
#include "benchmark/benchmark_main.h"
#include "benchmark/timing.h"
#include "chance.h"
#include "peers/robots.h"
#include "peers/sensed_library.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "proximity_server/scene/answers/assessment.h"
#include "proximity_server/scene/points/point_search.h"
#include "proximity_server/scene/points/ray_search.h"
#include "proximity_server/scene/points/self_filter.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/sensed/voxel_grid.h"
#include "scene/bounds/bounds.h"
#include "scene/example_robots.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::benchmark {

using namespace scene;
using namespace peers;
namespace {

using Eigen::AlignedBox3d;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using nlohmann::json;

constexpr int kRounds = 5;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRange = 4.0;     // [m] of the camera
constexpr double kNoise = 0.003;   // [m] along the ray, one sigma
constexpr double kPadding = 0.03;  // [m]
constexpr double kStep = 3e-3;     // [rad] or [m] of each joint, from one state to the next

/// All joints at 0.3, but those that hold an arm in front of its base.
std::vector<double> positionsAt(const RobotModel& robot, int step) {
  const std::map<std::string, double> special{
      {"panda_joint4", -1.5}, {"panda_joint6", 1.8}, {"panda_finger_joint1", 0.03}, {"panda_finger_joint2", 0.03}};
  std::vector<double> positions;
  for (const Joint& joint : robot.joints) {
    const auto found = special.find(joint.name);
    positions.push_back((found == special.end() ? 0.3 : found->second) + kStep * step);
  }
  return positions;
}

// ---- the cloud

/// Row by row: 4 columns for 3 rows, 60 degrees wide.
std::vector<Ray> raysOfCamera(int columns) {
  const Vector3d camera(1.6, 0.8, 1.3), forward = (Vector3d(0, 0, 0.4) - camera).normalized();
  const Vector3d right = forward.cross(Vector3d::UnitZ()).normalized(), down = forward.cross(right);
  const int rows = columns * 3 / 4;
  const double width = 2.0 * std::tan(M_PI / 6.0) / columns;
  std::vector<Ray> rays;
  for (int v = 0; v < rows; ++v)
    for (int u = 0; u < columns; ++u) {
      const Vector3d across = width * ((u - 0.5 * columns) * right + (v - 0.5 * rows) * down);
      rays.push_back({camera, (forward + across).normalized(), kRange});
    }
  return rays;
}

/// [m] Along the ray to the first of the surroundings; infinite if there is none. A floor, a table, a post and a wall.
double surroundingsAlong(const Ray& ray) {
  static const AlignedBox3d kBoxes[] = {{Vector3d(-5, -5, -1), Vector3d(5, 5, -0.1)},
                                        {Vector3d(-0.4, -1.4, 0.6), Vector3d(0.5, -0.8, 0.65)},
                                        {Vector3d(-0.9, 0.6, 0.0), Vector3d(-0.7, 0.8, 1.5)},
                                        {Vector3d(-1.6, -2.0, 0.0), Vector3d(-1.5, 2.0, 2.0)}};
  double nearest = kInfinity;
  for (const AlignedBox3d& box : kBoxes) {
    const Eigen::Array3d a = (box.min() - ray.origin).array() / ray.direction.array();
    const Eigen::Array3d b = (box.max() - ray.origin).array() / ray.direction.array();
    const double enters = a.min(b).maxCoeff(), leaves = a.max(b).minCoeff();
    if (0.0 < enters && enters <= leaves) nearest = std::min(nearest, enters);
  }
  return nearest;
}

/// The points that the camera sees within its range, with noise.
std::vector<Vector3d> cloudOf(const State& state, int columns) {
  const std::vector<Ray> rays = raysOfCamera(columns);
  RaySearch search(state.sharedModel());
  const std::vector<RayHit>& hits = search.firstHits(state, rays);
  Chance chance(65);
  std::normal_distribution<double> noise(0.0, kNoise);
  std::vector<Vector3d> cloud;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double robot = hits[i].shape.kind() == ShapeRef::Kind::None ? kInfinity : hits[i].distance;
    const double depth = std::min(robot, surroundingsAlong(rays[i])) + noise(chance);
    if (depth < kRange) cloud.emplace_back(rays[i].origin + depth * rays[i].direction);
  }
  return cloud;
}

// ---- what is exact

/// [m] The smallest distance of the links from boxes, each piece from each box; spheres leave out those that are farther
/// than what was found.
double distanceFromEach(const RobotModel& robot, const std::vector<int>& links, const BodyPoses& poses,
                        const std::vector<AlignedBox3d>& boxes) {
  double least = kInfinity;
  for (const int link : links)
    for (const Piece* piece : piecesOfLink(robot, link)) {
      const Isometry3d& world_T_body = *poses[robot.links[link].body];
      const Isometry3d piece_T_world = (world_T_body * piece->body_T_piece).inverse();
      const Bounds bounds = boundsOf(*piece);
      const Vector3d centre = world_T_body * bounds.centre;
      for (const AlignedBox3d& box : boxes) {
        const double gap = (box.center() - centre).norm() - 0.5 * box.diagonal().norm() - bounds.radius;
        if (gap > least) continue;
        const Isometry3d piece_T_box = piece_T_world * Eigen::Translation3d(box.center());
        const narrowphase::Shape shape(narrowphase::Box{box.sizes()});
        least = std::min(least, narrowphase::signedDistance(piece->shape, shape, piece_T_box).distance);
      }
    }
  return least;
}

std::vector<AlignedBox3d> voxelsOf(const VoxelGrid& grid) {
  std::vector<AlignedBox3d> voxels;
  const Vector3d half = Vector3d::Constant(0.5 * grid.resolution());
  for (std::uint32_t brick = 0; brick < grid.bricks(); ++brick)
    for (std::uint32_t bit = 0; bit < VoxelGrid::kVoxels; ++bit)
      if (const VoxelGrid::Voxel voxel{brick, bit}; grid.has(voxel))
        voxels.emplace_back(grid.centre(voxel) - half, grid.centre(voxel) + half);
  return voxels;
}

double distanceOfPoints(const State& state, const std::vector<int>& links, const std::vector<Vector3d>& points) {
  PointSearch search(state.sharedModel());
  double least = kInfinity;
  for (const PairProximity& answer : search.closest(state, {points, {}, {links.begin(), links.end()}}))
    least = std::min(least, answer.result.distance);
  return least;
}

// ---- ours

/// A robot in front of a camera, step by step.
class Ours {
 public:
  Ours(const NamedRobot& robot, double resolution)
      : model_(robot.model), state_(model_), scene_(model_), filter_(model_, resolution), grid_(resolution) {
    moveTo(0);
  }

  void moveTo(int step) { state_.set(forwardKinematics(model_->robot, positionsAt(model_->robot, step))); }
  const State& state() const { return state_; }
  const VoxelGrid& grid() const { return grid_; }
  const std::vector<AlignedBox3d>& boxes() const { return boxes_; }

  std::size_t filter(std::vector<Vector3d>& points) { return filter_.remove(state_, {kPadding}, points); }

  void fillVoxels(const std::vector<Vector3d>& points) {
    grid_.clear();
    for (const Vector3d& point : points) grid_.add(point);
  }

  void makeBoxes() { boxes_ = grid_.boxes(); }
  void makeCamera() { camera_ = makeObject("camera", {{Boxes{boxes_}}}, Fixed{}); }

  void setCamera() {
    const Objects& now = *state_.objects();
    Objects next = now.find("camera") < 0 ? now.changed({AddObject{*camera_}}) : now.changed({ReplaceObject{*camera_}});
    state_.set(std::make_shared<const Objects>(std::move(next)));
  }

  double minimum() {
    const PairProximity* const found = scene_.minimum(state_, {scene_.candidates(), PairKind::WithObject});
    return found ? found->result.distance : kInfinity;
  }

  void findLevel() { assess(scene_, state_, {thresholds_, stated_}, assessment_); }

  /// The links that are checked against what the camera sees.
  std::vector<int> links() const {
    std::vector<int> links;
    const ShapeRef camera = ShapeRef::ofObject(state_.objects()->find("camera"));
    for (int link = 0; link < static_cast<int>(model_->robot.links.size()); ++link)
      if (model_->robot.hasGeometry(link) && state_.objects()->isChecked(link, camera)) links.push_back(link);
    return links;
  }

 private:
  std::shared_ptr<const SceneModel> model_;
  State state_;
  Scene scene_;
  SelfFilter filter_;
  VoxelGrid grid_;
  std::vector<AlignedBox3d> boxes_;
  std::optional<Object> camera_;
  LevelThresholds thresholds_;
  std::vector<std::optional<double>> stated_ = std::vector<std::optional<double>>(model_->robot.joints.size());
  Assessment assessment_;
};

/// Names of steps with their times [ms], by round.
class Steps {
 public:
  template <typename Step>
  void measure(const std::string& name, const Step& step) {
    auto found = std::find_if(times_.begin(), times_.end(), [&](const auto& entry) { return entry.first == name; });
    if (found == times_.end()) found = times_.insert(times_.end(), {name, {}});
    found->second.push_back(processorTimeOf<std::milli>(step));
  }

  /// The medians without the first round, which warms up.
  json medians() const {
    json rows = json::array();
    for (const auto& [name, times] : times_)
      rows.push_back({{"step", name}, {"ms", medianOf({times.begin() + 1, times.end()})}});
    return rows;
  }

 private:
  std::vector<std::pair<std::string, std::vector<double>>> times_;
};

/// A peer with its surroundings.
struct Peer {
  std::string name;
  FclSensed library;
  bool has_octree;
  Steps steps{};
  std::vector<double> minima{};  ///< [m] by round
};

json measureCamera(const std::string& row, const NamedRobot& robot, double resolution, int columns) {
  Ours ours(robot, resolution);
  const std::vector<Vector3d> cloud = cloudOf(ours.state(), columns);
  std::vector<Vector3d> points;
  std::size_t removed = 0;
  Steps steps;
  std::vector<Peer> peers;
  std::vector<double> minima, exact;
  for (int round = 0; round <= kRounds; ++round) {
    ours.moveTo(0);
    points = cloud;
    steps.measure("self filter", [&] { removed = ours.filter(points); });
    steps.measure("voxels", [&] { ours.fillVoxels(points); });
    steps.measure("boxes", [&] { ours.makeBoxes(); });
    steps.measure("object", [&] { ours.makeCamera(); });
    steps.measure("set", [&] { ours.setCamera(); });
    steps.measure("first minimum", [&] { ours.minimum(); });
    steps.measure("next minimum", [&] {
      ours.moveTo(2 * round + 1);
      minima.push_back(ours.minimum());
    });
    const std::vector<int> links = ours.links();
    const BodyPoses poses = ours.state().poses();
    if (peers.empty()) {
      peers.push_back({"FCL, octree, triangles", {robot.model->robot, links, FclSensed::Parts::Triangles}, true});
      peers.push_back({"FCL, octree, hulls", {robot.model->robot, links, FclSensed::Parts::Hulls}, true});
      peers.push_back({"FCL, boxes, hulls", {robot.model->robot, links, FclSensed::Parts::Hulls}, false});
    }
    for (Peer& peer : peers) {
      peer.steps.measure("update", [&] {
        peer.has_octree ? peer.library.seeOctree(points, resolution) : peer.library.seeBoxes(ours.boxes());
      });
      peer.steps.measure("minimum", [&] { peer.minima.push_back(peer.library.minimum(poses)); });
    }
    exact.push_back(distanceFromEach(robot.model->robot, links, poses, voxelsOf(ours.grid())));
    steps.measure("level", [&] {
      ours.moveTo(2 * round + 2);
      ours.findLevel();
    });
  }
  const auto errorOf = [&](const std::vector<double>& of_rounds) {
    double largest = 0.0;
    for (std::size_t i = 0; i < exact.size(); ++i) largest = std::max(largest, std::abs(of_rounds[i] - exact[i]));
    return largest;
  };
  ours.moveTo(2 * kRounds + 1);
  json result = {{"row", row},
                 {"points", cloud.size()},
                 {"on robot", removed},
                 {"voxels", ours.grid().size()},
                 {"boxes", ours.boxes().size()},
                 {"steps", steps.medians()},
                 {"minimum", exact.back()},
                 {"nearest point", distanceOfPoints(ours.state(), ours.links(), points)},
                 {"error", errorOf(minima)},
                 {"peers", json::array()}};
  for (const Peer& peer : peers)
    result["peers"].push_back({{"library", peer.name},
                               {"steps", peer.steps.medians()},
                               {"error", errorOf(peer.minima)},
                               {"failures", peer.library.failures()}});
  return result;
}

json measure(int columns, const Wanted& wanted) {
  json result = {{"rounds", kRounds}, {"rows", json::array()}};
  const std::pair<int, double> cases[] = {{0, 0.02}, {2, 0.02}, {2, 0.01}};
  for (const auto& [number, resolution] : cases) {
    const ExampleRobot& example = kExampleRobots[number];
    const std::string row = std::string(example.name) + ", " + std::to_string(std::lround(100 * resolution)) + " cm";
    if (!wanted(row)) continue;
    const std::optional<NamedRobot> robot = exampleRobot(example);
    if (!robot) {
      std::cout << row << " is left out. " << kExampleRobotsMissing << "\n";
      continue;
    }
    result["rows"].push_back(measureCamera(row, *robot, resolution, columns));
    showProgress();
  }
  return result;
}

}  // namespace
}  // namespace proximity_server::benchmark

int main(int argc, char** argv) {
  using namespace proximity_server::benchmark;
  proximity_server::tools::ProgramOptions program("sensed_benchmark", "What a depth camera sees of a Panda and a PR2");
  int columns = 640;
  addPositive(program, "--columns", columns, "of the camera's image; it has 3 rows for 4 columns");
  return benchmarkMain(program, argc, argv, [&](const Wanted& wanted) { return measure(columns, wanted); });
}
