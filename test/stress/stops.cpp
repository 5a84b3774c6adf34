// ./dev stress stops: stops robots, and looks at them on the way.
//
// 1. Take a random state, random velocities, brakes and latency, and stop distances near the distance of the closest
//    pair.
// 2. Move the robot with its scaled velocities for the latency, and brake, in fine steps of time. No pair may be below
//    its stop distance or, if it is too near at the start, nearer than at the start; both less than the stated
//    tolerance. No joint inequality may be broken, or if it is at the start, by more than there and its tolerance. If
//    one of them limits the scale, the robot must stop where it would be broken.
// 3. If the scale is below 1, look at the stop from the unscaled velocities in the same way: if every pair that is too
//    near moves away all the time, and no other one comes near, and the same of inequalities, the retreat was slowed.
#include "proximity_server/scene/velocity_scale.h"
#include "stress/controlled_robots.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

namespace proximity_server::scene {
namespace {

constexpr int kStopsOfCell = 100;
constexpr int kSteps = 24;  // of a stop

/// Returns parts of the time of a stop.
std::vector<double> evenSteps() {
  std::vector<double> steps;
  for (int i = 1; i <= kSteps; ++i) steps.push_back(static_cast<double>(i) / kSteps);
  return steps;
}

/// Returns parts of the time of a stop, each 2 % longer than the one before.
std::vector<double> stepsFromTheStart() {
  std::vector<double> steps;
  for (double step = 1e-8; step < 1.0; step *= 1.02) steps.push_back(step);
  steps.push_back(1.0);
  return steps;
}

class Cell : public StoppingCell {
 public:
  Cell(const ControlFamily& family, Chance chance, stress::Tally& tally)
      : StoppingCell(family, chance), tally_(tally) {}

  void observe() {
    for (int i = 0; i < kStopsOfCell && failure.empty(); ++i) {
      if (i % 5 == 0) choosePositions();
      chooseStop();
      observeStop();
    }
  }

 private:
  using Key = std::tuple<int, int, int, int>;
  static Key keyOf(const ShapeRefPair& pair) {
    return {pair.a.link(), pair.a.object(), pair.b.link(), pair.b.object()};
  }

  void chooseStop() {
    chooseVelocities();
    place(poses_);
    const auto nearestOf = [&](PairKind kind) {
      const PairProximity* nearest = scene_.minimum(Pairs(scene_.candidates(), kind));
      return nearest ? nearest->result.lower_bound : 0.0;
    };
    const auto beside = [&](double distance) {
      const double choices[] = {distance - chance_.between(0, 0.2), distance - 1e-4, distance + 1e-7,
                                distance + chance_.between(0, 0.1)};
      // Below 0 there is no first contact of closed meshes.
      const double chosen = choices[chance_.below(4)];
      return chosen < 0.0 && chance_.below(8) != 0 ? chance_.between(0, 0.05) : chosen;
    };
    stop_ = {beside(nearestOf(PairKind::OfLinks)), objects_ ? beside(nearestOf(PairKind::WithObject)) : 0.0};
  }

  double stopDistanceOf(const ShapeRefPair& pair) const { return !pair.areLinks() ? stop_.objects : stop_.links; }

  const std::vector<JointInequality>& inequalities() const { return model_->robot.inequalities; }

  /// How far the excess of an inequality is below what it may be after a way.
  double slackAfter(double way, const JointInequality& inequality) const {
    const double allowed = std::max(0.0, inequality.excess(positions_) + inequality.tolerance());
    return allowed - inequality.excess(positionsAfter(way));
  }

  void observeInequalities(const VelocityScale& answer) {
    const Braked brake = brakes();
    const double whole = brake.wayAfter(brake.duration(answer.scale), answer.scale);
    double least = 1.0;
    for (const JointInequality& inequality : inequalities()) {
      for (int step = 0; step <= kSteps; ++step)
        if (slackAfter(whole * step / kSteps, inequality) < -kRounding * 100.0) failure = "a stop breaks an inequality";
      least = std::min(least, slackAfter(whole, inequality) / inequality.tolerance());
    }
    const bool is_limiting = answer.scale > 0.0 && answer.scale < 1.0 &&
                             answer.status == narrowphase::Status::Converged &&
                             answer.pair.result.status == narrowphase::Status::Unknown;
    tally_.add("coupled", is_limiting);
    if (is_limiting && least > 1e-3) failure = "no inequality needs the scale " + std::to_string(answer.scale);
  }

  /// All pairs below a distance [m] of each kind above the stop distances.
  std::map<Key, PairProximity> near(double above) {
    std::map<Key, PairProximity> pairs;
    for (const PairKind kind : {PairKind::OfLinks, PairKind::WithObject}) {
      Question question;
      question.threshold = (kind == PairKind::OfLinks ? stop_.links : stop_.objects) + above;
      for (const PairProximity& pair : scene_.below(Pairs(scene_.candidates(), kind), question))
        pairs.emplace(keyOf(pair.asked), pair);
    }
    return pairs;
  }

