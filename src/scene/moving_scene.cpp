#include "proximity_server/scene/moving_scene.h"

#include <algorithm>
#include <queue>
#include <stdexcept>
#include <string>
#include <utility>

#include "moving_bodies.h"
#include "volumes.h"

namespace proximity_server {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMostLevels = 6;  // of intervals; the narrowphase divides the shorter ones itself

/// A pair of subjects in motion.
struct MovingPairOfLinks {
  SubjectPair asked;
  double padding;  ///< [m]
  MovingBodies bodies;
};

/// Two volumes, see Volumes, during an interval of time, see MovingBodies::Interval.
struct Visit {
  double lower_bound;  ///< [m] of their signed distance less the padding
  int pair, a, b, interval;
  double travel;  ///< [m] of one as seen from the other
};

/// What goes first.
struct NearestFirst {
  bool operator()(const Visit& p, const Visit& q) const { return p.lower_bound > q.lower_bound; }
};
struct EarliestFirst {
  bool operator()(const Visit& p, const Visit& q) const {
    const double of_p = MovingBodies::Interval(p.interval).begin, of_q = MovingBodies::Interval(q.interval).begin;
    return of_p != of_q ? of_p > of_q : p.lower_bound > q.lower_bound;
  }
};
template <typename Order>
using Queue = std::priority_queue<Visit, std::vector<Visit>, Order>;

/// The status of an answer that some parts left open.
Status worse(Status p, Status q) { return std::max(p, q); }

}  // namespace

/// One question: the pairs, how they move, and what of them is still open.
class MovingScene::Search {
 public:
  explicit Search(std::shared_ptr<const SceneModel> model) : model_(std::move(model)), volumes_(model_->robot) {}

  const SceneModel& model() const { return *model_; }

  RobotContact timeOfContact(const std::vector<SubjectPair>& pairs, const RobotMotion& motion,
                             const MotionQuestion& question) {
    RobotContact answer;
    Queue<EarliestFirst> queue;
    enter(pairs, motion, answer.counts, question.clearance, queue);
    return firstContact(answer, queue, motion, question);
  }

  RobotMinimum minimum(const std::vector<SubjectPair>& pairs, const RobotMotion& motion,
                       const MotionQuestion& question) {
    RobotMinimum answer;
    Queue<NearestFirst> queue;
    enter(pairs, motion, answer.counts, kInfinity, queue);
    return smallest(answer, queue, motion, question);
  }

 private:
  double paddingOf(const SubjectPair& pair) const {
    const int index = model_->pairs.find(pair.a.link, pair.b.link);
    return index < 0 ? 0.0 : model_->pairs.pairs[static_cast<std::size_t>(index)].padding;
  }

  /// Queues all pairs that one bound for the whole motion does not settle.
  template <typename Order>
  void enter(const std::vector<SubjectPair>& pairs, const RobotMotion& motion, MotionCounts& counts, double clearance,
             Queue<Order>& queue) {
    if (motion.segments().size() != model_->robot.bodies.size())
      throw std::invalid_argument("the robot has " + std::to_string(model_->robot.bodies.size()) +
                                  " bodies, but the motion is of " + std::to_string(motion.segments().size()));
    counts.pairs = static_cast<int>(pairs.size());
    pairs_.clear();
    for (const SubjectPair& pair : pairs) {
      const int a = volumes_.of(pair.a), b = volumes_.of(pair.b);
      const Volume &volume_a = volumes_[a], &volume_b = volumes_[b];
      MovingBodies bodies(motion, volume_a.body, volume_a.bounds, volume_b.body, volume_b.bounds);
      if (volume_a.isEmpty() || volume_b.isEmpty() || !bodies.isKnown()) {
        ++counts.unknown;
        continue;
      }
      pairs_.push_back({pair, paddingOf(pair), std::move(bodies)});
      const Visit visit = bounded({-kInfinity, static_cast<int>(pairs_.size()) - 1, a, b, 1, 0.0});
      if (visit.lower_bound > clearance)
        ++counts.by_one_bound;
      else
        queue.push(visit);
    }
  }

  MovingPairOfLinks& pairOf(const Visit& visit) { return pairs_[static_cast<std::size_t>(visit.pair)]; }

