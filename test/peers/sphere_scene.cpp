#include "peers/sphere_scene.h"

#include "oracle/oracle.h"
#include "peers/robots.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace proximity_server::peers {

using namespace narrowphase;
using namespace scene;
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Sphere = SphereScene::Sphere;

constexpr int kDirections = 200;  // samples of a piece
constexpr int kRounds = 10;       // of k-means
constexpr int kPulls = 100;       // of an enclosing sphere

/// Returns one of kDirections that are spread evenly over the sphere (Fibonacci's lattice).
Vector3d directionOf(int number) {
  const double z = 1.0 - (2.0 * number + 1.0) / kDirections, turn = 2.399963229728653 * number;
  const double radial = std::sqrt(1.0 - z * z);
  return {radial * std::cos(turn), radial * std::sin(turn), z};
}

/// Returns the distance from the centre [m] at which a ray leaves a shape.
double rayLength(const Shape& shape, const Vector3d& direction) {
  double inside = 0.0, outside = 2.0 * (shape.coreRadius() + shape.margin()) + 1e-9;
  if (shape.kind() == Shape::Kind::Hull && shape.margin() == 0.0 && shape.hull().dimension() == 3) {
    const std::vector<Vector3d>& vertices = shape.hull().vertices();
    for (const auto& [i, j, k] : shape.hull().triangles()) {
      const Vector3d& p = vertices[i];
      const Vector3d normal = (vertices[j] - p).cross(vertices[k] - p);
      const double speed = normal.dot(direction);
      if (speed > 0.0) outside = std::min(outside, normal.dot(p - shape.centre()) / speed);
    }
    return outside;
  }
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (inside + outside);
    (outsideByAtMost(shape, shape.centre() + middle * direction) <= 0.0L ? inside : outside) = middle;
  }
  return inside;
}

std::vector<Vector3d> samplesOf(const RobotModel& robot, int link) {
  std::vector<Vector3d> samples;
  for (const Piece* piece : piecesOfLink(robot, link)) {
    const Shape& shape = piece->shape;
    for (int i = 0; i < kDirections; ++i)
      samples.push_back(piece->body_T_piece * (shape.centre() + rayLength(shape, directionOf(i)) * directionOf(i)));
    if (shape.kind() == Shape::Kind::Hull)
      for (const Vector3d& vertex : shape.hull().vertices()) samples.push_back(piece->body_T_piece * vertex);
  }
  return samples;
}

/// Returns a small sphere around the points: its centre is pulled towards the farthest one, each time less (Badoiu,
/// Clarkson, 2003).
Sphere around(const std::vector<Vector3d>& points) {
  Vector3d centre = Vector3d::Zero();
  for (const Vector3d& point : points) centre += point / static_cast<double>(points.size());
  const auto farthest = [&] {
    return *std::max_element(points.begin(), points.end(), [&](const Vector3d& p, const Vector3d& q) {
      return (p - centre).squaredNorm() < (q - centre).squaredNorm();
    });
  };
  for (int i = 1; i <= kPulls; ++i) centre += (farthest() - centre) / (i + 1.0);
  return {centre, (farthest() - centre).norm()};
}

/// Returns so many spheres around clusters of the samples.
std::vector<Sphere> spheresAround(const std::vector<Vector3d>& samples, int count) {
  std::vector<Vector3d> centres{samples.front()};
  std::vector<double> gaps(samples.size(), kInfinity);  // squared, to the nearest centre
  while (static_cast<int>(centres.size()) < count) {
    for (std::size_t i = 0; i < samples.size(); ++i)
      gaps[i] = std::min(gaps[i], (samples[i] - centres.back()).squaredNorm());
    centres.push_back(samples[std::max_element(gaps.begin(), gaps.end()) - gaps.begin()]);
  }
  std::vector<std::vector<Vector3d>> clusters;
  for (int round = 0; round < kRounds; ++round) {
    clusters.assign(centres.size(), {});
    for (const Vector3d& sample : samples) {
      const auto nearest = std::min_element(centres.begin(), centres.end(), [&](const Vector3d& p, const Vector3d& q) {
        return (p - sample).squaredNorm() < (q - sample).squaredNorm();
      });
      clusters[nearest - centres.begin()].push_back(sample);
    }
    for (std::size_t i = 0; i < centres.size(); ++i) {
      if (clusters[i].empty()) continue;
      centres[i].setZero();
      for (const Vector3d& sample : clusters[i]) centres[i] += sample / static_cast<double>(clusters[i].size());
    }
  }
  std::vector<Sphere> spheres;
  for (const std::vector<Vector3d>& cluster : clusters)
    if (!cluster.empty()) spheres.push_back(around(cluster));
  return spheres;
}

