// ./dev stress points: points and rays around robots, each answer of which is held against the faces of all pieces.
#include "chance.h"
#include "oracle/oracle.h"
#include "proximity_server/scene/points/point_search.h"
#include "proximity_server/scene/points/ray_search.h"
#include "scene/bounds/bounds.h"
#include "scene/example_robots.h"
#include "scene/random_states.h"
#include "stress/campaign.h"
#include "stress/point_truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;
using narrowphase::Shape;
using narrowphase::Status;

constexpr int kPointsOfCell = 250;  // and as many rays
constexpr double kTolerance = 1e-9;
constexpr long double kMostOff = 1e-8L;  // [m] along a ray that does not graze

/// The robots of ./dev bench load, and that of ./dev demo.
constexpr struct {
  const char* name;
  const char* urdf;
} kRobots[] = {
    {"Demo", PROXIMITY_SOURCE_DIR "/config/demo/robot.urdf"},
    {"Panda", "package://example-robot-data/robots/panda_description/urdf/panda.urdf"},
    {"UR5", "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"},
    {"UR10", "package://example-robot-data/robots/ur_description/urdf/ur10_robot.urdf"},
    {"PR2", "package://example-robot-data/robots/pr2_description/urdf/pr2.urdf"},
    {"Solo12", "package://example-robot-data/robots/solo_description/robots/solo12.urdf"},
    {"HyQ", "package://example-robot-data/robots/hyq_description/robots/hyq_no_sensors.urdf"},
    {"Laikago", "package://example-robot-data/robots/laikago_description/urdf/laikago.urdf"},
    {"Allegro hand", "package://example-robot-data/robots/allegro_hand_description/urdf/allegro_left_hand.urdf"},
    {"Kinova", "package://example-robot-data/robots/kinova_description/robots/kinova.urdf"},
    {"Romeo", "package://example-robot-data/robots/romeo_description/urdf/romeo.urdf"},
    {"B1 with Z1", "package://example-robot-data/robots/b1_description/urdf/b1-z1.urdf"},
    {"Z1", "package://example-robot-data/robots/z1_description/urdf/z1.urdf"},
    {"Go2", "package://example-robot-data/robots/go2_description/urdf/go2.urdf"},
    {"Baxter", "package://example-robot-data/robots/baxter_description/urdf/baxter.urdf"},
    {"iCub", "package://example-robot-data/robots/icub_description/robots/icub.urdf"},
    {"Talos", "package://example-robot-data/robots/talos_data/robots/talos_reduced.urdf"},
    {"Tiago", "package://example-robot-data/robots/tiago_description/robots/tiago.urdf"},
    {"G1", "package://public_robots/g1/g1.urdf"},
    {"Gen3", "package://public_robots/gen3/gen3.urdf"},
    {"iiwa14", "package://public_robots/iiwa14/iiwa14.urdf"},
    {"IRB 6640", "package://public_robots/irb6640/irb6640.urdf"},
    {"Robotiq 3F", "package://public_robots/robotiq_3f/robotiq_3f.urdf"},
    {"Stretch SE3", "package://public_robots/stretch_se3/stretch_se3.urdf"},
    {"xArm7", "package://public_robots/xarm7/xarm7.urdf"},
};

/// Finds example robots, and the meshes of that of the demo, which are in this package.
MeshResolver resolver() {
  return [examples = exampleRobotsResolver(), own = packageResolver({PROXIMITY_SOURCE_DIR})](const std::string& uri) {
    return uri.find("//proximity_server/") == std::string::npos ? examples(uri) : own(uri);
  };
}

std::shared_ptr<const SceneModel> loadRobot(const std::string& urdf, const MeshResolver& resolve) {
  RobotModel robot = loadRobotModel(readFile(resolve(urdf)), resolve, quickLoading());
  PairTable pairs = filterPairs(robot, "");
  return std::make_shared<const SceneModel>(SceneModel{std::move(robot), std::move(pairs)});
}

/// A robot that is loaded when it is asked for first.
class LazyRobot {
 public:
  LazyRobot(const char* name, const char* urdf) : name_(name), urdf_(urdf) {}

  const std::string& name() const { return name_; }

  /// The state of one caller.
  State state() {
    load();
    const std::lock_guard<std::mutex> lock(mutex_);
    return state_->forAnotherThread();
  }
  const std::vector<OraclePiece>& pieces() {
    load();
    return pieces_;
  }

 private:
  void load() {
    std::call_once(once_, [&] {
      state_.emplace(loadRobot(urdf_, resolver()));
      pieces_ = oraclePiecesOf(state_->robot());
    });
  }

  const std::string name_, urdf_;
  std::once_flag once_;
  std::mutex mutex_;
  std::optional<State> state_;
  std::vector<OraclePiece> pieces_;
};

