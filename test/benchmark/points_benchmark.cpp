// How far points are from a Panda, beside FCL and a kd-tree of its vertices, and what rays meet first: clouds all around it
// and of a depth camera, cold and in small steps of the arm. The results go into a JSON file. Times are those of the
// processor. ./dev bench points runs it pinned.
#include "benchmark/benchmark_main.h"
#include "benchmark/timing.h"
#include "chance.h"
#include "peers/point_library.h"
#include "peers/robots.h"
#include "proximity_server/scene/points/point_search.h"
#include "proximity_server/scene/points/ray_search.h"
#include "scene/example_robots.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::benchmark {

using namespace scene;
using namespace peers;
namespace {

using Eigen::Vector3d;
using nlohmann::json;

constexpr int kRounds = 5;
constexpr double kStep = 1e-3;       // [rad] of each joint, from one question to the next
constexpr double kThreshold = 0.1;   // [m]
constexpr std::size_t kOthers = 10;  // the others, which are slower, have one point in so many
constexpr double kReady[] = {0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785};  // [rad] "ready" of Panda's SRDF

enum class Manner : unsigned char { Cold, Steps };
constexpr std::pair<const char*, Manner> kManners[] = {{"cold", Manner::Cold}, {"steps", Manner::Steps}};
constexpr std::pair<const char*, double> kThresholds[] = {{"within 0.1 m", kThreshold},
                                                          {"all", std::numeric_limits<double>::infinity()}};

/// The arm in its first pose, or after some steps.
BodyPoses posesAfter(const RobotModel& robot, int steps) {
  std::vector<double> positions(robot.joints.size(), 0.0);
  for (std::size_t i = 0; i < std::size(kReady) && i < positions.size(); ++i) positions[i] = kReady[i] + kStep * steps;
  return forwardKinematics(robot, positions);
}

// ---- clouds

/// Points in a cube.
std::vector<Vector3d> cloudAround(const Vector3d& centre, double half_size, int count) {
  Chance chance(62);
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double x = chance.between(-1, 1), y = chance.between(-1, 1), z = chance.between(-1, 1);
    points.push_back(centre + half_size * Vector3d(x, y, z));
  }
  return points;
}

/// The rays of a camera that looks at the arm, row by row: 4 columns for 3 rows, 70 degrees wide.
std::vector<Ray> raysOfCamera(int count) {
  const Vector3d camera(1.5, 0.6, 1.0), forward = (Vector3d(0.2, 0, 0.3) - camera).normalized();
  const Vector3d right = forward.cross(Vector3d::UnitZ()).normalized(), down = forward.cross(right);
  const int columns = static_cast<int>(std::ceil(std::sqrt(count * 4.0 / 3.0)));
  const double width = 2.0 * std::tan(35.0 * M_PI / 180.0) / columns;
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    const double u = i % columns - 0.5 * columns, v = i / columns - 0.375 * columns;
    rays.push_back({camera, (forward + width * (u * right + v * down)).normalized()});
  }
  return rays;
}

/// The points that the camera sees. Around the robot are the floor, a ball of radius 0.2 m beside the gripper, and as the
/// background a sphere of radius 2.5 m about the base.
std::vector<Vector3d> cloudOfCamera(int count) {
  const auto meetsBall = [](const Ray& ray, const Vector3d& centre, double radius, double side) {
    const double middle = ray.direction.dot(centre - ray.origin);
    const double across = (ray.origin + middle * ray.direction - centre).norm();
    const double found = middle + side * std::sqrt(std::max(0.0, radius * radius - across * across));
    return across < radius ? found : std::numeric_limits<double>::infinity();
  };
  std::vector<Vector3d> points;
  for (const Ray& ray : raysOfCamera(count)) {
    double depth = std::min(meetsBall(ray, {0.5, -0.4, 0.4}, 0.2, -1.0), meetsBall(ray, Vector3d::Zero(), 2.5, 1.0));
    if (ray.direction.z() < 0.0) depth = std::min(depth, -ray.origin.z() / ray.direction.z());
    points.push_back(ray.origin + depth * ray.direction);
  }
  return points;
}

// ---- libraries

/// PointSearch. When it is asked cold, the search is made within the time.
class OurPoints : public PointLibrary {
 public:
  OurPoints(const std::shared_ptr<const SceneModel>& model, Manner manner)
      : model_(model), manner_(manner), state_(model), search_(model) {}

  void ask(const BodyPoses& poses, const std::vector<Vector3d>& points, double threshold,
           std::vector<double>& distances) override {
    if (manner_ == Manner::Cold) search_ = PointSearch(model_);
    state_.set(poses);
    Question question;
    question.threshold = threshold;
    distances.clear();
    for (const PairProximity& answer : search_.closest(state_, {points}, question))
      distances.push_back(answer.result.distance);
  }

  double computedShare() const { return static_cast<double>(search_.counts().computed) / search_.counts().total; }

 private:
  const std::shared_ptr<const SceneModel> model_;
  const Manner manner_;
  State state_;
  PointSearch search_;
};

/// A library with its times [us] of a point, by round, and its last answers.
struct Run {
  std::string name;
  PointLibrary& library;
  const std::vector<Vector3d>& points;
  std::vector<double> times{}, distances{};
};

