#include "benchmark/moving_robots.h"

#include "benchmark/motions.h"
#include "benchmark/timing.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/moving_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace proximity_server::benchmark {

using namespace narrowphase;
using namespace scene;
using namespace peers;
namespace {

using nlohmann::json;

constexpr int kRounds = 3;
constexpr int kSamples = 1001;            // 1 kHz
constexpr int kFineStates = 200;          // first states in steps of our guarantee, whose time is extrapolated
constexpr std::size_t kFineMotions = 20;  // of so many motions
constexpr double kSpeedStep = 1e-3;       // of the time, between the poses that tell how fast bodies are

enum class Asked { Contact, ContactWithin2Cm, Minimum };

const std::pair<const char*, Asked> kAsked[] = {
    {"contact", Asked::Contact}, {"below 2 cm", Asked::ContactWithin2Cm}, {"minimum", Asked::Minimum}};

double contactDistanceOf(Asked asked) { return asked == Asked::ContactWithin2Cm ? 0.02 : 0.0; }

/// The answer about one motion by one of the ways to ask.
struct Answer {
  bool contact = false;
  double t_free = 1.0, t_contact = 1.0;      ///< t_contact of the minimum: its time
  double lower_bound = 0.0, distance = 0.0;  ///< [m] of the minimum
  MotionCounts counts;
  double microseconds = 0.0;
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

  /// Returns motions that begin without contact.
  std::vector<JointMotion> motions(int count) {
    std::vector<JointMotion> drawn = randomJointMotions(model_->robot, 20 * count), free;
    for (const JointMotion& motion : drawn) {
      if (free.size() == static_cast<std::size_t>(count)) break;
      scene_.update(forwardKinematics(model_->robot, motion.from));
      if (scene_.first(scene_.candidates(), isAnyWithin(contactDistanceOf(Asked::ContactWithin2Cm))) == nullptr)
        free.push_back(motion);
    }
    return free;
  }

  Answer ours(const JointMotion& motion, Asked asked) {
    return timed(motion, [&](const RobotMotion& moved) {
      return asked == Asked::Minimum ? oursMinimum(moved) : oursContact(moved, contactDistanceOf(asked));
    });
  }

  Answer sampled(const JointMotion& motion, Asked asked) {
    return timed(motion, [&](const RobotMotion& moved) {
      return asked == Asked::Minimum ? sampledMinimum(moved) : sampledContact(moved, contactDistanceOf(asked));
    });
  }

  /// The number and the time of samples until `until` in such steps that nothing comes closer between two of them than
  /// by our tolerance. The time is that number times the median of the first.
  struct Extrapolated {
    double samples, microseconds;
  };
  Extrapolated sampledAtOurGuarantee(const JointMotion& motion, Asked asked, double until) {
    const RobotMotion moved = RobotMotion::between(model_->robot, motion.from, motion.to);
    const double step = MotionQuestion{}.tolerance / closingSpeed(moved);
    scene_.update(moved.at(0.0));
    ask(asked);
    std::vector<double> times;
    for (int i = 1; i <= kFineStates; ++i) {
      times.push_back(timeOf<std::micro>([&] {
        scene_.update(moved.at(i * step));
        ask(asked);
      }));
    }
    const double samples = until / step;
    return {samples, samples * medianOf(times)};
  }

  /// Returns whether the robot is as close to itself at our time as ours says: within the contact distance, or at the
  /// minimum.
  bool isConfirmed(const JointMotion& motion, Asked asked, const Answer& ours) {
    const RobotMotion moved = RobotMotion::between(model_->robot, motion.from, motion.to);
    scene_.update(moved.at(ours.t_contact));
    const PairProximity* closest = scene_.minimum(scene_.candidates());
    const double distance = asked == Asked::Minimum ? ours.distance : contactDistanceOf(asked);
    return closest != nullptr && closest->result.distance <= distance + MotionQuestion{}.tolerance;
  }

