#include "benchmark/agreement.h"

#include "benchmark/timing.h"
#include "oracle/oracle.h"
#include "peers/robots.h"
#include "proximity_server/scene/model/kinematics.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::benchmark {

using namespace narrowphase;
using namespace scene;
using namespace peers;
namespace {

using Eigen::Isometry3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMaxJudged = 20;  // the time of the oracle grows with the vertices of the hulls

/// Returns the distances by candidate pair; infinity if there is no answer.
std::vector<double> byPair(const std::vector<PairDistance>& answer, std::size_t pairs) {
  std::vector<double> distances(pairs, kInfinity);
  for (const PairDistance& pair : answer) distances[pair.pair] = pair.distance;
  return distances;
}

/// Returns the pose of a piece in the frame of the poses.
Isometry3d poseOf(const Piece& piece, const Link& link, const BodyPoses& poses) {
  return *poses[link.body] * piece.body_T_piece;
}

double reachOf(const Shape& shape) { return shape.coreRadius() + shape.margin(); }

/// Returns the distance of the closest pieces of two links, or `enough` if no piece is nearer.
double trueDistance(const RobotModel& robot, const LinkPair& pair, const BodyPoses& poses, double enough) {
  const Link &link_a = robot.links[pair.link_a], &link_b = robot.links[pair.link_b];
  double closest = enough;
  for (const Piece* a : piecesOfLink(robot, pair.link_a))
    for (const Piece* b : piecesOfLink(robot, pair.link_b)) {
      const Isometry3d a_T_b = poseOf(*a, link_a, poses).inverse(Eigen::Isometry) * poseOf(*b, link_b, poses);
      const double centres = (a_T_b * b->shape.centre() - a->shape.centre()).norm();
      if (centres - reachOf(a->shape) - reachOf(b->shape) > closest) continue;
      closest = std::min(closest, static_cast<double>(signedDistanceOracle({a->shape, b->shape, a_T_b}).distance));
    }
  return closest;
}

struct Differences {
  int compared = 0, differing = 0, overlaps_missed = 0, overlaps_claimed = 0, other_pairs = 0;
  double too_near = 0.0, too_far = 0.0;

  void add(double ours, double other) {
    if (ours <= 0.0 || other <= 0.0) {
      if (ours < -kAgreement && other > kAgreement) ++overlaps_missed;
      if (ours > kAgreement && other <= 0.0) ++overlaps_claimed;
      return;
    }
    ++compared;
    if (std::abs(ours - other) > kAgreement) ++differing;
    too_near = std::max(too_near, ours - other);
    too_far = std::max(too_far, other - ours);
  }
};

nlohmann::json verdictsOf(const std::vector<SceneAnswer>& ours, const std::vector<SceneAnswer>& others,
                          std::size_t states) {
  int missed = 0, claimed = 0, below = 0;
  for (std::size_t i = 0; i < states; ++i) {
    if (ours[i].is_below) ++below;
    if (ours[i].is_below && !others[i].is_below) ++missed;
    if (!ours[i].is_below && others[i].is_below) ++claimed;
  }
  return {{"states", states}, {"below", below}, {"below_missed", missed}, {"below_claimed", claimed}};
}

}  // namespace

void Agreement::compare(const BodyPoses& poses, const std::vector<PairDistance>& ours,
                        const std::vector<PairDistance>& others) {
  if (question_ == SceneQuestion::Minimum) {
    if (ours.empty()) return;
    if (others.empty())
      ++unanswered_;
    else
      compareMinimum(poses, ours.front(), others.front());
    return;
  }
  const std::size_t pairs = model_.pairs.checked.size();
  const std::vector<double> our_distances = byPair(ours, pairs), other_distances = byPair(others, pairs);
  const double farthest = question_ == SceneQuestion::Below ? kBelow : kInfinity;
  for (std::size_t i = 0; i < pairs; ++i) {
    const double our = std::min(our_distances[i], farthest), other = std::min(other_distances[i], farthest);
    if (our == farthest && other == farthest) continue;
    if (std::isinf(other))
      ++unanswered_;
    else
      compareDistances(poses, {static_cast<int>(i)}, our, other);
  }
}

/// The two may name different pairs: the truth is then the smaller one of both.
void Agreement::compareMinimum(const BodyPoses& poses, const PairDistance& ours, const PairDistance& other) {
  std::vector<int> pairs{ours.pair};
  if (other.pair != ours.pair) pairs.push_back(other.pair);
  compareDistances(poses, pairs, ours.distance, other.distance);
}

void Agreement::compareDistances(const BodyPoses& poses, const std::vector<int>& pairs, double ours, double other) {
  if (ours <= 0.0 || other <= 0.0) {
    if (ours < -kAgreement && other > kAgreement) ++overlaps_missed_;
    if (ours > kAgreement && other <= 0.0) ++overlaps_claimed_;
    return;
  }
  differences_.push_back(std::abs(ours - other));
  if (!(differences_.back() > kAgreement)) return;
  ++differing_;
  if (judged_ < kMaxJudged) judge(poses, pairs, ours, other);
}

void Agreement::judge(const BodyPoses& poses, const std::vector<int>& pairs, double ours, double other) {
  double truth = question_ == SceneQuestion::Below ? kBelow : kInfinity;
  for (const int pair : pairs) {
    const int index = model_.pairs.checked[pair];
    truth = trueDistance(model_.robot, model_.pairs.pairs[index], poses, truth);
  }
  ++judged_;
  if (std::abs(ours - truth) <= kAgreement) ++ours_right_;
  if (std::abs(other - truth) <= kAgreement) ++other_right_;
}

nlohmann::json Agreement::summary() const {
  nlohmann::json summary = {{"compared", differences_.size()},
                            {"differing", differing_},
                            {"judged", judged_},
                            {"ours_right", ours_right_},
                            {"other_right", other_right_},
                            {"overlaps_missed", overlaps_missed_},
                            {"overlaps_claimed", overlaps_claimed_},
                            {"unanswered", unanswered_}};
  if (differences_.empty()) return summary;
  summary["max_error"] = quantile(differences_, 1.0);
  summary["p99_error"] = quantile(differences_, 0.99);
  return summary;
}

nlohmann::json sweepAgreement(SceneQuestion question, const std::vector<SceneAnswer>& ours,
                              const std::vector<SceneAnswer>& others) {
  const std::size_t states = std::min(ours.size(), others.size());
  if (question == SceneQuestion::AnyBelow) return verdictsOf(ours, others, states);
  Differences found;
  for (std::size_t i = 0; i < states; ++i) {
    const std::vector<PairDistance>&our = ours[i].pairs, &other = others[i].pairs;
    if (our.size() != other.size()) ++found.other_pairs;
    for (std::size_t j = 0; j < std::min(our.size(), other.size()); ++j) found.add(our[j].distance, other[j].distance);
  }
  return {{"states", states},
          {"compared", found.compared},
          {"differing", found.differing},
          {"too_near", found.too_near},
          {"too_far", found.too_far},
          {"overlaps_missed", found.overlaps_missed},
          {"overlaps_claimed", found.overlaps_claimed},
          {"other_pairs", found.other_pairs}};
}

}  // namespace proximity_server::benchmark
