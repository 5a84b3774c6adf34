#include "benchmark/moving_robots.h"

#include "benchmark/motions.h"
#include "benchmark/timing.h"
#include "chance.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/joint_spline.h"
#include "proximity_server/scene/motion/motion_search.h"
#include "scene/posed_scene.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

namespace proximity_server::benchmark {

using namespace narrowphase;
using namespace scene;
using namespace peers;
namespace {

using nlohmann::json;

constexpr int kRounds = 3;
constexpr double kSamplesPerSecond = 1000.0;
constexpr int kFineStates = 200;              // first states in steps of our guarantee, whose time is extrapolated
constexpr std::size_t kFineMotions = 20;      // of so many motions
constexpr double kSpeedStep = 1e-3;           // [s] between the poses that tell how fast bodies are
constexpr int kPoints = 20;                   // of a trajectory
constexpr double kSplineSeconds = 10.0;       // of a trajectory
constexpr int kMotionsPerSpline = 8;          // fewer trajectories than motions, as each has 19 segments
constexpr double kTube = 0.5 * M_PI / 180.0;  // [rad] or [m] of each joint

enum class Asked { Contact, ContactWithin2Cm, Minimum };

const std::pair<const char*, Asked> kAsked[] = {
    {"contact", Asked::Contact}, {"below 2 cm", Asked::ContactWithin2Cm}, {"minimum", Asked::Minimum}};

double contactDistanceOf(Asked asked) { return asked == Asked::ContactWithin2Cm ? 0.02 : 0.0; }

const std::pair<const char*, int MotionCounts::*> kCounts[] = {{"pairs", &MotionCounts::pairs},
                                                               {"unknown", &MotionCounts::unknown},
                                                               {"by_one_bound", &MotionCounts::by_one_bound},
                                                               {"intervals", &MotionCounts::intervals},
                                                               {"queries", &MotionCounts::queries}};

constexpr double kFar = std::numeric_limits<double>::infinity();

/// The answer about one motion by one of the ways to ask.
struct Answer {
  bool contact = false;
  double t_free = 1.0, t_contact = 1.0;      ///< [s] t_contact of the minimum: its time
  double lower_bound = 0.0, distance = 0.0;  ///< [m] of the minimum
  MotionCounts counts;
  double microseconds = 0.0;
  Positions state = {};  ///< of the contact or the minimum, if it is not on the way itself
};

/// A way of a robot in a time from 0 on.
struct Way {
  double seconds;
  std::function<BodyPoses(double time)> at;
  std::function<Answer(Asked)> ours;  ///< times are in seconds; includes making the motion
  bool has_tube = false;
};

Question isAnyWithin(double contact_distance) {
  Question question;
  question.threshold = contact_distance;
  question.depth = Question::Depth::NotWanted;
  return question;
}

/// The two ways of one robot to be asked about its motions, with their scratch.
class Contest {
 public:
  explicit Contest(const NamedRobot& robot) : model_(robot.model), moving_(robot.model), scene_(robot.model) {}

  /// Returns motions of a second at constant velocity that begin without contact.
  std::vector<Way> lines(int count) {
    std::vector<Way> ways;
    for (const JointMotion& motion : randomJointMotions(model_->robot, 20 * count)) {
      if (ways.size() == static_cast<std::size_t>(count)) break;
      if (!isFree(motion.from)) continue;
      ways.push_back(
          {1.0, poses(RobotMotion::between(model_->robot, motion.from, motion.to)), [this, motion](Asked asked) {
             const RobotMotion moved = RobotMotion::between(model_->robot, motion.from, motion.to);
             return asked == Asked::Minimum ? oursMinimum(moved) : oursContact(moved, contactDistanceOf(asked));
           }});
    }
    return ways;
  }

