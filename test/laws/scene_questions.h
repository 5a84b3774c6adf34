#pragma once

// The questions about a robot in a state, as question.h describes them.

#include "laws/question.h"
#include "proximity_server/scene/answers/assessment.h"
#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/derivative/constraint_rows.h"
#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/derivative/free_motion.h"
#include "proximity_server/scene/guaranteed/guaranteed_distances.h"
#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/motion/motion_search.h"
#include "proximity_server/scene/points/point_search.h"
#include "proximity_server/scene/points/ray_search.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/separation.h"
#include "proximity_server/scene/velocity_scale.h"
#include "scene/uncertainty/uncertain_states.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace proximity_server::scene::laws {

inline constexpr double kThreshold = 0.3;  ///< [m] some pairs are nearer, others are not

inline Question until(const Deadline& deadline, double threshold = std::numeric_limits<double>::infinity()) {
  Question question;
  question.threshold = threshold;
  question.deadline = deadline;
  return question;
}

// --- of a Scene

struct OfScene {
  explicit OfScene(const State& state) : scene(state.sharedModel()) {}
  explicit OfScene(Scene other) : scene(std::move(other)) {}
  Scene forAnotherThread() const { return scene.forAnotherThread(); }
  /// All checked pairs, unless the question is about others.
  Pairs asked() const { return pairs.empty() ? Pairs(scene.candidates()) : Pairs(pairs); }
  /// Ends an answer about all pairs.
  void seeCounts(Answer& answer) const { answer.is_known = answer.is_known && scene.counts().unknown == 0; }

  Scene scene;
  std::vector<ShapeRefPair> pairs;
};

struct Minimum : OfScene {
  static constexpr const char* kName = "Minimum";
  using OfScene::OfScene;
  void ask(const State& state, const RobotState& /*now*/, const Deadline& deadline, Answer& answer) {
    const PairProximity* found = scene.minimum(state, asked(), until(deadline));
    seeCounts(answer);
    if (found) answer.addClosest(*found);
  }
};

struct Closest : OfScene {
  static constexpr const char* kName = "Closest";
  using OfScene::OfScene;
  void ask(const State& state, const RobotState& /*now*/, const Deadline& deadline, Answer& answer) {
    const std::vector<PairProximity>& found = scene.closest(state, asked(), 5, until(deadline));
    seeCounts(answer);
    if (!found.empty()) answer.addClosest(found.front());
    answer.addAll(found);
  }
};

struct Below : OfScene {
  static constexpr const char* kName = "Below";
  using OfScene::OfScene;
  void ask(const State& state, const RobotState& /*now*/, const Deadline& deadline, Answer& answer) {
    answer.addAll(scene.below(state, asked(), until(deadline, kThreshold)));
    seeCounts(answer);
    const PairsBelow some = scene.closestBelow(state, asked(), 2, until(deadline, kThreshold));
    answer.add(some.count);
    answer.addAll(some.closest);
  }
};

/// Whether a pair is below a threshold, which may be another one each time; and whether one is as deep as none can be.
struct First : OfScene {
  static constexpr const char* kName = "First";
  using OfScene::OfScene;
  void ask(const State& state, const RobotState& /*now*/, const Deadline& deadline, Answer& answer) {
    for (const double threshold : {kThreshold, -10.0})
      answer.add(static_cast<int>(scene.first(state, asked(), until(deadline, threshold)) != nullptr));
    seeCounts(answer);
  }
};

struct All : OfScene {
  static constexpr const char* kName = "All";
  using OfScene::OfScene;
  void ask(const State& state, const RobotState& /*now*/, const Deadline& deadline, Answer& answer) {
    answer.addAll(scene.all(state, asked(), until(deadline)));
    seeCounts(answer);
  }
};

struct OnePair : OfScene {
  static constexpr const char* kName = "OnePair";
  using OfScene::OfScene;
  void ask(const State& state, const RobotState& /*now*/, const Deadline& deadline, Answer& answer) {
    const ShapeRefPair& pair = pairs.empty() ? scene.candidates().list().back() : pairs.back();
    const PairProximity found = scene.proximity(state, pair, until(deadline));
    answer.is_known = found.result.status != narrowphase::Status::Unknown;
    answer.addClosest(found);
  }
};

