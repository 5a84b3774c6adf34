#include "peers/fcl_scene.h"

#include "peers/aborts.h"
#include "peers/robots.h"
#include "proximity_server/scene/model/kinematics.h"
#include "scene/model/numbers.h"
#include "scene/objects/placed_object.h"
#include "tools/second_opinion/fcl_shape.h"

#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <stdexcept>

namespace proximity_server::peers {

using namespace narrowphase;
using namespace scene;
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

const Vector3d kFirstGuess(1.0, 0.0, 0.0);  // FCL's own

}  // namespace

FclScene::FclScene(const SceneModel& model, Method method, const Objects* objects)
    : method_(method),
      links_(model.robot.links.size()),
      parts_of_link_(links_),
      candidates_(linksOfCandidates(model.pairs)),
      candidate_of_(links_ * links_, -1) {
  std::vector<bool> is_needed(links_, false);
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const auto a = static_cast<std::size_t>(candidates_[i].first), b = static_cast<std::size_t>(candidates_[i].second);
    candidate_of_[a * links_ + b] = candidate_of_[b * links_ + a] = static_cast<int>(i);
    is_needed[a] = is_needed[b] = true;
  }
  const bool has_objects = objects != nullptr && !objects->empty();
  for (std::size_t link = 0; link < links_; ++link)
    if (is_needed[link] || (has_objects && model.robot.hasGeometry(static_cast<int>(link))))
      addLink(model.robot, static_cast<int>(link));
  if (has_objects) addObjects(*objects);
  if (method == Method::HullsIndep) guesses_.assign(parts_.size() * parts_.size(), kFirstGuess);
  std::vector<fcl::CollisionObjectd*> of_objects;
  for (Part& part : parts_) {
    part.object->setUserData(&part);
    if (part.body >= 0)
      manager_.registerObject(part.object.get());
    else
      of_objects.push_back(part.object.get());
  }
  manager_.setup();
  if (of_objects.empty()) return;
  environment_.registerObjects(of_objects);
  environment_.setup();
}

void FclScene::addObjects(const Objects& objects) {
  objects_ = static_cast<std::size_t>(objects.numberLimit());
  is_checked_.assign(links_ * objects_, false);
  parts_of_link_.resize(links_ + objects_);
  for (const int number : objects.numbers()) {
    for (std::size_t link = 0; link < links_; ++link)
      is_checked_[link * objects_ + static_cast<std::size_t>(number)] =
          objects.isChecked(static_cast<int>(link), ShapeRef::ofObject(number));
    const PlacedObject& object = *objects.placed(number);
    std::vector<const Piece*> pieces;
    for (const Piece& piece : object.geometry->pieces()) pieces.push_back(&piece);
    const std::size_t first = parts_.size();
    addPieces(pieces, static_cast<int>(links_) + number, -1, object.world_T_object);
    for (std::size_t i = first; i < parts_.size(); ++i) {
      parts_[i].object->setTransform(parts_[i].body_T_part);
      parts_[i].object->computeAABB();
    }
  }
}

bool FclScene::goesAsTriangles(const Shape& shape) const {
  if (shape.margin() != 0.0) return false;
  if (shape.kind() == Shape::Kind::Hull && shape.hull().dimension() < 3) return true;
  return method_ == Method::Triangles && (shape.kind() == Shape::Kind::Hull || shape.kind() == Shape::Kind::Box);
}

void FclScene::addLink(const RobotModel& robot, int link) {
  try {
    addPieces(piecesOfLink(robot, link), link, robot.links[link].body, Isometry3d::Identity());
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("link " + robot.links[link].name + ": " + error.what());
  }
}

void FclScene::addPieces(const std::vector<const Piece*>& pieces, int link, int body,
                         const Isometry3d& frame_T_pieces) {
  const auto mesh = std::make_shared<tools::FclMesh>();
  mesh->beginModel();
  bool has_triangles = false;
  for (const Piece* piece : pieces) {
    if (goesAsTriangles(piece->shape)) {
      tools::addTriangles(*mesh, piece->shape, piece->body_T_piece);
      has_triangles = true;
    } else {
      addPart(link, body, frame_T_pieces * piece->body_T_piece, tools::fclShape(piece->shape));
    }
  }
  if (!has_triangles) return;
  mesh->endModel();
  addPart(link, body, frame_T_pieces, mesh);
}

void FclScene::addPart(int link, int body, const Isometry3d& body_T_part,
                       const std::shared_ptr<fcl::CollisionGeometryd>& geometry) {
  parts_of_link_[link].push_back(parts_.size());
  parts_.push_back({link, body, body_T_part, std::make_unique<fcl::CollisionObjectd>(geometry)});
}

void FclScene::update(const BodyPoses& poses) {
  for (Part& part : parts_) {
    if (part.body < 0) continue;
    part.object->setTransform(*poses[part.body] * part.body_T_part);
    part.object->computeAABB();
  }
  manager_.update();
}