 private:
  /// Returns the answer about a motion with its time, which includes making the motion.
  template <typename Give>
  Answer timed(const JointMotion& motion, const Give& give) {
    Answer answer;
    answer.microseconds =
        timeOf<std::micro>([&] { answer = give(RobotMotion::between(model_->robot, motion.from, motion.to)); });
    return answer;
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

  Answer sampledContact(const RobotMotion& motion, double contact_distance) {
    Answer answer;
    answer.t_free = 0.0;
    for (int i = 0; i < kSamples; ++i) {
      const double time = static_cast<double>(i) / (kSamples - 1);
      scene_.update(motion.at(time));
      answer.t_contact = time;
      answer.contact = scene_.first(scene_.candidates(), isAnyWithin(contact_distance)) != nullptr;
      if (answer.contact) return answer;
      answer.t_free = time;
    }
    return answer;
  }

  Answer sampledMinimum(const RobotMotion& motion) {
    Answer answer;
    answer.distance = std::numeric_limits<double>::infinity();
    for (int i = 0; i < kSamples; ++i) {
      scene_.update(motion.at(static_cast<double>(i) / (kSamples - 1)));
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

  /// Returns the sum of the speeds [m] per unit of time of the two fastest bodies, from poses all over the motion.
  double closingSpeed(const RobotMotion& motion) const {
    std::vector<double> fastest(model_->robot.bodies.size(), 0.0);
    for (int i = 0; i < 50; ++i) {
      const double time = i / 50.0;
      const BodyPoses before = motion.at(time), after = motion.at(time + kSpeedStep);
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
  MovingScene moving_;
  Scene scene_;
};

/// The answers of both ways about all motions.
struct Answers {
  std::vector<Answer> ours, sampled;
};

Answers askAll(Contest& contest, const std::vector<JointMotion>& motions, Asked asked) {
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
  const std::pair<const char*, int MotionCounts::*> counts[] = {{"pairs", &MotionCounts::pairs},
                                                                {"unknown", &MotionCounts::unknown},
                                                                {"by_one_bound", &MotionCounts::by_one_bound},
                                                                {"intervals", &MotionCounts::intervals},
                                                                {"queries", &MotionCounts::queries}};
  json means;
  for (const auto& [name, count] : counts) {
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
    if (sampled.contact && (!ours.contact || sampled.t_contact < ours.t_free)) ++contradicted;
    if (ours.contact && sampled.contact) latest = std::max(latest, sampled.t_contact - ours.t_contact);
  }
  if (asked == Asked::Minimum) return {{"max_error", above}, {"contradicted", contradicted}};
  return {{"contacts", contacts}, {"missed", missed}, {"max_late", latest}, {"contradicted", contradicted}};
}

/// Returns how many of our contacts and minima the robot's clearance at their time does not confirm.
int unconfirmed(Contest& contest, const std::vector<JointMotion>& motions, const std::vector<Answer>& ours,
                Asked asked) {
  int count = 0;
  for (std::size_t i = 0; i < motions.size(); ++i)
    if ((asked == Asked::Minimum || ours[i].contact) && !contest.isConfirmed(motions[i], asked, ours[i])) ++count;
  return count;
}

json extrapolate(Contest& contest, const std::vector<JointMotion>& motions, const Answers& answers, Asked asked) {
  std::vector<double> samples, times;
  const std::size_t stride = std::max<std::size_t>(1, motions.size() / kFineMotions);
  for (std::size_t i = 0; i < motions.size(); i += stride) {
    const double until = asked == Asked::Minimum ? 1.0 : answers.ours[i].t_contact;
    const Contest::Extrapolated fine = contest.sampledAtOurGuarantee(motions[i], asked, until);
    samples.push_back(fine.samples);
    times.push_back(fine.microseconds);
  }
  return {{"samples", medianOf(samples)}, {"median_us", medianOf(times)}};
}

void measure(json& rows, Contest& contest, const json& head, const std::vector<JointMotion>& motions, Asked asked) {
  const Answers answers = askAll(contest, motions, asked);
  json ours = head, sampled = head, fine = head;
  ours.update(timesOf(answers.ours));
  ours.update({{"library", "ours"},
               {"counts", meanCounts(answers.ours)},
               {"unconfirmed", unconfirmed(contest, motions, answers.ours, asked)}});
  sampled.update(timesOf(answers.sampled));
  sampled.update({{"library", "sampling, 1 kHz"}, {"samples", kSamples}});
  sampled.update(beside(answers, asked));
  fine.update(extrapolate(contest, motions, answers, asked));
  fine.update({{"library", "sampling, our guarantee"}, {"extrapolated", true}});
  for (const json& entry : {ours, sampled, fine}) rows.push_back(entry);
  showProgress();
}

}  // namespace

json measureMovingRobots(const std::vector<NamedRobot>& robots, int motions, const Wanted& wanted) {
  json rows = json::array();
  for (const NamedRobot& robot : robots) {
    Contest contest(robot);
    std::vector<JointMotion> drawn;
    for (const auto& [question, asked] : kAsked) {
      const std::string name = robot.name + ", " + question;
      if (!wanted(name)) continue;
      if (drawn.empty()) drawn = contest.motions(motions);
      if (drawn.empty()) continue;
      const json head = {{"row", name},
                         {"robot", robot.name},
                         {"question", question},
                         {"pairs", robot.model->pairs.checked.size()},
                         {"motions", drawn.size()}};
      measure(rows, contest, head, drawn, asked);
    }
  }
  return rows;
}

}  // namespace proximity_server::benchmark
