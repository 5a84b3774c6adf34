#include "tools/pair_audit/separation_proof.h"

#include "proximity_server/scene/model/kinematics.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace proximity_server::tools {
namespace {

using Eigen::Vector3d;

constexpr int kMaxQueries = 10000;  // for one pair

/// One joint on the path from link a to link b. On either side of it a point of the body is fixed to the joint's
/// origin. A revolute joint leaves the two points together; a prismatic joint separates them by its position.
struct Hinge {
  int joint;
  Vector3d near, far;  ///< the point on the side of a, and on that of b, each in the frame of its body
  double slide;        ///< [m] the largest distance of the two points
};

/// [rad] or [m] The largest position of a joint, in either direction, over the range of its leader.
double largestPosition(const scene::RobotModel& robot, int joint, const std::vector<scene::JointRange>& ranges) {
  const scene::Joint::Mimic leader = robot.leaderOf(joint);
  const auto range = std::find_if(ranges.begin(), ranges.end(),
                                  [&](const scene::JointRange& each) { return each.joint == leader.joint; });
  if (range == ranges.end()) return 0.0;  // floating and planar joints stay at the identity
  return std::max(std::abs(leader.offset + leader.multiplier * range->lower),
                  std::abs(leader.offset + leader.multiplier * range->upper));
}

std::vector<Hinge> hingesBetween(const scene::RobotModel& robot, const std::vector<scene::JointRange>& ranges,
                                 const scene::ShapeRefPair& pair) {
  std::vector<Hinge> hinges;
  int body = robot.links[pair.a.link()].body;
  for (const int index : scene::jointsBetween(robot, body, robot.links[pair.b.link()].body)) {
    const scene::Joint& joint = robot.joints[index];
    const bool upwards = robot.bodies[body].joint == index;
    const scene::Link& parent = robot.links[joint.parent_link];
    const Vector3d in_parent = parent.body_T_link * joint.parent_T_joint.translation();
    const Vector3d in_child = Vector3d::Zero();  // the frame of a body is that of the joint that carries it
    const double slide = joint.type == scene::Joint::Type::Prismatic ? largestPosition(robot, index, ranges) : 0.0;
    hinges.push_back({index, upwards ? in_child : in_parent, upwards ? in_parent : in_child, slide});
    body = upwards ? parent.body : robot.links[joint.child_link].body;
  }
  return hinges;
}

/// For each hinge an upper bound [m] of the reach of the link at the far end of the chain, for any positions of the
/// hinges behind it.
std::vector<double> reachesBehind(const std::vector<Hinge>& hinges, const scene::RobotModel& robot, int link) {
  std::vector<double> reaches(hinges.size());
  for (std::size_t i = hinges.size(); i-- > 0;) {
    const bool is_last = i + 1 == hinges.size();
    reaches[i] = is_last ? robot.reachOf(link, hinges[i].far)
                         : (hinges[i + 1].near - hinges[i].far).norm() + hinges[i + 1].slide + reaches[i + 1];
  }
  return reaches;
}

std::vector<Hinge> reversed(const std::vector<Hinge>& hinges) {
  std::vector<Hinge> result(hinges.rbegin(), hinges.rend());
  for (Hinge& hinge : result) std::swap(hinge.near, hinge.far);
  return result;
}

/// A box of positions around a centre.
struct Cell {
  std::vector<double> centre, half;  ///< by index of the range
  double lower_bound;                ///< [m] of the signed distance in the cell
  bool operator<(const Cell& other) const { return lower_bound > other.lower_bound; }  // the smallest is on top
};

/// The subdivision of the box of a pair's joints.
class Subdivision {
 public:
  Subdivision(scene::Scene& scene, const std::vector<scene::JointRange>& ranges, const scene::ShapeRefPair& pair,
              double near)
      : scene_(scene),
        ranges_(ranges),
        pair_(pair),
        near_(near),
        sensitivities_(sensitivities(scene.model().robot, ranges, pair)),
        positions_(scene.model().robot.joints.size(), 0.0) {}

