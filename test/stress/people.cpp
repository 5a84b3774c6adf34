// ./dev stress people: lets people run towards robots that stop, with the scale of separation().
//
// 1. Take a random state, random velocities, brakes and latency, and one or two people near the robot.
// 2. Stop the robot from its scaled velocities in fine steps of time. A link that has come nearer to the place where a
//    person was seen must not be reached while the robot moves: the person runs towards it from then on, with its
//    smaller speed until it is within kNearPerson.
// 3. The same at twice the scale: most of the people reach the robot.
#include "proximity_server/scene/separation.h"
#include "stress/controlled_robots.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

namespace proximity_server::scene {
namespace {

constexpr int kPlacesOfCell = 100;
constexpr int kSteps = 24;  // of a stop

class Cell : public StoppingCell {
 public:
  Cell(const ControlFamily& family, Chance chance, stress::Tally& tally) : StoppingCell(family, chance), tally_(tally) {
    if (!objects_) objects_ = std::make_shared<const Objects>(model_);
    std::vector<ObjectChange> changes;
    const int people = 1 + chance_.below(2);
    for (int i = 0; i < people; ++i) {
      const std::string name = "person " + std::to_string(i);
      changes.push_back(AddObject{makeObject(name, {{narrowphase::Sphere{chance_.between(0.05, 0.3)}}}, Moving{name})});
    }
    objects_ = std::make_shared<const Objects>(objects_->changed(changes));
    scene_.use(objects_);
    moving_.use(objects_);
    for (int i = 0; i < people; ++i) tracked_.push_back({objects_->find("person " + std::to_string(i))});
  }

  void observe() {
    for (int i = 0; i < kPlacesOfCell && failure.empty(); ++i) {
      if (i % 5 == 0) choosePositions();
      choosePeople();
      chooseVelocities();
      observeStop();
    }
  }

 private:
  /// The distances of a link from a person during a stop.
  struct Pair {
    const Tracked* who;
    double start, nearest;  ///< [m] from where the person was seen
  };

  void choosePeople() {
    const BodyPoses poses = forwardKinematics(model_->robot, positions_);
    for (Tracked& who : tracked_) {
      Eigen::Isometry3d& pose = *frames_[objects_->frameOf(who.object)];
      pose = chance_.oneOf(poses).value() * Eigen::Translation3d(chance_.between(0.2, 2.5) * chance_.direction());
      who.speed = chance_.between(0.0, 2.0);
      who.near_speed = who.speed * chance_.between(1.0, 1.5);
      who.older = chance_.between(-0.05, 0.2);
      who.intrusion = chance_.between(0.0, 0.1);
      who.uncertainty = chance_.between(0.0, 0.05);
    }
  }

  double allowanceFor(const Tracked& who) const { return who.intrusion + who.uncertainty + state_.largest_loss; }

  /// [s] The least time in which a person may come to a link that comes as near as this [m] to its place.
  double timeOf(const Tracked& who, double nearest) const {
    const double near = std::min(nearest, kNearPerson), far = nearest - near;
    const auto timeFor = [](double way, double speed) { return way > 0.0 ? way / speed : 0.0; };
    return timeFor(far, who.speed) + timeFor(near - allowanceFor(who), who.near_speed);
  }

  /// The distances of all that a joint moves from the places of the people, after a way.
  std::vector<std::pair<const Tracked*, double>> distancesAfter(double way) {
    place(posesAfter(way));
    std::vector<ShapeRefPair> pairs;
    std::vector<const Tracked*> people;
    objects_->forEachCheckedPair([&](const ShapeRef& a, const ShapeRef& b) {
      for (const Tracked& who : tracked_) {
        const bool is_a = a.object() == who.object;
        if (!is_a && b.object() != who.object) continue;
        const int body = scene_.state.bodyOf(is_a ? b : a);
        if (body < 0 || model_->robot.bodies[body].joint < 0) continue;
        pairs.push_back({a, b});
        people.push_back(&who);
      }
    });
    std::vector<std::pair<const Tracked*, double>> distances;
    for (const PairProximity& pair : scene_.all(Pairs(pairs)))
      distances.emplace_back(people[distances.size()], pair.result.upper_bound);
    return distances;
  }