// --- of what is no part of a scene; in the frame of the root

struct OfPoints {
  static constexpr const char* kName = "Points";
  explicit OfPoints(const State& state) : search(state.sharedModel()) {}
  void ask(const State& state, const RobotState& now, const Deadline& deadline, Answer& answer) {
    points.centres.clear();
    const Eigen::Isometry3d root = now.poses.front().value_or(Eigen::Isometry3d::Identity());
    for (const double x : {-0.7, 0.1, 0.6})
      for (const double z : {0.2, 1.1}) points.centres.push_back(root * Eigen::Vector3d(x, 0.3, z));
    const std::vector<PairProximity>& found = search.closest(state, points, until(deadline));
    answer.addAll(found);
    answer.is_known = search.unplaced().empty() && search.counts().unknown == 0;
    if (answer.is_known) answer.addClosest(found.front());
  }
  PointSearch search;
  Points points;
};

struct OfRays {
  static constexpr const char* kName = "Rays";
  explicit OfRays(const State& state) : search(state.sharedModel()) {}
  void ask(const State& state, const RobotState& now, const Deadline& deadline, Answer& answer) {
    rays.clear();
    const Eigen::Isometry3d root = now.poses.front().value_or(Eigen::Isometry3d::Identity());
    for (const double z : {0.0, 0.3, 0.7})
      rays.push_back({root * Eigen::Vector3d(-2.0, 0.02, z), root.linear() * Eigen::Vector3d(1.0, 0.0, 0.1), 5.0});
    const std::vector<RayHit>& found = search.firstHits(state, rays, shapes, until(deadline));
    answer.is_known = search.unplaced().empty();
    for (const RayHit& hit : found) {
      answer.is_known = answer.is_known && hit.status == narrowphase::Status::Converged;
      answer.add(hit.shape);
      for (const double number : {static_cast<double>(hit.status), hit.free, hit.distance}) answer.add(number);
      answer.add(hit.normal);
    }
    answer.lower = found.front().free;
    if (found.front().shape.kind() != ShapeRef::Kind::None) answer.upper = found.front().distance;
  }
  RaySearch search;
  std::vector<Ray> rays;
  const std::vector<ShapeRef> shapes;
};

// --- for controllers

struct OfGradients : OfScene {
  static constexpr const char* kName = "Gradients";
  explicit OfGradients(const State& state) : OfScene(state), derivatives(state.sharedModel()) {}
  void ask(const State& state, const RobotState& /*now*/, const Deadline& /*deadline*/, Answer& answer) {
    row.resize(state.degreesOfFreedom().size());
    ones.setOnes(row.size());
    for (const PairProximity& pair : scene.all(state, asked())) {
      answer.is_known = gradient(state, pair, row) && answer.is_known;
      answer.add(row);
      answer.add(derivatives.rate(state, pair, ones));
    }
  }
  Scene forAnotherThread() const = delete;
  Derivatives derivatives;
  Eigen::VectorXd row, ones;
};

struct OfRows : OfScene {
  static constexpr const char* kName = "ConstraintRows";
  explicit OfRows(const State& state) : OfScene(state), rows(state.sharedModel(), 4), place(rows.matrix().data()) {}
  void ask(const State& state, const RobotState& /*now*/, const Deadline& /*deadline*/, Answer& answer) {
    rows.find(scene, state, damper);
    answer.is_known = rows.unknown() == 0 && rows.matrix().data() == place;
    answer.add(rows.matrix());
    answer.add(rows.bounds());
    for (const int number : {rows.leftOut(), rows.unneeded(), rows.stuckCount()}) answer.add(number);
  }
  Scene forAnotherThread() const = delete;
  ConstraintRows rows;
  const double* place;  ///< of the matrix, which never changes
  const VelocityDamper damper{{0.02, 0.04}, kThreshold, 0.5};
};