bool isFound(const MeshResolver& resolve, const char* urdf) {
  try {
    resolve(urdf);
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

std::vector<std::unique_ptr<LazyRobot>>& robots() {
  static std::vector<std::unique_ptr<LazyRobot>> found = [] {
    const MeshResolver resolve = resolver();
    std::vector<std::unique_ptr<LazyRobot>> all;
    for (const auto& [name, urdf] : kRobots)
      if (isFound(resolve, urdf) && (!kIsSanitized || all.size() < 2))  // the meshes of the others take minutes there
        all.push_back(std::make_unique<LazyRobot>(name, urdf));
    return all;
  }();
  return found;
}

std::string by(long double metres) {
  std::ostringstream text;
  text << " by " << static_cast<double>(metres) << " m";
  return text.str();
}

/// A robot in a random state with points and rays.
class PointCell {
 public:
  PointCell(LazyRobot& robot, Chance chance, stress::Tally& tally)
      : chance_(std::move(chance)),
        tally_(tally),
        pieces_(robot.pieces()),
        state_(robot.state()),
        poses_(somePoses()),
        truth_(pieces_, poses_) {
    state_.set(poses_);
    for (const OraclePiece& piece : pieces_)
      extent_ = std::max(extent_, (somePointOf(piece) - poses_.front()->translation()).norm());
  }

  void observe() {
    observePoints();
    observeRays();
  }

  std::string failure;  ///< says which promise is broken; empty: none

 private:
  const RobotModel& robot() const { return state_.robot(); }

  /// One robot in four stands up to 1e6 m from the origin.
  BodyPoses somePoses() {
    Eigen::Isometry3d root = chance_.pose(1.0);
    if (chance_.happens(0.25)) root.translation() *= chance_.decades(0, 6);
    return placedAt(robot(), forwardKinematics(robot(), randomPositions(robot(), chance_)), {root});
  }

  /// A point on the surface of a piece, in the frame of the poses: often on an edge or in a vertex.
  Vector3d somePointOf(const OraclePiece& of) {
    const Shape& shape = of.piece.shape;
    Vector3d point;
    if (shape.kind() == Shape::Kind::Hull && !shape.hull().triangles().empty()) {
      const std::array<int, 3>& triangle = chance_.oneOf(shape.hull().triangles());
      const int corners = 1 + chance_.below(3);
      double sum = 0.0;
      point.setZero();
      for (int i = 0; i < corners; ++i) {
        const double weight = chance_.between(0.01, 1);
        point += weight * shape.hull().vertices()[triangle[i]];
        sum += weight;
      }
      point /= sum;
    } else {
      const Vector3d direction = chance_.direction();
      point = coreSupport(shape, direction.cast<long double>()).cast<double>() + shape.margin() * direction;
    }
    return *poses_[of.body] * (of.piece.body_T_piece * point);
  }
  Vector3d somePointOfRobot() { return somePointOf(chance_.oneOf(pieces_)); }

  /// A point on, in or near a piece, around the robot, or up to 1e6 m away.
  Vector3d somePoint() {
    const OraclePiece& piece = chance_.oneOf(pieces_);
    const Vector3d on_piece = somePointOf(piece);
    switch (chance_.below(8)) {
      case 0:
        return on_piece;
      case 1:
      case 2:
        return on_piece + chance_.decades(-15, -1) * chance_.direction();
      case 3:
        return on_piece + chance_.between(0, 1) * (somePointOf(piece) - on_piece);
      case 4:
        return on_piece + chance_.decades(0, 6) * chance_.direction();
      default:
        return poses_.front()->translation() + chance_.between(0, 2) * extent_ * chance_.direction();
    }
  }

  /// [m] Of places around a point: that of the poses, once for the answer and once for the point that is looked at.
  double roundingAt(const Vector3d& point) const {
    return 2.0 * kPoseRounding * (point.norm() + (point - poses_.front()->translation()).norm() + 2.0 * extent_);
  }

  template <typename... Parts>
  void fail(const Parts&... parts) {
    if (!failure.empty()) return;
    std::ostringstream text;
    text.precision(17);
    (text << ... << parts);
    failure = text.str();
  }

  void observePoints() {
    Points points;
    for (int i = 0; i < kPointsOfCell; ++i) points.centres.push_back(somePoint());
    if (chance_.happens(0.3))
      for (int i = 0; i < kPointsOfCell; ++i)
        points.radii.push_back(chance_.happens(0.5) ? 0.0 : chance_.decades(-4, 6));
    Question question;
    if (chance_.happens(0.3)) question.threshold = chance_.happens(0.2) ? 0.0 : chance_.decades(-3, 1);
    PointSearch search(state_.sharedModel());
    const std::vector<PairProximity>& answers = search.closest(state_, points, question);
    for (std::size_t i = 0; i < answers.size() && failure.empty(); ++i)
      check(points.centres[i], points.radii.empty() ? 0.0 : points.radii[i], question, answers[i]);
  }

  void check(const Vector3d& point, double radius, const Question& question, const PairProximity& answer) {
    const PointTruth::Place truth = truth_.placeOf(point.cast<long double>());
    const long double low = truth.distance.low - radius, high = truth.distance.high - radius;
    const narrowphase::SignedDistance& result = answer.result;
    const auto failHere = [&](const auto&... parts) {
      fail("the point ", point.transpose(), " with the radius ", radius, parts..., "; the truth is ",
           static_cast<double>(low));
    };
    tally_.add("points");
    tally_.add("inside", truth.distance.high < 0);
    tally_.add("near", std::abs(truth.distance.low) < 1e-6L);
    tally_.add("in_mesh", truth.is_in_mesh);
    tally_.add("beyond", result.status == Status::Threshold);
    tally_.add("open", result.status != Status::Threshold && result.status != Status::Converged);
    if (result.status == Status::Unknown) return failHere(" is unknown");
    if (result.lower_bound > high)
      return failHere(" has a lower bound that is too large", by(result.lower_bound - high));
    if (result.upper_bound < low)
      return failHere(" has an upper bound that is too small", by(low - result.upper_bound));
    if (result.status == Status::Threshold) {
      if (!(result.lower_bound >= question.threshold)) failHere(" is not proven to be beyond ", question.threshold);
      return;
    }
    tally_.raise("widest", result.upper_bound - result.lower_bound);
    if (result.status == Status::Converged && !(result.upper_bound - result.lower_bound <= kTolerance))
      return failHere(" converged, but its bounds are apart", by(result.upper_bound - result.lower_bound));
    if (!answer.asked.a.isLink() || !result.has_points) return failHere(" has no link, or no points");
    checkPoints(point, radius, answer, failHere);
  }

  template <typename Fail>
  void checkPoints(const Vector3d& point, double radius, const PairProximity& answer, const Fail& failHere) {
    const narrowphase::SignedDistance& result = answer.result;
    const long double width = result.upper_bound - result.lower_bound,
                      rounding = roundingAt(point) + kPoseRounding * radius;
    const long double enough = std::max<long double>(kTolerance, width) + rounding;
    const DistanceBounds of_link = truth_.placeOf(point.cast<long double>(), answer.asked.a.link()).distance;
    if (of_link.low - radius > result.upper_bound + rounding)
      return failHere(" is not so near to the link that is named");
    const Vector3d on_ball = point - radius * result.normal;
    if ((result.point_b - on_ball).norm() > enough) return failHere(" has a point_b that is not on the ball");
    if (std::abs(result.normal.norm() - 1.0) > 1e-12) return failHere(" has a normal that is no unit vector");
    if (!(result.distance + radius > 0.0)) return;
    const DistanceBounds at_a = truth_.placeOf(result.point_a.cast<long double>(), answer.asked.a.link()).distance;
    if (at_a.low > enough || at_a.high < -enough) failHere(" has a point_a that is off the surface", by(at_a.low));
  }

  /// A ray to a point of the robot, along an edge of a piece, or anywhere.
  Ray someRay() {
    Ray ray;
    ray.origin = somePoint();
    const OraclePiece& piece = chance_.oneOf(pieces_);
    const Vector3d to = somePointOf(piece);
    switch (chance_.below(4)) {
      case 0:
        ray.direction = chance_.direction();
        break;
      case 1:
        ray.direction = to - somePointOf(piece);
        ray.origin = to - chance_.decades(-1, 1) * ray.direction;
        break;
      default:
        ray.direction = to - ray.origin;
    }
    if (!(ray.direction.norm() > 0.0)) ray.direction = Vector3d::UnitX();
    if (chance_.happens(0.5)) ray.range = chance_.between(0.5, 1.5) * std::max(1e-9, (to - ray.origin).norm());
    return ray;
  }

  void observeRays() {
    std::vector<Ray> rays;
    for (int i = 0; i < kPointsOfCell; ++i) rays.push_back(someRay());
    RaySearch search(state_.sharedModel());
    const std::vector<RayHit>& hits = search.firstHits(state_, rays);
    for (std::size_t i = 0; i < rays.size() && failure.empty(); ++i) check(rays[i], hits[i]);
  }

  void check(const Ray& ray, const RayHit& hit) {
    const Vector3l origin = ray.origin.cast<long double>(), direction = ray.direction.cast<long double>().normalized();
    const long double truth = truth_.firstHit(origin, direction);
    const bool is_hit = hit.shape.kind() != ShapeRef::Kind::None, is_open = hit.status != Status::Converged;
    const auto failHere = [&](const auto&... parts) {
      fail("the ray from ", ray.origin.transpose(), " along ", ray.direction.transpose(), " of length ", ray.range,
           parts..., "; it is free until ", hit.free, " and hits at ", hit.distance, ", the truth is ",
           static_cast<double>(truth));
    };
    tally_.add("rays");
    tally_.add("hits", is_hit);
    tally_.add("from_inside", is_hit && hit.distance == 0.0);
    tally_.add("rays_open", is_open);
    if (hit.status == Status::Unknown) return failHere(" is unknown");
    if (!(hit.free <= truth)) return failHere(" is not free", by(hit.free - truth));
    if (!(hit.free >= 0.0 && hit.free <= ray.range)) return failHere(" is free beyond its range");
    if (!is_hit) {
      if (!is_open && hit.free != ray.range) failHere(" hits nothing, but is not free");
      return;
    }
    if (!(hit.free <= hit.distance && hit.distance <= ray.range)) return failHere(" has a hit at a wrong place");
    checkHit(direction, hit, origin + hit.distance * direction, truth, failHere);
  }

  template <typename Fail>
  void checkHit(const Vector3l& direction, const RayHit& hit, const Vector3l& place, long double truth,
                const Fail& failHere) {
    const long double rounding =
        roundingAt(place.cast<double>()) + roundingAt((place - hit.distance * direction).cast<double>());
    const long double enough = kTolerance + rounding;
    const DistanceBounds of_link = truth_.placeOf(place, hit.shape.link()).distance;
    if (of_link.low > enough) return failHere(" has no surface at its hit", by(of_link.low));
    if (hit.distance > 0.0 && truth_.placeOf(place).distance.high < -enough) return failHere(" passes a surface");
    if (std::abs(hit.normal.norm() - 1.0) > 1e-12) return failHere(" has a normal that is no unit vector");
    const long double off = std::abs(hit.distance - truth);
    // A ray that begins on a surface may lead away from it.
    if (hit.distance == 0.0 || off <= kMostOff + 10 * rounding) return;
    tally_.add("grazing");
    if (!truth_.grazes(place, direction, enough)) failHere(" is off", by(off));
  }

  Chance chance_;
  stress::Tally& tally_;
  const std::vector<OraclePiece>& pieces_;
  State state_;
  const BodyPoses poses_;
  const PointTruth truth_;
  double extent_ = 0.0;  ///< [m] about as far as the robot reaches from its root
};

void askCell(const stress::Part& part, stress::Tally& tally) {
  const stress::Stopwatch watch;
  PointCell cell(*robots()[part.family], Chance(part.seed, part.family, part.number), tally);
  cell.observe();
  tally.add("seconds", watch.seconds());
  if (!cell.failure.empty()) tally.fail({part.number, cell.failure, {}});
}

}  // namespace
}  // namespace proximity_server::scene