  /// Returns trajectories as joint_trajectory_controller drives them, cubic splines that begin without contact, and how
  /// far each joint may be off.
  std::vector<Way> splines(int count, double tracking_error) {
    Chance chance(17);
    std::vector<Way> ways;
    for (const JointMotion& motion : randomJointMotions(model_->robot, 20 * count)) {
      if (ways.size() == static_cast<std::size_t>(count)) break;
      if (!isFree(motion.from)) continue;
      const std::vector<TrajectoryPoint> points = somePoints(motion.from, chance);
      ways.push_back(
          {kSplineSeconds, poses(segmentsOf(points)),
           [this, points, tracking_error](Asked asked) { return oursAlong(segmentsOf(points), asked, tracking_error); },
           tracking_error > 0.0});
    }
    return ways;
  }

  Answer ours(const Way& way, Asked asked) {
    Answer answer;
    const double microseconds = timeOf<std::micro>([&] { answer = way.ours(asked); });
    answer.microseconds = microseconds;
    return answer;
  }

  Answer sampled(const Way& way, Asked asked) {
    Answer answer;
    answer.microseconds = timeOf<std::micro>([&] {
      answer = asked == Asked::Minimum ? sampledMinimum(way) : sampledContact(way, contactDistanceOf(asked));
    });
    return answer;
  }

  /// The number and the time of samples until `until` in such steps that nothing comes closer between two of them than
  /// by our tolerance. The time is that number times the median of the first.
  struct Extrapolated {
    double samples, microseconds;
  };
  Extrapolated sampledAtOurGuarantee(const Way& way, Asked asked, double until) {
    const double step = MotionQuestion{}.tolerance / closingSpeed(way);
    scene_.update(way.at(0.0));
    ask(asked);
    std::vector<double> times;
    for (int i = 1; i <= kFineStates; ++i) {
      times.push_back(timeOf<std::micro>([&] {
        scene_.update(way.at(i * step));
        ask(asked);
      }));
    }
    const double samples = until / step;
    return {samples, samples * medianOf(times)};
  }

  /// Returns whether the robot is as close to itself at our time as ours says: within the contact distance, or at the
  /// minimum.
  bool isConfirmed(const Way& way, Asked asked, const Answer& ours) {
    scene_.update(ours.state.empty() ? way.at(ours.t_contact) : forwardKinematics(model_->robot, ours.state));
    const PairProximity* closest = scene_.minimum(scene_.candidates());
    const double distance = asked == Asked::Minimum ? ours.distance : contactDistanceOf(asked);
    return closest != nullptr && closest->result.distance <= distance + MotionQuestion{}.tolerance;
  }

 private:
  bool isFree(const Positions& positions) {
    scene_.update(forwardKinematics(model_->robot, positions));
    return scene_.first(scene_.candidates(), isAnyWithin(contactDistanceOf(Asked::ContactWithin2Cm))) == nullptr;
  }

  static std::function<BodyPoses(double)> poses(const RobotMotion& motion) {
    return [motion](double time) { return motion.at(time); };
  }
  std::function<BodyPoses(double)> poses(std::vector<SplineSegment> segments) const {
    return [this, segments = std::move(segments)](double time) {
      const auto next = std::find_if(segments.begin(), segments.end() - 1,
                                     [time](const SplineSegment& segment) { return time < segment.end(); });
      return forwardKinematics(model_->robot, next->at((time - next->begin()) / (next->end() - next->begin())));
    };
  }

  /// From one point to the next each joint goes at a random part of its largest velocity; the velocities at a point are
  /// those from the point before to the point behind.
  std::vector<TrajectoryPoint> somePoints(const Positions& start, Chance& chance) const {
    const double step = kSplineSeconds / (kPoints - 1);
    std::vector<TrajectoryPoint> points(kPoints);
    for (int i = 0; i < kPoints; ++i) {
      points[i].time = i * step;
      points[i].positions = i == 0 ? start : points[i - 1].positions;
      points[i].velocities.assign(model_->robot.joints.size(), 0.0);
      for (std::size_t joint = 0; i > 0 && joint < model_->robot.joints.size(); ++joint) {
        const Joint& moved = model_->robot.joints[joint];
        const double fastest = std::isfinite(moved.max_velocity) ? moved.max_velocity : 1.0;
        double& position = points[i].positions[joint];
        position = std::clamp(position + step * chance.between(-fastest, fastest), moved.lower, moved.upper);
      }
    }
    for (int i = 1; i + 1 < kPoints; ++i)
      for (std::size_t joint = 0; joint < model_->robot.joints.size(); ++joint)
        points[i].velocities[joint] = (points[i + 1].positions[joint] - points[i - 1].positions[joint]) / (2.0 * step);
    return points;
  }