struct OfFreeMotion : OfScene {
  static constexpr const char* kName = "FreeMotion";
  explicit OfFreeMotion(const State& state) : OfScene(state), free(state.sharedModel()) {}
  void ask(const State& state, const RobotState& /*now*/, const Deadline& deadline, Answer& answer) {
    FreeMotionQuestion question;
    question.deadline = deadline;
    free.find(scene, state, question);
    ones.setOnes(state.degreesOfFreedom().size());
    answer.is_known = free.isKnown();
    answer.lower = free.scale(ones);
    answer.upper = free.isKnown() ? answer.lower + 1e-9 : 1.0;
    answer.add(answer.lower);
    for (int column = 0; column < ones.size(); ++column) answer.add(free.alone(column));
  }
  Scene forAnotherThread() const = delete;
  FreeMotion free;
  Eigen::VectorXd ones;
};

// --- in states that are not known exactly

struct OfGuaranteed : OfScene {
  static constexpr const char* kName = "Guaranteed";
  explicit OfGuaranteed(const State& state) : OfScene(state), distances(state.sharedModel()) {
    Chance chance(43);
    distances.assume(someUncertainty(state.robot(), 1e-2, 1e-3, chance));
  }
  void ask(const State& state, const RobotState& /*now*/, const Deadline& deadline, Answer& answer) {
    distances.forget();
    GuaranteeLimits limits;
    limits.deadline = deadline;
    distances.limit(limits);
    const GuaranteedMinimum minimum = distances.find(scene, state, asked(), {}, until(deadline));
    answer.add(minimum.pair);
    for (const double number : {minimum.guaranteed, minimum.excess, distances.largestLoss(state)}) answer.add(number);
    answer.add(distances.of(state, minimum.pair));  // with what the bound of before has left
    answer.is_known = minimum.unknown == 0 && distances.end() == GuaranteeEnd::None;
    answer.lower = minimum.unknown == 0 ? minimum.excess : answer.lower;
    if (answer.is_known) answer.upper = minimum.pair.result.upper_bound;
  }
  Scene forAnotherThread() const = delete;
  GuaranteedDistances distances;
};

struct OfAssessment : OfScene {
  static constexpr const char* kName = "Assessment";
  explicit OfAssessment(const State& state) : OfScene(state), distances(state.sharedModel()) {
    distances.assume(uncertaintyOfJoints(state.robot(), 0.01));
    thresholds.stop = PairDistances(0.02, 0.02);
    thresholds.warn = PairDistances(0.2, 0.2);
  }
  void ask(const State& state, const RobotState& now, const Deadline& deadline, Answer& answer) {
    distances.forget();
    stated.assign(now.positions.begin(), now.positions.end());
    AssessmentQuestion question{thresholds, stated, until(deadline, kThreshold)};
    question.most_listed = 3;
    question.guaranteed = &distances;
    question.wants_gradients = true;
    assess(scene, state, question, found);
    answer.is_known = found.counts.unknown == 0 && found.level;
    answer.addAll(found.listed);
    answer.addClosest(found.minimum.pair);
    answer.add(found.deciding.pair);
    for (const AssessedPair* pair : {&found.minimum, &found.deciding}) {
      answer.add(pair->guaranteed);
      for (const double number : pair->gradient) answer.add(number);
    }
    answer.add(found.level ? static_cast<int>(found.level->level) : -1);
  }
  Scene forAnotherThread() const = delete;
  GuaranteedDistances distances;
  LevelThresholds thresholds;
  std::vector<std::optional<double>> stated;
  Assessment found;
};

// --- in motion: every second joint moves forwards and the others backwards, and frames of objects rest

struct OfMotion {
  explicit OfMotion(const State& state) : search(state), candidates(state.model().pairs) {}
  OfMotion(MotionSearch other) : search(std::move(other)), candidates(search.model().pairs) {}  // NOLINT: implicit
  MotionSearch forAnotherThread() const { return search.forAnotherThread(); }
  Pairs asked() const { return pairs.empty() ? Pairs(candidates) : Pairs(pairs); }