  Visit bounded(Visit visit) {
    MovingPairOfLinks& pair = pairOf(visit);
    const MovingBodies::SphereGap sphere =
        pair.bodies.sphereGap(volumes_[visit.a].bounds, volumes_[visit.b].bounds, visit.interval);
    visit.lower_bound = std::max(visit.lower_bound, sphere.gap - pair.padding);
    visit.travel = sphere.travel;
    return visit;
  }

  bool isLeaf(const Visit& visit) const { return volumes_[visit.a].isLeaf() && volumes_[visit.b].isLeaf(); }

  /// In time where they move farther than they are large, else the larger of the two volumes.
  template <typename Order>
  void divide(const Visit& visit, double limit, Queue<Order>& queue) {
    const Volume &a = volumes_[visit.a], &b = volumes_[visit.b];
    const auto enter = [&](Visit part) {
      part = bounded(part);
      if (!(part.lower_bound > limit)) queue.push(part);
    };
    const bool divide_a = !a.isLeaf() && (b.isLeaf() || a.bounds.radius >= b.bounds.radius);
    const double radius = (divide_a ? a : b).bounds.radius;
    if (visit.travel > radius && visit.interval < 1 << kMostLevels) {
      for (const int half : {2 * visit.interval, 2 * visit.interval + 1})
        enter({visit.lower_bound, visit.pair, visit.a, visit.b, half, 0.0});
    } else {
      for (const int part : divide_a ? a.parts : b.parts)
        enter(
            {visit.lower_bound, visit.pair, divide_a ? part : visit.a, divide_a ? visit.b : part, visit.interval, 0.0});
    }
  }

  const Piece& pieceOf(int leaf) const { return model_->robot.pieces[static_cast<std::size_t>(volumes_[leaf].piece)]; }

  RobotContact firstContact(RobotContact answer, Queue<EarliestFirst>& queue, const RobotMotion& motion,
                            const MotionQuestion& question) {
    double undecided = kInfinity, latest = 1.0;
    answer.status = Status::Converged;
    while (!queue.empty()) {
      const Visit visit = queue.top();
      const MovingBodies::Interval interval(visit.interval);
      if (!(interval.begin < latest)) break;
      if (isOver(question, ++answer.counts.intervals)) {
        undecided = std::min(undecided, interval.begin);
        answer.status = Status::IterationLimit;
        break;
      }
      queue.pop();
      if (!isLeaf(visit)) {
        divide(visit, question.clearance, queue);
        continue;
      }
      MovingPairOfLinks& pair = pairOf(visit);
      const ContactOptions options{question.clearance + pair.padding, question.tolerance, interval.begin,
                                   std::min(interval.end, latest)};
      const Piece &a = pieceOf(visit.a), &b = pieceOf(visit.b);
      const TimeOfContact contact = proximity_server::timeOfContact(
          a.shape, pair.bodies.chainOfA(a.body_T_piece), b.shape, pair.bodies.chainOfB(b.body_T_piece), options);
      answer.counts.queries += contact.queries;
      if (contact.contact && !(answer.contact && contact.t_contact >= answer.t_contact)) {
        answer.contact = true;
        answer.t_contact = latest = contact.t_contact;
        answer.pair = found(visit, contact.at_contact, motion, contact.t_contact);
      } else if (contact.status != Status::Converged) {
        answer.status = worse(answer.status, contact.status);
        undecided = std::min(undecided, contact.t_free);
      }
    }
    answer.t_free = std::min(undecided, latest);
    if (!(undecided < latest)) answer.status = Status::Converged;
    if (answer.counts.unknown == answer.counts.pairs) answer.status = Status::Unknown;
    return answer;
  }