/// The spheres of a link, as far as they are fitted.
struct Fit {
  int link;
  std::vector<Vector3d> samples;
  std::vector<Sphere> spheres{};

  double largest() const {
    double radius = 0.0;
    for (const Sphere& sphere : spheres) radius = std::max(radius, sphere.radius);
    return radius;
  }
};

std::vector<Fit> fitted(const RobotModel& robot, const std::vector<int>& links) {
  std::vector<Fit> fits;
  for (const int link : links) {
    fits.push_back({link, samplesOf(robot, link)});
    fits.back().spheres = spheresAround(fits.back().samples, 1);
  }
  const std::size_t most = SphereScene::kSpheresPerLink * links.size();
  for (std::size_t count = links.size(); count < most; ++count) {
    Fit& next = *std::max_element(fits.begin(), fits.end(),
                                  [](const Fit& a, const Fit& b) { return a.largest() < b.largest(); });
    next.spheres = spheresAround(next.samples, static_cast<int>(next.spheres.size()) + 1);
  }
  return fits;
}

Matrix3d crossMatrix(const Vector3d& v) {
  Matrix3d cross;
  cross << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return cross;
}

}  // namespace

SphereScene::SphereScene(const SceneModel& model)
    : candidates_(linksOfCandidates(model.pairs)),
      links_(model.robot.links.size()),
      rotations_(model.robot.bodies.size(), Matrix3d::Identity()),
      origins_(model.robot.bodies.size(), Vector3d::Zero()) {
  addSteps(model.robot);
  addLinks(model.robot);
}

void SphereScene::addSteps(const RobotModel& robot) {
  for (const Body& body : robot.bodies) {
    Step step{
        body.parent,      -1,   1.0, 0.0, Matrix3d::Identity(), Matrix3d::Zero(), Matrix3d::Zero(), Vector3d::Zero(),
        Vector3d::Zero(), false};
    if (body.joint >= 0) {
      const Joint& joint = robot.joints[body.joint];
      if (!hasOnePosition(joint)) throw std::invalid_argument("joint " + joint.name + " has more than one position");
      const Eigen::Isometry3d fixed = robot.links[joint.parent_link].body_T_link * joint.parent_T_joint;
      const Joint::Mimic leader = robot.leaderOf(body.joint);
      step.joint = leader.joint;
      step.multiplier = leader.multiplier;
      step.offset = leader.offset;
      step.origin = fixed.translation();
      step.turns = joint.type != Joint::Type::Prismatic;
      step.constant = fixed.linear();
      if (step.turns) {
        const Matrix3d along = joint.axis * joint.axis.transpose();
        step.constant = fixed.linear() * along;
        step.even = fixed.linear() * (Matrix3d::Identity() - along);
        step.odd = fixed.linear() * crossMatrix(joint.axis);
      } else {
        step.slide = fixed.linear() * joint.axis;
      }
    }
    steps_.push_back(step);
  }
}

void SphereScene::addLinks(const RobotModel& robot) {
  std::vector<int> needed;
  for (const auto& [a, b] : candidates_) {
    needed.push_back(a);
    needed.push_back(b);
  }
  std::sort(needed.begin(), needed.end());
  needed.erase(std::unique(needed.begin(), needed.end()), needed.end());
  for (const Fit& fit : fitted(robot, needed)) {
    LinkSpheres& link = links_[fit.link];
    link.body = robot.links[fit.link].body;
    link.around = spheresAround(fit.samples, 1).front();
    for (const Sphere& sphere : fit.spheres)  // the spheres stick out of the samples
      link.around.radius = std::max(link.around.radius, (sphere.centre - link.around.centre).norm() + sphere.radius);
    link.begin = spheres_.size();
    spheres_.insert(spheres_.end(), fit.spheres.begin(), fit.spheres.end());
    link.end = spheres_.size();
  }
  centres_.resize(spheres_.size());
}

std::vector<SphereScene::Sphere> SphereScene::spheresOf(int link) const {
  const LinkSpheres& found = links_[link];
  return {spheres_.begin() + static_cast<std::ptrdiff_t>(found.begin),
          spheres_.begin() + static_cast<std::ptrdiff_t>(found.end)};
}