  static RobotMotion::ObjectFrames framesOf(const RobotState& now) {
    RobotMotion::ObjectFrames frames;
    for (const auto& pose : now.frames) frames.moving.push_back(RobotMotion::atRest(pose));
    return frames;
  }
  static std::vector<double> velocities(const RobotModel& robot) {
    std::vector<double> all(robot.joints.size(), 0.4);
    for (std::size_t i = 0; i < all.size(); i += 2) all[i] = -0.6;
    return all;
  }
  static Motion motionFrom(const State& state, const RobotState& now) {
    RobotMotion motion = RobotMotion::ofTravel(state.robot(), state.poses(), velocities(state.robot()));
    motion.carryObjects(framesOf(now));
    return motion;
  }

  MotionSearch search;
  Candidates candidates;
  std::vector<ShapeRefPair> pairs;
};

struct OfContact : OfMotion {
  static constexpr const char* kName = "Contact";
  using OfMotion::OfMotion;
  void ask(const State& state, const RobotState& now, const Deadline& deadline, Answer& answer) {
    MotionQuestion question;
    question.deadline = deadline;
    const RobotTimeOfContact found = search.timeOfContact(asked(), motionFrom(state, now), question);
    answer.is_known = found.status == narrowphase::Status::Converged && found.counts.unknown == 0;
    answer.addClosest(found.pair);
    answer.lower = -std::numeric_limits<double>::infinity();
    answer.add(found.t_free);
    answer.add(found.t_contact);
    if (found.counts.unknown == 0) answer.lower = found.t_free;
    if (found.contact) answer.upper = found.t_contact + question.tolerance;
  }
};

struct OfMinimumOfMotion : OfMotion {
  static constexpr const char* kName = "MinimumOfMotion";
  using OfMotion::OfMotion;
  void ask(const State& state, const RobotState& now, const Deadline& deadline, Answer& answer) {
    MotionQuestion question;
    question.deadline = deadline;
    const RobotMinimum found = search.minimum(asked(), motionFrom(state, now), question);
    answer.is_known = found.status == narrowphase::Status::Converged && found.counts.unknown == 0;
    answer.addClosest(found.pair);
    answer.lower = -std::numeric_limits<double>::infinity();
    answer.add(found.time);
    if (found.counts.unknown == 0) answer.lower = found.lower_bound;  // otherwise it is that of the others
    answer.upper = found.upper_bound;
  }
};

/// In this and the next one two answers may differ by the tolerance of the scale.
struct OfVelocityScale {
  static constexpr const char* kName = "VelocityScale";
  explicit OfVelocityScale(const State& state) : search(state), scene(state.sharedModel()) {
    moving.velocities = OfMotion::velocities(state.robot());
    braking = {0.2, std::vector<double>(state.robot().joints.size(), 1.0)};
  }
  void ask(const State& state, const RobotState& now, const Deadline& deadline, Answer& answer) {
    moving.frames = OfMotion::framesOf(now);
    const VelocityScale found = velocityScale(search, scene, state, moving, braking, {0.02, 0.02}, deadline);
    answer.is_known = found.status == narrowphase::Status::Converged;
    answer.add(found.scale);  // of several pairs that limit it, any is named
    answer.lower = found.scale;
    answer.upper = answer.is_known ? found.scale + kScaleTolerance : 1.0;
  }
  MotionSearch search;
  Scene scene;
  MovingState moving;
  Braking braking;
};

struct OfSeparation : OfVelocityScale {
  static constexpr const char* kName = "Separation";
  explicit OfSeparation(const State& state) : OfVelocityScale(state), tracked{{state.objects()->find("ball")}} {}
  void ask(const State& state, const RobotState& now, const Deadline& deadline, Answer& answer) {
    moving.frames = OfMotion::framesOf(now);
    const Separation found = separation(search, scene, state, moving, braking, tracked, deadline);
    answer.is_known = found.status == narrowphase::Status::Converged;
    answer.add(found.pair);
    for (const double number : {found.margin, found.scale, found.protective_distance}) answer.add(number);
    answer.lower = found.scale;
    answer.upper = answer.is_known ? found.scale + kScaleTolerance : 1.0;
  }
  const std::vector<Tracked> tracked;
};