void FclScene::ask(const BodyPoses& poses, SceneQuestion question) {
  update(poses);
  question_ = question;
  answer_.clear();
  is_any_below_ = false;
  if (question == SceneQuestion::All) return askEach();
  if (question == SceneQuestion::Contact) return askFirstContact();
  if (question == SceneQuestion::Below) within_.assign(candidates_.size() + is_checked_.size(), kInfinity);
  // Only the search among objects begins with the parts that were the nearest the last time: robots alone were measured
  // without.
  if (question == SceneQuestion::Minimum && objects_ > 0 && nearest_parts_)
    offer(nearest_parts_->first, nearest_parts_->second);
  manager_.distance(this, visit);
  if (objects_ > 0 && !isDone()) manager_.distance(&environment_, this, visit);
  if (question != SceneQuestion::Below) return;
  for (std::size_t i = 0; i < within_.size(); ++i)
    if (within_[i] < kInfinity) answer_.push_back({static_cast<int>(i), within_[i]});
}

void FclScene::giveAnswer(SceneAnswer& answer) const {
  answer.is_below = is_any_below_;
  answer.pairs = answer_;
  if (question_ == SceneQuestion::Below) std::sort(answer.pairs.begin(), answer.pairs.end(), isNearer);
}

/// Called for each two parts whose boxes are no farther apart than `reach`. Returns whether the search ends.
bool FclScene::visit(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* self, double& reach) {
  auto& scene = *static_cast<FclScene*>(self);
  scene.offer(scene.indexOf(*a), scene.indexOf(*b));
  reach = std::min(reach, scene.reach());
  return scene.isDone();
}

void FclScene::askFirstContact() {
  if (nearest_parts_) offerToContact(nearest_parts_->first, nearest_parts_->second);
  if (answer_.empty()) manager_.collide(this, visitTouching);
  if (answer_.empty() && objects_ > 0) manager_.collide(&environment_, this, visitTouching);
}

/// Called for each two parts whose boxes overlap. Returns whether the search ends.
bool FclScene::visitTouching(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* self) {
  auto& scene = *static_cast<FclScene*>(self);
  scene.offerToContact(scene.indexOf(*a), scene.indexOf(*b));
  return !scene.answer_.empty();
}

/// Keeps two parts of a candidate pair if they overlap.
void FclScene::offerToContact(std::size_t a, std::size_t b) {
  const int candidate = candidateOf(parts_[a].link, parts_[b].link);
  if (candidate < 0) return;
  const std::optional<double> contacts = answerOf([&] {
    fcl::CollisionResultd result;
    return static_cast<double>(
        fcl::collide(parts_[a].object.get(), parts_[b].object.get(), fcl::CollisionRequestd(), result));
  });
  if (!contacts) ++failures_;
  if (!contacts || *contacts == 0.0) return;
  answer_.push_back({candidate, 0.0});
  nearest_parts_ = {a, b};
}

/// Returns how near [m] two parts must be to change the answer.
double FclScene::reach() const {
  if (question_ == SceneQuestion::AnyBelow || question_ == SceneQuestion::Below) return kBelow;
  return answer_.size() == most() ? std::max(answer_.back().distance, 0.0) : kInfinity;
}

/// The search for the minimum ends at an overlap, as FCL's users let it.
bool FclScene::isDone() const {
  if (question_ == SceneQuestion::Minimum) return !answer_.empty() && answer_.front().distance <= 0.0;
  return is_any_below_;
}

/// Measures two parts of a candidate pair, no farther than what would change the answer.
void FclScene::offer(std::size_t a, std::size_t b) {
  const int candidate = candidateOf(parts_[a].link, parts_[b].link);
  if (candidate < 0) return;
  if (question_ == SceneQuestion::AnyBelow) {
    is_any_below_ = measure(a, b, kBelow) < kBelow;
  } else if (question_ == SceneQuestion::Below) {
    double& within = within_[candidate];
    const double bound = std::min(within, kBelow), distance = measure(a, b, bound);
    if (distance < bound) within = distance;
  } else {
    offerToClosest(candidate, a, b);
  }
}

/// Keeps the list sorted; only the nearest two parts of a pair count.
void FclScene::offerToClosest(int candidate, std::size_t a, std::size_t b) {
  const auto known =
      std::find_if(answer_.begin(), answer_.end(), [&](const PairDistance& p) { return p.pair == candidate; });
  const double farthest = answer_.size() < most() ? kInfinity : answer_.back().distance;
  const double bound = known != answer_.end() ? known->distance : farthest;
  const PairDistance found{candidate, measure(a, b, bound)};
  if (!(found.distance < bound)) return;
  if (known != answer_.end())
    answer_.erase(known);
  else if (answer_.size() == most())
    answer_.pop_back();
  answer_.insert(std::upper_bound(answer_.begin(), answer_.end(), found, isNearer), found);
  if (question_ == SceneQuestion::Minimum) nearest_parts_ = {a, b};
}