void SphereScene::place(const double* positions, std::ptrdiff_t stride) {
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const Step& step = steps_[i];
    if (step.parent < 0) continue;
    const auto parent = static_cast<std::size_t>(step.parent);
    const double position = step.offset + step.multiplier * positions[step.joint * stride];
    if (step.turns) {
      const Matrix3d rotation = step.constant + std::cos(position) * step.even + std::sin(position) * step.odd;
      rotations_[i].noalias() = rotations_[parent] * rotation;
      origins_[i] = origins_[parent] + rotations_[parent] * step.origin;
    } else {
      rotations_[i].noalias() = rotations_[parent] * step.constant;
      origins_[i] = origins_[parent] + rotations_[parent] * (step.origin + position * step.slide);
    }
  }
  for (LinkSpheres& link : links_) {
    if (link.body < 0) continue;
    const auto body = static_cast<std::size_t>(link.body);
    link.centre = origins_[body] + rotations_[body] * link.around.centre;
    link.is_placed = false;
  }
}

void SphereScene::placeSpheres(LinkSpheres& link) {
  if (link.is_placed) return;
  const auto body = static_cast<std::size_t>(link.body);
  for (std::size_t i = link.begin; i < link.end; ++i)
    centres_[i] = origins_[body] + rotations_[body] * spheres_[i].centre;
  link.is_placed = true;
}

/// Returns the gap [m] between the spheres around two links.
double SphereScene::gapAround(int pair) const {
  const auto [a, b] = candidates_[pair];
  const LinkSpheres &link_a = links_[a], &link_b = links_[b];
  return (link_a.centre - link_b.centre).norm() - link_a.around.radius - link_b.around.radius;
}

/// Returns the distance [m] of all spheres of two links; the search ends at a distance below `enough`.
double SphereScene::distanceOf(int pair, double enough) {
  const auto [a, b] = candidates_[pair];
  LinkSpheres &link_a = links_[a], &link_b = links_[b];
  placeSpheres(link_a);
  placeSpheres(link_b);
  double nearest = kInfinity;
  for (std::size_t i = link_a.begin; i < link_a.end; ++i)
    for (std::size_t j = link_b.begin; j < link_b.end; ++j) {
      const double radii = spheres_[i].radius + spheres_[j].radius, reach = nearest + radii;
      const double squared = (centres_[i] - centres_[j]).squaredNorm();
      if (reach <= 0.0 || squared >= reach * reach) continue;  // the root is taken of what is nearer only
      nearest = std::sqrt(squared) - radii;
      if (nearest < enough) return nearest;
    }
  return nearest;
}

bool SphereScene::anyBelow(double within) {
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const auto [a, b] = candidates_[i];
    const LinkSpheres &link_a = links_[a], &link_b = links_[b];
    const double reach = link_a.around.radius + link_b.around.radius + within;
    if ((link_a.centre - link_b.centre).squaredNorm() > reach * reach) continue;
    if (distanceOf(static_cast<int>(i), within) < within) return true;
  }
  return false;
}

/// Takes a pair into the sorted list if it is among the `most` nearest.
void SphereScene::offer(std::size_t pair, std::size_t most) {
  const double farthest = list_.size() < most ? kInfinity : list_.back().distance;
  if (gaps_[pair] >= farthest) return;
  const PairDistance found{static_cast<int>(pair), distanceOf(static_cast<int>(pair), -kInfinity)};
  if (found.distance >= farthest) return;
  if (list_.size() == most) list_.pop_back();
  list_.insert(std::upper_bound(list_.begin(), list_.end(), found, isNearer), found);
}

PairDistance SphereScene::minimum() {
  closest(1);
  return list_.front();
}

const std::vector<PairDistance>& SphereScene::closest(std::size_t most) {
  list_.clear();
  gaps_.resize(candidates_.size());
  for (std::size_t i = 0; i < candidates_.size(); ++i) gaps_[i] = gapAround(static_cast<int>(i));
  const auto first = static_cast<std::size_t>(std::min_element(gaps_.begin(), gaps_.end()) - gaps_.begin());
  offer(first, most);
  for (std::size_t i = 0; i < candidates_.size(); ++i)
    if (i != first) offer(i, most);
  return list_;
}

const std::vector<PairDistance>& SphereScene::below(double within) {
  list_.clear();
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    if (gapAround(static_cast<int>(i)) > within) continue;
    const PairDistance found{static_cast<int>(i), distanceOf(static_cast<int>(i), -kInfinity)};
    if (found.distance <= within) list_.push_back(found);
  }
  std::sort(list_.begin(), list_.end(), isNearer);
  return list_;
}

}  // namespace proximity_server::peers