  RobotMinimum smallest(RobotMinimum answer, Queue<NearestFirst>& queue, const RobotMotion& motion,
                        const MotionQuestion& question) {
    double proven = kInfinity;  // [m] the smallest bound of all pieces that were measured
    answer.status = Status::Converged;
    while (!queue.empty() && queue.top().lower_bound < answer.upper_bound - question.tolerance) {
      if (isOver(question, ++answer.counts.intervals)) {
        answer.status = Status::IterationLimit;
        break;
      }
      const Visit visit = queue.top();
      queue.pop();
      if (!isLeaf(visit)) {
        divide(visit, answer.upper_bound, queue);
        continue;
      }
      MovingPairOfLinks& pair = pairOf(visit);
      const MovingBodies::Interval interval(visit.interval);
      MinimumOptions options;
      options.tolerance = question.tolerance;
      options.begin = interval.begin;
      options.end = interval.end;
      options.stop_above = answer.upper_bound + pair.padding - question.tolerance;
      const Piece &a = pieceOf(visit.a), &b = pieceOf(visit.b);
      const MinimumOverMotion minimum = minimumDistance(a.shape, pair.bodies.chainOfA(a.body_T_piece), b.shape,
                                                        pair.bodies.chainOfB(b.body_T_piece), options);
      answer.counts.queries += minimum.queries;
      proven = std::min(proven, minimum.lower_bound - pair.padding);
      if (minimum.status != Status::Threshold) answer.status = worse(answer.status, minimum.status);
      if (!(minimum.upper_bound - pair.padding < answer.upper_bound)) continue;
      answer.upper_bound = minimum.upper_bound - pair.padding;
      answer.time = minimum.time;
      answer.pair = found(visit, minimum.at_minimum, motion, minimum.time);
    }
    const double open = queue.empty() ? kInfinity : queue.top().lower_bound;
    answer.lower_bound = std::min({proven, open, answer.upper_bound});
    if (answer.counts.unknown == answer.counts.pairs) answer.status = Status::Unknown;
    return answer;
  }

  /// The clock is read now and then only.
  static bool isOver(const MotionQuestion& question, int visits) {
    using Clock = std::chrono::steady_clock;
    return question.deadline != Clock::time_point::max() && visits % 8 == 1 && Clock::now() > question.deadline;
  }

  /// A result of the narrowphase as an answer about links, in the frame of the poses.
  PairProximity found(const Visit& visit, SignedDistance result, const RobotMotion& motion, double time) {
    const MovingPairOfLinks& pair = pairOf(visit);
    const Volume &a = volumes_[visit.a], &b = volumes_[visit.b];
    const int middle = pair.bodies.middle();
    if (middle >= 0) {
      const Eigen::Isometry3d pose = *motion.at(time)[static_cast<std::size_t>(middle)];
      result.normal = (pose.linear() * result.normal).normalized();
      result.point_a = pose * result.point_a;
    }
    result.distance -= pair.padding;
    result.lower_bound -= pair.padding;
    result.upper_bound -= pair.padding;
    result.point_a += 0.5 * pair.padding * result.normal;
    result.point_b = result.point_a + result.distance * result.normal;
    PairProximity proximity;
    proximity.asked = pair.asked;
    proximity.collision_a = collisionOf(model_->robot, a.piece).number;
    proximity.collision_b = collisionOf(model_->robot, b.piece).number;
    proximity.representation = std::max(a.representation, b.representation);
    proximity.result = result;
    const bool is_compound =
        !volumes_[volumes_.of(pair.asked.a)].isLeaf() || !volumes_[volumes_.of(pair.asked.b)].isLeaf();
    proximity.depth_is_lower_bound = result.distance < 0.0 && is_compound;
    return proximity;
  }

  std::shared_ptr<const SceneModel> model_;
  Volumes volumes_;
  std::vector<MovingPairOfLinks> pairs_;
};

MovingScene::MovingScene(std::shared_ptr<const SceneModel> model)
    : search_(std::make_unique<Search>(std::move(model))) {}
MovingScene::~MovingScene() = default;
MovingScene::MovingScene(MovingScene&&) noexcept = default;
MovingScene& MovingScene::operator=(MovingScene&&) noexcept = default;

const SceneModel& MovingScene::model() const { return search_->model(); }

RobotContact MovingScene::timeOfContact(const std::vector<SubjectPair>& pairs, const RobotMotion& motion,
                                        const MotionQuestion& question) {
  return search_->timeOfContact(pairs, motion, question);
}

RobotMinimum MovingScene::minimum(const std::vector<SubjectPair>& pairs, const RobotMotion& motion,
                                  const MotionQuestion& question) {
  return search_->minimum(pairs, motion, question);
}

}  // namespace proximity_server