// --- of many states: the state and others near it; frames of objects are links

struct OfBatch {
  explicit OfBatch(const State& state) : batch(state.sharedModel()) { batch.use(state.objects()); }
  explicit OfBatch(SceneBatch other) : batch(std::move(other)) {}
  SceneBatch forAnotherThread() const { return batch.forAnotherThread(); }
  const Eigen::MatrixXd& statesNear(const RobotState& now) {
    states.resize(9, static_cast<Eigen::Index>(now.positions.size()));
    for (Eigen::Index i = 0; i < states.rows(); ++i)
      for (Eigen::Index j = 0; j < states.cols(); ++j)
        states(i, j) = (1.0 - 0.05 * static_cast<double>(i)) * now.positions[static_cast<std::size_t>(j)];
    return states;
  }
  /// The bounds are those of the state itself.
  static void addMinima(const std::vector<PairProximity>& minima, Answer& answer) {
    for (const PairProximity& found : minima)
      answer.is_known = answer.is_known && found.result.status != narrowphase::Status::Unknown;
    answer.addAll(minima);
    answer.addClosest(minima.front());
  }
  static void addLists(const StatePairs& lists, Answer& answer) {
    answer.addAll(lists.pairs);
    for (const std::size_t begin : lists.begins) answer.add(static_cast<double>(begin));
    for (const unsigned char unknown : lists.unknown) answer.is_known = answer.is_known && unknown == 0;
  }

  SceneBatch batch;
  Eigen::MatrixXd states;
};

struct BatchMinimum : OfBatch {
  static constexpr const char* kName = "BatchMinimum";
  using OfBatch::OfBatch;
  void ask(const State& /*state*/, const RobotState& now, const Deadline& deadline, Answer& answer) {
    addMinima(batch.minimum(statesNear(now), deadline), answer);
  }
};

struct BatchMinimumWithin : OfBatch {
  static constexpr const char* kName = "BatchMinimumWithin";
  using OfBatch::OfBatch;
  void ask(const State& /*state*/, const RobotState& now, const Deadline& deadline, Answer& answer) {
    addMinima(batch.minimumWithin(statesNear(now), 1e-4, deadline), answer);
  }
};

struct BatchDeciding : OfBatch {
  static constexpr const char* kName = "BatchDeciding";
  using OfBatch::OfBatch;
  void ask(const State& /*state*/, const RobotState& now, const Deadline& deadline, Answer& answer) {
    addMinima(batch.deciding(statesNear(now), thresholds, deadline), answer);
  }
  const LevelThresholds thresholds{};
};

struct BatchClosest : OfBatch {
  static constexpr const char* kName = "BatchClosest";
  using OfBatch::OfBatch;
  void ask(const State& /*state*/, const RobotState& now, const Deadline& deadline, Answer& answer) {
    addLists(batch.closest(statesNear(now), 3, deadline), answer);
  }
};

struct BatchBelow : OfBatch {
  static constexpr const char* kName = "BatchBelow";
  using OfBatch::OfBatch;
  void ask(const State& /*state*/, const RobotState& now, const Deadline& deadline, Answer& answer) {
    addLists(batch.below(statesNear(now), kThreshold, deadline), answer);
  }
};

struct BatchVerdict : OfBatch {
  static constexpr const char* kName = "BatchVerdict";
  using OfBatch::OfBatch;
  void ask(const State& /*state*/, const RobotState& now, const Deadline& deadline, Answer& answer) {
    for (const StateVerdict& verdict : batch.anyBelow(statesNear(now), 0.05, deadline)) {
      answer.is_known = answer.is_known && verdict.kind != StateVerdict::Kind::Unknown;
      answer.add(static_cast<int>(verdict.kind));
      answer.add(verdict.pair);
    }
  }
};

}  // namespace proximity_server::scene::laws