  SeparationProof run() {
    Cell box{{}, {}, 0.0};
    for (const scene::JointRange& range : ranges_) {
      box.centre.push_back(0.5 * (range.lower + range.upper));
      box.half.push_back(0.5 * range.width());
    }
    add(box);
    if (cellsNeeded() > kMaxQueries) return result();
    while (!found_ && queries_ < kMaxQueries && cells_.top().lower_bound < 0.5 * (near_ + smallest_)) halveWorst();
    return result();
  }

 private:
  void add(Cell cell) {
    for (std::size_t i = 0; i < ranges_.size(); ++i) positions_[ranges_[i].joint] = cell.centre[i];
    scene_.update(scene::forwardKinematics(scene_.model().robot, positions_));
    scene::Question question;
    question.depth = scene::Question::Depth::NotWanted;
    const narrowphase::SignedDistance answer = scene_.proximity(pair_, question).result;
    ++queries_;
    if (!(answer.lower_bound > near_)) found_ = positions_;
    smallest_ = std::min(smallest_, answer.lower_bound);
    cell.lower_bound = answer.lower_bound;
    for (std::size_t i = 0; i < ranges_.size(); ++i) cell.lower_bound -= sensitivities_[i] * cell.half[i];
    cells_.push(std::move(cell));
  }

  void halveWorst() {
    Cell cell = cells_.top();
    cells_.pop();
    std::size_t widest = 0;
    for (std::size_t i = 1; i < ranges_.size(); ++i) {
      if (sensitivities_[i] * cell.half[i] > sensitivities_[widest] * cell.half[widest]) widest = i;
    }
    cell.half[widest] *= 0.5;
    cell.centre[widest] -= cell.half[widest];
    add(cell);
    cell.centre[widest] += 2.0 * cell.half[widest];
    add(cell);
  }

  /// A lower estimate of the number of cells, as if the distance at the centre of the box held everywhere. A settled
  /// cell has sum(sensitivity * half width) <= distance - near, so its volume is largest if all terms are equal.
  double cellsNeeded() const {
    double cells = 1.0;
    const double distance = smallest_ - near_, joints = static_cast<double>(ranges_.size());
    for (std::size_t i = 0; i < ranges_.size(); ++i) {
      cells *= sensitivities_[i] * ranges_[i].width() * joints / (2.0 * distance);
    }
    return cells;
  }

  SeparationProof result() const { return {cells_.top().lower_bound, found_}; }

  scene::Scene& scene_;
  const std::vector<scene::JointRange>& ranges_;
  const scene::ShapeRefPair pair_;
  const double near_;
  const std::vector<double> sensitivities_;
  scene::Positions positions_;
  std::priority_queue<Cell> cells_;
  int queries_ = 0;
  double smallest_ = std::numeric_limits<double>::infinity();  // [m] the smallest distance found
  std::optional<scene::Positions> found_;
};

}  // namespace

std::vector<double> sensitivities(const scene::RobotModel& robot, const std::vector<scene::JointRange>& ranges,
                                  const scene::ShapeRefPair& pair) {
  const std::vector<Hinge> hinges = hingesBetween(robot, ranges, pair);
  const std::vector<double> to_b = reachesBehind(hinges, robot, pair.b.link());
  std::vector<double> to_a = reachesBehind(reversed(hinges), robot, pair.a.link());
  std::reverse(to_a.begin(), to_a.end());

  std::vector<double> result(ranges.size(), 0.0);
  for (std::size_t i = 0; i < hinges.size(); ++i) {
    const scene::Joint::Mimic leader = robot.leaderOf(hinges[i].joint);
    const bool slides = robot.joints[hinges[i].joint].type == scene::Joint::Type::Prismatic;
    for (std::size_t k = 0; k < ranges.size(); ++k) {
      if (ranges[k].joint != leader.joint) continue;
      result[k] += std::abs(leader.multiplier) * (slides ? 1.0 : std::min(to_a[i], to_b[i]));
    }
  }
  return result;
}

SeparationProof proveSeparation(scene::Scene& scene, const std::vector<scene::JointRange>& ranges,
                                const scene::ShapeRefPair& pair, double near) {
  return Subdivision(scene, ranges, pair, near).run();
}

}  // namespace proximity_server::tools
