#include "stress/scene_checks.h"
#include "stress/scene_truth.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {

using narrowphase::Status;

namespace {

/// Asks one moving scene about one motion.
class MotionExaminer {
 public:
  MotionExaminer(SceneCell& cell, MotionSearch& scene, SceneObservation& seen)
      : cell_(cell), scene_(scene), seen_(seen), chance_(cell.chance()), candidates_(cell.model()->pairs) {}

  void run() {
    const Motion& motion = cell_.startMotion();
    question_.tolerance = cell_.size() * std::pow(10.0, -3 * chance_.below(4));
    kind_ = static_cast<PairKind>(chance_.below(5) % 3);
    // A search whose time is over has nothing but bounds.
    if (chance_.below(16) == 0) question_.deadline = std::chrono::steady_clock::time_point::min();
    const Pairs pairs(candidates_, kind_);
    minimum_ = scene_.minimum(pairs, motion, question_);
    chooseContactDistance();
    contact_ = scene_.timeOfContact(pairs, motion, question_);
    checkStatus();
    std::vector<double> times{0.0, contact_.t_free, 1.0};
    for (int i = 0; i < 2; ++i) times.push_back(chance_.between(0.0, 1.0));
    for (const double time : times) checkAt(time);
    if (!std::isnan(minimum_.time)) checkMinimum();
    if (contact_.contact) checkContact();
    cell_.placeAt(0.0);
    seen_.tally.add("motions");
    seen_.tally.add("contacts", contact_.contact);
    const bool converged = contact_.status == Status::Converged && minimum_.status == Status::Converged;
    seen_.tally.add("motions_open", !converged);
  }

 private:
  /// The distance is often one that is reached late, or hardly.
  void chooseContactDistance() {
    const double size = cell_.size();
    const double near = std::isfinite(minimum_.lower_bound) ? minimum_.lower_bound : 0.0;
    const double choices[] = {0.0, near + chance_.eitherSign(chance_.decades(-9, 0)) * size,
                              near + chance_.decades(-3, 0) * size, chance_.decades(-3, 0) * size};
    question_.contact_distance = choices[chance_.below(4)];
    const std::vector<ShapeRefPair> checked = cell_.checkedPairs();
    for (int i = chance_.below(3); i > 0 && !checked.empty(); --i) {
      const ShapeRefPair& pair = chance_.oneOf(checked);
      const double less = chance_.below(2) == 0 ? std::numeric_limits<double>::infinity() : chance_.decades(-3, 0);
      question_.nearer_pairs.push_back({pair, question_.contact_distance - less * size});
    }
    thresholds_ = cell_.someThresholds();
    if (thresholds_) question_.thresholds = &*thresholds_;
  }

  double contactDistanceOf(const ShapeRefPair& pair) const {
    double distance = question_.contact_distance + (thresholds_ ? thresholds_->of(pair) : 0.0);
    for (const PairContactDistance& nearer : question_.nearer_pairs)
      if (nearer.pair.isSameAs(pair)) distance = std::min(distance, nearer.contact_distance);
    return distance;
  }

  /// [m] The poses of a motion are products of screws, those of the truth products of joints.
  double rounding() const {
    double reach = cell_.size();
    for (const auto& pose : cell_.poses())
      if (pose) reach = std::max(reach, pose->translation().cwiseAbs().maxCoeff());
    for (const auto& pose : cell_.frames())
      if (pose) reach = std::max(reach, pose->translation().cwiseAbs().maxCoeff());
    return 256.0 * std::numeric_limits<double>::epsilon() * reach;
  }

  void checkStatus() {
    if (!(contact_.t_free >= 0.0 && contact_.t_free <= 1.0)) fail("t_free is outside of the motion");
    if (contact_.contact && !(contact_.t_contact >= contact_.t_free && contact_.t_contact <= 1.0))
      fail("a contact is not between t_free and the end");
    if (!contact_.contact && contact_.status == Status::Converged && contact_.t_free < 1.0)
      fail("there is no contact, but t_free is " + std::to_string(contact_.t_free));
    if (minimum_.status == Status::Converged && !(minimum_.upper_bound - minimum_.lower_bound <= question_.tolerance))
      fail("the minimum converged, but its bounds are" + by(minimum_.upper_bound - minimum_.lower_bound) + " apart");
  }

  /// No pair comes below the minimum, nor to its contact distance before t_free.
  void checkAt(double time) {
    cell_.placeAt(time);
    const double rounded = rounding();
    const StateTruth truth(cell_);
    for (const PairTruth& pair : truth.pairs()) {
      if (!pair.is_known || !isOfKind(pair.pair, kind_)) continue;
      const long double missed = minimum_.lower_bound - pair.distance.high - rounded;
      if (missed > 0) fail("the minimum is above the distance of " + nameOf(cell_, pair.pair) + by(missed) + at(time));
      const long double late = contactDistanceOf(pair.pair) - pair.distance.high - rounded;
      if (time <= contact_.t_free && late > 0 && contact_.t_free > 0.0)
        fail("a contact of " + nameOf(cell_, pair.pair) + " is missed" + by(late) + at(time));
    }
  }

  void checkPair(const std::string& who, const PairProximity& pair, double time) {
    cell_.placeAt(time);
    StateTruth truth(cell_);
    const PairTruth* known = truth.find(pair.asked);
    if (!known || !isOfKind(pair.asked, kind_))
      return fail(who + " is of a pair that is not asked for: " + nameOf(cell_, pair.asked));
    const std::string problem = problemOf(pair.result, *known, question_.tolerance, rounding());
    if (!problem.empty()) fail(who + ": " + nameOf(cell_, pair.asked) + " " + problem + at(time));
  }

  void checkMinimum() {
    checkPair("the minimum", minimum_.pair, minimum_.time);
    if (minimum_.upper_bound != minimum_.pair.result.upper_bound)
      fail("the upper bound of the minimum is not that of its pair:" +
           by(minimum_.upper_bound - minimum_.pair.result.upper_bound));
  }

  void checkContact() {
    checkPair("the contact", contact_.pair, contact_.t_contact);
    const double above =
        contact_.pair.result.lower_bound - contactDistanceOf(contact_.pair.asked) - question_.tolerance;
    if (contact_.status == Status::Converged && above > rounding())
      fail("the pair of a contact is not near" + by(above));
  }

  static std::string at(double time) { return " at " + std::to_string(time); }
  void fail(const std::string& sentence) {
    if (!seen_.failure) seen_.failure = "in motion: " + sentence;
  }

  SceneCell& cell_;
  MotionSearch& scene_;
  SceneObservation& seen_;
  Chance& chance_;
  const Candidates candidates_;
  PairKind kind_ = PairKind::Any;
  MotionQuestion question_;
  std::optional<PairDistances> thresholds_;
  RobotMinimum minimum_;
  RobotTimeOfContact contact_;
};

}  // namespace

void observeMotion(SceneCell& cell, MotionSearch& scene, SceneObservation& seen) {
  scene.use(cell.objects());
  MotionExaminer(cell, scene, seen).run();
}

}  // namespace proximity_server::scene