  std::vector<SplineSegment> segmentsOf(const std::vector<TrajectoryPoint>& points) const {
    std::vector<SplineSegment> segments;
    for (int i = 0; i + 1 < kPoints; ++i) segments.emplace_back(model_->robot, points[i], points[i + 1]);
    return segments;
  }

  /// The first contact, or the smallest distance of all segments.
  Answer oursAlong(const std::vector<SplineSegment>& segments, Asked asked, double tracking_error) {
    MotionQuestion question;
    question.contact_distance = contactDistanceOf(asked);
    std::vector<double> tube;
    if (tracking_error > 0.0) tube.assign(model_->robot.joints.size(), tracking_error);
    Answer answer{false, kSplineSeconds, kSplineSeconds, kFar, kFar, {}, 0.0};
    for (const SplineSegment& segment : segments) {
      const Motion motion(model_->robot, segment, tube);
      const auto timeIn = [&](double time) { return segment.begin() + time * (segment.end() - segment.begin()); };
      if (asked == Asked::Minimum) {
        const RobotMinimum found = moving_.minimum(scene_.candidates(), motion, question);
        add(answer.counts, found.counts);
        answer.lower_bound = std::min(answer.lower_bound, found.lower_bound);
        if (found.upper_bound >= answer.distance) continue;
        answer.distance = found.upper_bound;
        answer.t_contact = timeIn(found.time);
        answer.state = found.state;
        continue;
      }
      const RobotTimeOfContact found = moving_.timeOfContact(scene_.candidates(), motion, question);
      add(answer.counts, found.counts);
      if (!found.contact && found.t_free == 1.0) continue;
      answer.t_free = timeIn(found.t_free);
      answer.contact = found.contact;
      if (found.contact) answer.t_contact = timeIn(found.t_contact);
      answer.state = found.state;
      break;
    }
    return answer;
  }

  static void add(MotionCounts& sum, const MotionCounts& counts) {
    for (const auto& [name, count] : kCounts) sum.*count += counts.*count;
  }

  Answer oursContact(const RobotMotion& motion, double contact_distance) {
    MotionQuestion question;
    question.contact_distance = contact_distance;
    const RobotTimeOfContact result = moving_.timeOfContact(scene_.candidates(), motion, question);
    return {result.contact, result.t_free, result.contact ? result.t_contact : 1.0, 0.0, 0.0, result.counts, 0.0};
  }

  Answer oursMinimum(const RobotMotion& motion) {
    const RobotMinimum result = moving_.minimum(scene_.candidates(), motion);
    return {false, 0.0, result.time, result.lower_bound, result.upper_bound, result.counts, 0.0};
  }

  const PairProximity* ask(Asked asked) {
    if (asked == Asked::Minimum) return scene_.minimum(scene_.candidates());
    return scene_.first(scene_.candidates(), isAnyWithin(contactDistanceOf(asked)));
  }

  static int samplesOf(const Way& way) { return 1 + static_cast<int>(std::lround(way.seconds * kSamplesPerSecond)); }

  Answer sampledContact(const Way& way, double contact_distance) {
    Answer answer;
    answer.t_free = 0.0;
    for (int i = 0; i < samplesOf(way); ++i) {
      const double time = i / kSamplesPerSecond;
      scene_.update(way.at(time));
      answer.t_contact = time;
      answer.contact = scene_.first(scene_.candidates(), isAnyWithin(contact_distance)) != nullptr;
      if (answer.contact) return answer;
      answer.t_free = time;
    }
    return answer;
  }