  void observeStop() {
    const stress::Stopwatch watch;
    const VelocityScale answer = velocityScale(moving_, scene_.scene, scene_.state, state_, braking_, stop_);
    const bool converged = answer.status == narrowphase::Status::Converged;
    tally_.add("seconds_of_scales", watch.seconds());
    tally_.add("stops");
    tally_.add("slowed", answer.scale > 0.0 && answer.scale < 1.0);
    tally_.add("halted", answer.scale == 0.0);
    tally_.add("open", !converged);
    if (answer.status == narrowphase::Status::Unknown) failure = "a scale is unknown";
    observeInequalities(answer);
    place(poses_);
    const std::map<Key, PairProximity> too_near = near(kRetreatTolerance);
    if (answer.scale > 0.0) stopFrom(answer.scale, too_near);
    const bool is_retreat = isRetreat(too_near, evenSteps());
    tally_.add("retreats", is_retreat && !too_near.empty());
    if (answer.scale == 1.0 || !is_retreat) return;
    // A depth may grow at first, until another direction is the shortest way out.
    if (converged && isRetreat(too_near, stepsFromTheStart()))
      failure = "a retreat is slowed to " + std::to_string(answer.scale);
    const bool is_below_zero = stop_.links < 0.0 || stop_.objects < 0.0;
    tally_.add("unneeded", !converged && !is_below_zero);
  }

  void stopFrom(double scale, const std::map<Key, PairProximity>& too_near) {
    const Braked brake = brakes();
    for (int step = 0; step <= kSteps && failure.empty(); ++step) {
      place(posesAfter(brake.wayAfter(brake.duration(scale) * step / kSteps, scale)));
      for (const auto& [key, pair] : near(0.0)) {
        const auto before = too_near.find(key);
        const double least = before == too_near.end() ? stopDistanceOf(pair.asked)
                                                      : std::min(stopDistanceOf(pair.asked),
                                                                 before->second.result.lower_bound - kRetreatTolerance);
        if (pair.result.upper_bound < least - kRounding)
          failure = "a stop leads below the distance by " + std::to_string(1e9 * (least - pair.result.upper_bound)) +
                    " nm, the scale is " + std::to_string(scale);
      }
    }
  }

  /// Whether every pair that is too near only goes away during the whole unscaled stop, and no other one comes near.
  bool isRetreat(const std::map<Key, PairProximity>& too_near, const std::vector<double>& steps) {
    constexpr double kMargin = 1e-3;  // [m] by which others stay away
    const Braked brake = brakes();
    std::map<Key, double> last;
    for (const auto& [key, pair] : too_near) last[key] = pair.result.lower_bound - 1e-9;
    std::vector<double> excesses(inequalities().size(), -1e-2);
    for (std::size_t i = 0; i < excesses.size(); ++i)
      excesses[i] = std::max(excesses[i], inequalities()[i].excess(positions_));
    for (const double step : steps) {
      const double way = brake.wayAfter(brake.duration(1.0) * step, 1.0);
      for (std::size_t i = 0; i < excesses.size(); ++i)
        if (inequalities()[i].excess(positionsAfter(way)) > excesses[i]) return false;
      place(posesAfter(way));
      for (const auto& [key, pair] : near(kMargin)) {
        const auto before = last.find(key);
        if (before == last.end() || pair.result.lower_bound < before->second) return false;
        before->second = pair.result.lower_bound - 1e-9;
      }
    }
    return true;
  }

  // [m] The poses of a motion are products of screws, and those of forwardKinematics() of its joints: both are rounded,
  // in lengths of a few metres.
  static constexpr double kRounding = 1e-13;

  PairDistances stop_;
  stress::Tally& tally_;
};

}  // namespace
}  // namespace proximity_server::scene

namespace proximity_server::stress {

Campaign stopCampaign() {
  using namespace scene;
  Campaign campaign{"stop_stress", "Looks for velocity scales that end too near, and for retreats that they slow.",
                    "stops", "cell"};
  campaign.option = "--stops";
  campaign.usual = 20000;
  campaign.cases_of_part = kStopsOfCell;
  campaign.record_file = "recorded_stops.jsonl";
  campaign.families = namesOf(controlFamilies());
  campaign.ask = [](const Part& part, Tally& tally) { askCell<Cell>(controlFamilies()[part.family], part, tally); };
  campaign.columns = {count("stops", 9, "stops"),
                      count("slowed", 9, "slowed"),
                      count("halted", 9, "halted"),
                      count("coupled", 8, "coupled"),
                      count("retreats", 9, "retreats"),
                      count("open", 8, "open"),
                      count("unneeded", 9, "unneeded"),
                      ratio("us/scale", 9, "%*.1f", "seconds_of_scales", "stops", 1e6),
                      ratio("us", 8, "%*.1f", "seconds", "stops", 1e6),
                      failures(8)};
  campaign.legend =
      "slowed, halted: with a scale below 1, of 0; coupled: slowed by an inequality; retreats: from pairs that are too "
      "near; open: not Converged; "
      "unneeded: of\n"
      "these, slowed retreats with stop distances of at least 0; us/scale: time of the answer; us: with all checks. "
      "A failure ends its cell.";
  return campaign;
}

}  // namespace proximity_server::stress