  /// Whether somebody reaches the robot before it stands.
  bool isReached(double scale) {
    const Braked brake = brakes();
    const double duration = brake.duration(scale);
    std::vector<Pair> pairs;
    for (int step = 0; step <= kSteps; ++step) {
      const double time = duration * step / kSteps;
      const auto distances = distancesAfter(brake.wayAfter(time, scale));
      for (std::size_t i = 0; i < distances.size(); ++i) {
        const auto& [who, distance] = distances[i];
        if (step == 0) pairs.push_back({who, distance, distance});
        Pair& pair = pairs[i];
        pair.nearest = std::min(pair.nearest, distance);
        const bool has_come_nearer = pair.nearest < pair.start - kRetreatTolerance - kRounding;
        if (has_come_nearer && timeOf(*who, pair.nearest + kRounding) < time + who->older) return true;
      }
    }
    return false;
  }

  /// Whether no link comes nearer to anybody during the whole unscaled stop.
  bool isRetreat() {
    const Braked brake = brakes();
    std::vector<double> last;
    for (int step = 0; step <= kSteps; ++step) {
      const auto distances = distancesAfter(brake.wayAfter(brake.duration(1.0) * step / kSteps, 1.0));
      for (std::size_t i = 0; i < distances.size(); ++i) {
        if (step == 0) last.push_back(distances[i].second);
        if (distances[i].second < last[i] - kRounding) return false;
        last[i] = distances[i].second;
      }
    }
    return true;
  }

  void observeStop() {
    const stress::Stopwatch watch;
    place(poses_);
    const Separation answer = separation(moving_, scene_.scene, scene_.state, state_, braking_, tracked_);
    tally_.add("seconds_of_answers", watch.seconds());
    tally_.add("people");
    tally_.add("slowed", answer.scale > 0.0 && answer.scale < 1.0);
    tally_.add("halted", answer.scale == 0.0);
    tally_.add("open", answer.status != narrowphase::Status::Converged);
    if (answer.status == narrowphase::Status::Unknown) failure = "a scale is unknown";
    if (answer.margin >= 0.0 && answer.scale < 1.0) failure = "a robot is slowed that is far enough away";
    if (answer.scale > 0.0 && isReached(answer.scale))
      failure = "somebody reaches the robot before it stands, the scale is " + std::to_string(answer.scale);
    if (answer.scale > 0.0 && answer.scale <= 0.5) {
      tally_.add("doubled");
      tally_.add("met", isReached(2.0 * answer.scale));
    }
    const bool is_retreat = answer.margin < 0.0 && isRetreat();
    tally_.add("retreats", is_retreat);
    tally_.add("unneeded", is_retreat && answer.scale < 1.0);
  }

  static constexpr double kRounding = 1e-9;  // [m] the tolerance of a distance

  std::vector<Tracked> tracked_;
  stress::Tally& tally_;
};

}  // namespace
}  // namespace proximity_server::scene

namespace proximity_server::stress {

Campaign peopleCampaign() {
  using namespace scene;
  Campaign campaign{"people_stress", "Looks for people that reach a robot before it stands.", "people", "cell"};
  campaign.option = "--people";
  campaign.usual = 20000;
  campaign.cases_of_part = kPlacesOfCell;
  campaign.record_file = "recorded_people.jsonl";
  campaign.families = namesOf(controlFamilies());
  campaign.ask = [](const Part& part, Tally& tally) { askCell<Cell>(controlFamilies()[part.family], part, tally); };
  campaign.columns = {count("people", 9, "people"),
                      count("slowed", 9, "slowed"),
                      count("halted", 9, "halted"),
                      count("retreats", 9, "retreats"),
                      count("unneeded", 9, "unneeded"),
                      count("open", 8, "open"),
                      count("doubled", 8, "doubled"),
                      count("met", 8, "met"),
                      ratio("us/answer", 10, "%*.1f", "seconds_of_answers", "people", 1e6),
                      failures(8)};
  campaign.legend =
      "slowed, halted: with a scale below 1, of 0; retreats: no link comes nearer, though the margin is below 0; "
      "unneeded: of these, slowed;\n"
      "open: not Converged; doubled: robots at twice a scale of at most 0.5; met: of these, reached before they stand. "
      "A failure ends its cell.";
  return campaign;
}

}  // namespace proximity_server::stress