namespace proximity_server::stress {

Campaign pointCampaign() {
  Campaign campaign{"point_stress", "Looks for points and rays around robots whose answers are wrong.", "points",
                    "cell"};
  campaign.option = "--points";
  campaign.usual = 1000000;
  campaign.cases_of_part = scene::kPointsOfCell;
  campaign.record_file = "recorded_points.jsonl";
  for (const std::unique_ptr<scene::LazyRobot>& robot : scene::robots()) campaign.families.push_back({robot->name()});
  campaign.ask = scene::askCell;
  campaign.name_width = 12;
  campaign.columns = {count("points", 8, "points"),
                      count("inside", 8, "inside"),
                      count("in mesh", 8, "in_mesh"),
                      count("near", 8, "near"),
                      count("beyond", 8, "beyond"),
                      count("open", 7, "open"),
                      number("widest", 8, "%*.0e", "widest"),
                      count("rays", 8, "rays"),
                      count("hits", 8, "hits"),
                      count("from in", 8, "from_inside"),
                      count("grazing", 8, "grazing"),
                      count("open", 7, "rays_open"),
                      ratio("us", 7, "%*.0f", "seconds", "points", 1e6),
                      failures(8)};
  campaign.legend =
      "inside: points in a link; in mesh: where no piece is, or not the deepest; near: a surface, by 1e-6 m; beyond: "
      "a\n"
      "threshold; open: not converged; widest: the bounds [m]; from in: rays that begin in a link; grazing: hits that\n"
      "are not where the first piece is met, but near a piece; us: time of a point and a ray, truth included. A "
      "failure\n"
      "ends its cell, which is one state.";
  return campaign;
}

}  // namespace proximity_server::stress