  Answer sampledMinimum(const Way& way) {
    Answer answer;
    answer.distance = kFar;
    for (int i = 0; i < samplesOf(way); ++i) {
      scene_.update(way.at(i / kSamplesPerSecond));
      const PairProximity* closest = scene_.minimum(scene_.candidates());
      if (closest != nullptr) answer.distance = std::min(answer.distance, closest->result.distance);
    }
    return answer;
  }

  /// Returns how far [m] the body's pieces reach from its origin, at most.
  double reachOf(const Body& body) const {
    double reach = 0.0;
    for (const int index : body.pieces) {
      const Piece& piece = model_->robot.pieces[index];
      const double radius = piece.shape.coreRadius() + piece.shape.margin();
      reach = std::max(reach, (piece.body_T_piece * piece.shape.centre()).norm() + radius);
    }
    return reach;
  }

  /// Returns the sum of the speeds [m/s] of the two fastest bodies, from poses all over the way.
  double closingSpeed(const Way& way) const {
    std::vector<double> fastest(model_->robot.bodies.size(), 0.0);
    for (int i = 0; i < 50; ++i) {
      const double time = way.seconds * i / 50.0;
      const BodyPoses before = way.at(time), after = way.at(time + kSpeedStep);
      for (std::size_t body = 0; body < fastest.size(); ++body) {
        if (!before[body] || !after[body]) continue;
        const double turn = Eigen::AngleAxisd(before[body]->linear().transpose() * after[body]->linear()).angle();
        const double moved = (after[body]->translation() - before[body]->translation()).norm();
        const double speed = (moved + turn * reachOf(model_->robot.bodies[body])) / kSpeedStep;
        fastest[body] = std::max(fastest[body], speed);
      }
    }
    std::partial_sort(fastest.begin(), fastest.begin() + 2, fastest.end(), std::greater<>());
    return fastest[0] + fastest[1];
  }