/// How far the answers of another one lie from ours, where both are outside and within the threshold.
json differencesOf(const std::vector<double>& ours, const std::vector<double>& others, double threshold) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < others.size(); ++i) {
    const double own = ours[kOthers * i];
    if (own > 0.0 && own < threshold && others[i] < threshold) differences.push_back(std::abs(own - others[i]));
  }
  return {{"points", differences.size()}, {"median", medianOf(differences)}, {"most", quantile(differences, 1.0)}};
}

json measurePoints(const std::string& row, const NamedRobot& robot, const std::vector<LinkMesh>& meshes,
                   const std::vector<Vector3d>& points, double threshold, Manner manner) {
  std::vector<Vector3d> fewer;
  for (std::size_t i = 0; i < points.size(); i += kOthers) fewer.push_back(points[i]);
  OurPoints ours(robot.model, manner);
  const std::unique_ptr<PointLibrary> fcl = fclPoints(meshes), tree = vertexTrees(meshes);
  std::vector<Run> runs{{"ours", ours, points}, {"FCL", *fcl, fewer}};
  if (tree) runs.push_back({"kd-tree", *tree, fewer});
  const auto posesOf = [&](int round) { return posesAfter(robot.model->robot, manner == Manner::Cold ? 0 : round); };
  for (int round = 0; round <= kRounds; ++round)
    for (Run& run : runs) {
      const BodyPoses poses = posesOf(round);
      const double all =
          processorTimeOf<std::micro>([&] { run.library.ask(poses, run.points, threshold, run.distances); });
      if (round > 0) run.times.push_back(all / static_cast<double>(run.points.size()));  // the first one warms up
    }
  json result = {{"row", row}, {"points", points.size()}, {"computed", ours.computedShare()}};
  const std::vector<double>& distances = runs.front().distances;
  const auto share = [&](double most) {
    const auto near =
        std::count_if(distances.begin(), distances.end(), [&](double distance) { return distance <= most; });
    return static_cast<double>(near) / static_cast<double>(distances.size());
  };
  result["near"] = share(kThreshold);
  result["inside"] = share(0.0);
  for (const Run& run : runs) {
    json entry = {{"library", run.name}, {"points", run.points.size()}, {"us", medianOf(run.times)}};
    if (&run != &runs.front()) entry["differences"] = differencesOf(distances, run.distances, threshold);
    result["libraries"].push_back(entry);
  }
  return result;
}

/// FCL has no rays.
json measureRays(const std::string& row, const NamedRobot& robot, const std::vector<Ray>& rays, Manner manner) {
  State state(robot.model);
  RaySearch search(robot.model);
  std::vector<double> times;
  std::size_t hits = 0;
  for (int round = 0; round <= kRounds; ++round) {
    const BodyPoses poses = posesAfter(robot.model->robot, manner == Manner::Cold ? 0 : round);
    hits = 0;
    const double all = processorTimeOf<std::micro>([&] {
      if (manner == Manner::Cold) search = RaySearch(robot.model);
      state.set(poses);
      for (const RayHit& hit : search.firstHits(state, rays)) hits += hit.shape.kind() != ShapeRef::Kind::None;
    });
    if (round > 0) times.push_back(all / static_cast<double>(rays.size()));
  }
  return {{"row", row},
          {"rays", rays.size()},
          {"hits", static_cast<double>(hits) / static_cast<double>(rays.size())},
          {"us", medianOf(times)}};
}

json measure(int count, const Wanted& wanted) {
  json result = {{"rounds", kRounds}, {"others", kOthers}, {"clouds", json::array()}, {"rays", json::array()}};
  std::optional<NamedRobot> panda;
  std::vector<LinkMesh> meshes;
  const auto isFound = [&] {
    if (panda) return true;
    panda = exampleRobot(kExampleRobots[0]);
    if (panda) meshes = linkMeshes(panda->model->robot, exampleRobotsResolver());
    if (!panda) std::cout << "Panda is left out. " << kExampleRobotsMissing << "\n";
    return panda.has_value();
  };
  const std::pair<const char*, std::vector<Vector3d>> clouds[] = {
      {"4 m around", cloudAround(Vector3d::Zero(), 2.0, count)},
      {"1 m around", cloudAround({0.3, 0.0, 0.5}, 0.5, count)},
      {"camera", cloudOfCamera(count)}};
  for (const auto& [cloud, points] : clouds)
    for (const auto& [name, threshold] : kThresholds)
      for (const auto& [manner_name, manner] : kManners) {
        const std::string row = std::string(cloud) + ", " + name + ", " + manner_name;
        if (!wanted(row) || !isFound()) continue;
        result["clouds"].push_back(measurePoints(row, *panda, meshes, points, threshold, manner));
        showProgress();
      }
  for (const auto& [manner_name, manner] : kManners) {
    const std::string row = std::string("rays of a camera, ") + manner_name;
    if (!wanted(row) || !isFound()) continue;
    result["rays"].push_back(measureRays(row, *panda, raysOfCamera(count), manner));
    showProgress();
  }
  return result;
}

}  // namespace
}  // namespace proximity_server::benchmark

int main(int argc, char** argv) {
  using namespace proximity_server::benchmark;
  proximity_server::tools::ProgramOptions program("points_benchmark", "Points and rays around a Panda");
  int count = 100000;
  addPositive(program, "--points", count, "points of a cloud, and rays");
  return benchmarkMain(program, argc, argv, [&](const Wanted& wanted) { return measure(count, wanted); });
}