/// Calls `visit(a, b, gap)` for the parts of both links of a candidate; `gap` [m] is that of their boxes.
template <typename Visit>
void FclScene::forParts(std::size_t candidate, const Visit& visit) const {
  const auto [link_a, link_b] = candidates_[candidate];
  for (const std::size_t a : parts_of_link_[link_a])
    for (const std::size_t b : parts_of_link_[link_b])
      visit(a, b, parts_[a].object->getAABB().distance(parts_[b].object->getAABB()));
}

void FclScene::askEach() {
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    double closest = kInfinity;
    forParts(i, [&](std::size_t a, std::size_t b, double gap) {
      if (gap < closest) closest = measure(a, b, closest);
    });
    if (closest < kInfinity) answer_.push_back({static_cast<int>(i), closest});
  }
}

std::size_t FclScene::indexOf(const fcl::CollisionObjectd& object) const {
  return static_cast<std::size_t>(static_cast<const Part*>(object.getUserData()) - parts_.data());
}

int FclScene::candidateOf(int link_a, int link_b) const {
  const auto [link, object] = std::minmax({static_cast<std::size_t>(link_a), static_cast<std::size_t>(link_b)});
  if (object >= links_) {
    const std::size_t pair = link * objects_ + (object - links_);
    return is_checked_[pair] ? static_cast<int>(candidates_.size() + pair) : -1;
  }
  return candidate_of_[static_cast<std::size_t>(link_a) * links_ + static_cast<std::size_t>(link_b)];
}

/// Returns the distance of two parts, no more than `bound`; in overlap zero or negative. The parts are always asked in
/// the same order, as the guesses are made for it.
double FclScene::measure(std::size_t a, std::size_t b, double bound) {
  if (a > b) std::swap(a, b);
  const std::optional<double> distance = answerOf([&] { return solve(a, b, bound); });
  if (distance) return *distance;
  ++failures_;
  return bound;
}

double FclScene::solve(std::size_t a, std::size_t b, double bound) {
  const fcl::CollisionObjectd &object_a = *parts_[a].object, &object_b = *parts_[b].object;
  fcl::DistanceResultd result;
  result.min_distance = bound;
  if (method_ != Method::HullsIndep) {
    fcl::distance(&object_a, &object_b, fcl::DistanceRequestd(), result);
    return result.min_distance;
  }
  Vector3d& guess = guesses_[a * parts_.size() + b];
  fcl::detail::GJKSolver_indep<double> solver;
  solver.gjk_tolerance = fcl::DistanceRequestd().distance_tolerance;
  solver.enable_cached_guess = true;
  solver.cached_guess = guess;
  fcl::distance(&object_a, &object_b, &solver, fcl::DistanceRequestd(), result);
  // The simplex of an overlap holds the origin: its nearest point is no direction.
  guess = result.min_distance > 0.0 ? solver.cached_guess : kFirstGuess;
  return result.min_distance;
}

const std::vector<FclScene::PairWithPoints>& FclScene::closest(const BodyPoses& poses, std::size_t most,
                                                               double within) {
  update(poses);
  closest_.clear();
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    PairWithPoints best{static_cast<int>(i), within, Vector3d::Zero(), Vector3d::Zero()};
    forParts(i, [&](std::size_t a, std::size_t b, double gap) {
      if (gap < best.distance) offerPoints(a, b, best);
    });
    if (best.distance < within) closest_.push_back(best);
  }
  std::sort(closest_.begin(), closest_.end(),
            [](const PairWithPoints& a, const PairWithPoints& b) { return a.distance < b.distance; });
  if (closest_.size() > most) closest_.erase(closest_.begin() + static_cast<std::ptrdiff_t>(most), closest_.end());
  return closest_;
}

/// Takes the points of two parts if they are nearer than the best.
void FclScene::offerPoints(std::size_t a, std::size_t b, PairWithPoints& best) {
  fcl::DistanceResultd result;
  result.min_distance = best.distance;
  const auto distance = answerOf([&] {
    fcl::distance(parts_[a].object.get(), parts_[b].object.get(), fcl::DistanceRequestd(true), result);
    return result.min_distance;
  });
  if (!distance) ++failures_;
  if (!distance || !(*distance < best.distance)) return;
  best = {best.candidate, *distance, result.nearest_points[0], result.nearest_points[1]};
}

int FclScene::pairsWithBoxesWithin(double distance) const {
  int within = 0;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    double closest = kInfinity;
    forParts(i, [&](std::size_t, std::size_t, double gap) { closest = std::min(closest, gap); });
    within += closest <= distance ? 1 : 0;
  }
  return within;
}

}  // namespace proximity_server::peers