  std::shared_ptr<const SceneModel> model_;
  MotionSearch moving_;
  PosedScene scene_;
};

/// The answers of both ways about all motions.
struct Answers {
  std::vector<Answer> ours, sampled;
};

Answers askAll(Contest& contest, const std::vector<Way>& motions, Asked asked) {
  Answers answers;
  Rounds ours(motions.size());
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t i = 0; i < motions.size(); ++i) {
      if (round == 0) answers.sampled.push_back(contest.sampled(motions[i], asked));
      const Answer answer = contest.ours(motions[i], asked);
      ours.add(i, answer.microseconds);
      if (round == 0) answers.ours.push_back(answer);
    }
  const std::vector<double> medians = ours.medians();
  for (std::size_t i = 0; i < motions.size(); ++i) answers.ours[i].microseconds = medians[i];
  return answers;
}

json timesOf(const std::vector<Answer>& answers) {
  std::vector<double> times;
  for (const Answer& answer : answers) times.push_back(answer.microseconds);
  return {{"median_us", medianOf(times)}, {"p99_us", quantile(times, 0.99)}};
}

/// Returns the means over the motions.
json meanCounts(const std::vector<Answer>& answers) {
  json means;
  for (const auto& [name, count] : kCounts) {
    double sum = 0.0;
    for (const Answer& answer : answers) sum += answer.counts.*count;
    means[name] = sum / static_cast<double>(answers.size());
  }
  return means;
}

/// Compares the samples with the contacts and the minimum that ours found. "contradicted": samples in contact, or
/// closer than the lower bound, where ours says that there is none.
json beside(const Answers& answers, Asked asked) {
  int contacts = 0, missed = 0, contradicted = 0;
  double latest = 0.0, above = 0.0;
  for (std::size_t i = 0; i < answers.ours.size(); ++i) {
    const Answer& ours = answers.ours[i];
    const Answer& sampled = answers.sampled[i];
    if (asked == Asked::Minimum) {
      above = std::max(above, sampled.distance - ours.distance);
      if (sampled.distance < ours.lower_bound) ++contradicted;
      continue;
    }
    if (ours.contact) ++contacts;
    if (ours.contact && !sampled.contact) ++missed;
    if (sampled.contact && (ours.contact ? sampled.t_contact < ours.t_free : sampled.t_contact <= ours.t_free))
      ++contradicted;
    if (ours.contact && sampled.contact) latest = std::max(latest, sampled.t_contact - ours.t_contact);
  }
  if (asked == Asked::Minimum) return {{"max_error", above}, {"contradicted", contradicted}};
  return {{"contacts", contacts}, {"missed", missed}, {"max_late", latest}, {"contradicted", contradicted}};
}

/// Returns how many of our contacts and minima the robot's clearance at their time does not confirm.
int unconfirmed(Contest& contest, const std::vector<Way>& motions, const std::vector<Answer>& ours, Asked asked) {
  int count = 0;
  for (std::size_t i = 0; i < motions.size(); ++i)
    if ((asked == Asked::Minimum || ours[i].contact) && !contest.isConfirmed(motions[i], asked, ours[i])) ++count;
  return count;
}

json extrapolate(Contest& contest, const std::vector<Way>& motions, const Answers& answers, Asked asked) {
  std::vector<double> samples, times;
  const std::size_t stride = std::max<std::size_t>(1, motions.size() / kFineMotions);
  for (std::size_t i = 0; i < motions.size(); i += stride) {
    const double until = asked == Asked::Minimum ? motions[i].seconds : answers.ours[i].t_contact;
    const Contest::Extrapolated fine = contest.sampledAtOurGuarantee(motions[i], asked, until);
    samples.push_back(fine.samples);
    times.push_back(fine.microseconds);
  }
  return {{"samples", medianOf(samples)}, {"median_us", medianOf(times)}};
}

void measure(json& rows, Contest& contest, const json& head, const std::vector<Way>& motions, Asked asked) {
  const Answers answers = askAll(contest, motions, asked);
  json ours = head, sampled = head, fine = head;
  ours.update(timesOf(answers.ours));
  ours.update({{"library", "ours"},
               {"counts", meanCounts(answers.ours)},
               {"unconfirmed", unconfirmed(contest, motions, answers.ours, asked)}});
  sampled.update(timesOf(answers.sampled));
  sampled.update({{"library", "sampling, 1 kHz"}, {"samples", 1 + kSamplesPerSecond * motions.front().seconds}});
  sampled.update(beside(answers, asked));
  for (const json& entry : {ours, sampled}) rows.push_back(entry);
  if (!motions.front().has_tube) {  // samples of the way say nothing about what lies beside it
    fine.update(extrapolate(contest, motions, answers, asked));
    fine.update({{"library", "sampling, our guarantee"}, {"extrapolated", true}});
    rows.push_back(fine);
  }
  showProgress();
}

}  // namespace

json measureMovingRobots(const std::vector<NamedRobot>& robots, int motions, const Wanted& wanted) {
  const int splines = std::max(1, motions / kMotionsPerSpline);
  const std::pair<const char*, std::function<std::vector<Way>(Contest&)>> kinds[] = {
      {"", [&](Contest& contest) { return contest.lines(motions); }},
      {"spline of 10 s, ", [&](Contest& contest) { return contest.splines(splines, 0.0); }},
      {"tube of 0.5 degrees, ", [&](Contest& contest) { return contest.splines(splines, kTube); }}};
  json rows = json::array();
  for (const NamedRobot& robot : robots) {
    Contest contest(robot);
    for (const auto& [kind, draw] : kinds) {
      std::vector<Way> ways;
      for (const auto& [question, asked] : kAsked) {
        const std::string name = robot.name + ", " + kind + question;
        if (!wanted(name)) continue;
        if (ways.empty()) ways = draw(contest);
        if (ways.empty()) continue;
        const json head = {{"row", name},
                           {"robot", robot.name},
                           {"question", kind + std::string(question)},
                           {"pairs", robot.model->pairs.checked.size()},
                           {"motions", ways.size()}};
        measure(rows, contest, head, ways, asked);
      }
    }
  }
  return rows;
}

}  // namespace proximity_server::benchmark
