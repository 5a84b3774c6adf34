// Time of contact of two moving solids, and of moving robots, beside FCL and beside sampling: the same motions for
// every library, interleaved round by round. The results go into a JSON file, with the errors against a bisection that
// leaves out no interval without proof. ./dev bench motion runs it pinned.
#include "benchmark/benchmark_main.h"
#include "benchmark/moving_robots.h"
#include "benchmark/timing.h"
#include "oracle/oracle.h"
#include "peers/aborts.h"
#include "peers/motion_library.h"
#include "peers/robots.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <numeric>
#include <optional>

namespace proximity_server::benchmark {

using namespace narrowphase;
using namespace scene;
using namespace peers;
namespace {

using nlohmann::json;

constexpr int kRounds = 5;
constexpr std::size_t kSolids = 20;
constexpr double kRoundSeconds = 0.5;    // of one library in one round, at most; fewer motions if that takes longer
constexpr std::size_t kFewest = 20;      // motions in a round
constexpr double kLateDepth = 1e-12;     // [m] of solids of size 1; less may be rounding
constexpr std::size_t kJudged = 3;       // motions of a row whose reference the oracle checks
constexpr double kOracleDoubt = 1e-11;   // [m] how far the reference's distance may lie from the oracle's
constexpr int kReferenceSamples = 2000;  // for the smallest distance
constexpr double kOursTolerance = 1e-9;  // [m] the default

struct Pairing {
  std::string name;
  std::function<Solid(Random&)> make;
};

std::vector<Pairing> pairings() {
  return {{"box", randomBox},           {"capsule", randomCapsule},
          {"cylinder", randomCylinder}, {"hull 32", [](Random& random) { return randomHull(random, 32); }},
          {"plate", randomPlate},       {"hull 200", [](Random& random) { return randomHull(random, 200); }}};
}

using NamedKind = std::pair<const char*, MotionKind>;
using NamedOutcome = std::pair<const char*, Outcome>;

const NamedKind kKinds[] = {
    {"translation", MotionKind::Translation}, {"linear", MotionKind::Linear}, {"screw", MotionKind::Screw}};
const NamedOutcome kOutcomes[] = {{"hit", Outcome::Hit}, {"miss", Outcome::Miss}, {"grazing", Outcome::Grazing}};

/// Motions of one row, the same on every run.
struct Row {
  std::string name, pair, motion, outcome;
  std::deque<Solid> solids;
  std::vector<MovingSolidPair> motions;
  std::vector<FirstContact> truth;

  json head() const {
    return {{"row", name}, {"pair", pair}, {"motion", motion}, {"outcome", outcome}, {"motions", motions.size()}};
  }
};

/// Checks the reference of one motion by the oracle of the tests: apart before the contact and not after.
void judge(const MovingSolidPair& pair, const FirstContact& truth) {
  const auto oracleAt = [&](double time) {
    const Eigen::Isometry3d a_T_b = pair.poseOfBInA(time);
    return static_cast<double>(signedDistanceOracle({pair.a.solid->ours, pair.b.solid->ours, a_T_b}).distance);
  };
  for (int i = 0; i < 5; ++i)
    if (oracleAt(truth.from * i / 5.0) <= 0.0) throw std::logic_error("the reference missed a contact");
  if (truth.contact && std::abs(oracleAt(truth.to)) > kOracleDoubt)
    throw std::logic_error("the oracle sees no contact where the reference does");
}

std::string rowName(const Pairing& pairing, const NamedKind& kind, const NamedOutcome& outcome) {
  return pairing.name + ", " + kind.first + ", " + outcome.first;
}

Row makeRow(const Pairing& pairing, const NamedKind& kind, const NamedOutcome& outcome, int motions) {
  Row row{rowName(pairing, kind, outcome), pairing.name, kind.first, outcome.first, {}, {}, {}};
  Random random(21);
  for (std::size_t i = 0; i < 2 * kSolids; ++i) row.solids.push_back(pairing.make(random));
  for (std::size_t i = 0; i < static_cast<std::size_t>(motions); ++i) {
    const Solid& a = row.solids[i % kSolids];
    const Solid& b = row.solids[kSolids + i / kSolids % kSolids];
    row.motions.push_back(randomMotion(a, b, kind.second, outcome.second, random));
    row.truth.push_back(firstContactOf(row.motions.back()));
    if (i < kJudged) judge(row.motions.back(), row.truth.back());
  }
  return row;
}

/// A library at work on the motions of a row.
template <typename Library>
class Run {
 public:
  using Answer = decltype(std::declval<Library>().ask(std::declval<const MovingSolidPair&>()));

  Run(const Library& library, const Row& row) : library_(library), row_(row) {
    for (const MovingSolidPair& pair : row.motions) answers_.push_back(answerOf([&] { return library.ask(pair); }));
    for (std::size_t i = 0; i < answers_.size(); ++i)
      if (answers_[i]) timed_.push_back(i);
    if (timed_.empty()) return;
    const std::size_t few = std::min(kFewest, timed_.size());
    double seconds = 0.0;
    for (std::size_t i = 0; i < few; ++i) seconds += 1e-9 * ask(timed_[i]);
    const double affordable = kRoundSeconds * static_cast<double>(few) / seconds;
    timed_.resize(
        static_cast<std::size_t>(std::clamp(affordable, static_cast<double>(few), static_cast<double>(timed_.size()))));
    times_ = Rounds(timed_.size());
  }

  const Library& library() const { return library_; }
  const std::vector<std::optional<Answer>>& answers() const { return answers_; }
  bool isTimed() const { return !timed_.empty(); }

  /// Makes one pass, in which each motion is timed by itself.
  void time() {
    for (std::size_t i = 0; i < timed_.size(); ++i) times_.add(i, ask(timed_[i]));
  }

  json result() const {
    json entry = row_.head();
    entry.update({{"library", library_.name},
                  {"setting", library_.setting},
                  {"timed", timed_.size()},
                  {"unanswered", std::count(answers_.begin(), answers_.end(), std::nullopt)}});
    if (!isTimed()) return entry;
    const std::vector<double> medians = times_.medians();
    const double mean = std::accumulate(medians.begin(), medians.end(), 0.0) / static_cast<double>(medians.size());
    entry.update({{"ns", medianOf(medians)}, {"p99_ns", quantile(medians, 0.99)}, {"mean_ns", mean}});
    return entry;
  }

 private:
  /// Returns the time [ns].
  double ask(std::size_t motion) const {
    [[maybe_unused]] volatile int sink = 0;
    return timeOf<std::nano>([&] { sink = library_.ask(row_.motions[motion]).queries; });
  }

  const Library& library_;
  const Row& row_;
  std::vector<std::optional<Answer>> answers_;
  std::vector<std::size_t> timed_;
  Rounds times_;  // [ns] by timed motion
};

template <typename Library>
std::vector<Run<Library>> timedRuns(const Row& row, const std::vector<Library>& libraries) {
  std::vector<Run<Library>> runs;
  for (const Library& library : libraries) runs.emplace_back(library, row);
  for (int round = 0; round < kRounds; ++round)
    for (Run<Library>& run : runs) run.time();
  return runs;
}

/// Largest and mean of some errors.
class Errors {
 public:
  void add(double error) {
    largest_ = std::max(largest_, error);
    sum_ += error;
    ++count_;
  }
  double largest() const { return largest_; }
  double mean() const { return count_ > 0 ? sum_ / count_ : 0.0; }

 private:
  double largest_ = 0.0, sum_ = 0.0;
  int count_ = 0;
};

/// Returns whether they overlap by more than rounding at one of some times from one to the other.
bool overlapsBetween(const MovingSolidPair& pair, double begin, double end) {
  for (int i = 1; i <= 8 && end > begin; ++i)
    if (signedDistanceAt(pair, begin + (end - begin) * i / 8.0).distance < -kLateDepth) return true;
  return false;
}

/// How well a library knows the time of contact. Its error is that of the worse end of its answer [t_free, t_contact];
/// as a distance it is how far from contact the solids are at that time. Late: it says that there is no contact for a
/// time in which the solids overlap.
class ContactErrors {
 public:
  void compare(const MovingSolidPair& pair, const FirstContact& truth, const ContactAnswer& answer) {
    queries_.add(answer.queries);
    if (!answer.decided) ++undecided_;
    if (answer.contact && !truth.contact) ++false_;
    if (!truth.contact) return;
    ++contacts_;
    if (!answer.contact && answer.decided) ++missed_;
    if ((answer.contact || !answer.decided) && overlapsBetween(pair, truth.to, answer.t_free)) ++late_;
    if (answer.contact) addErrors(pair, truth, answer);
  }

  json summary() const {
    return {{"contacts", contacts_},
            {"missed", missed_},
            {"late", late_},
            {"false", false_},
            {"undecided", undecided_},
            {"max_time_error", time_.largest()},
            {"mean_time_error", time_.mean()},
            {"max_error", distance_.largest()},
            {"mean_error", distance_.mean()},
            {"queries", queries_.mean()}};
  }

 private:
  void addErrors(const MovingSolidPair& pair, const FirstContact& truth, const ContactAnswer& answer) {
    double time_error = 0.0, distance = 0.0;
    for (const double time : {answer.t_free, answer.t_contact}) {
      time_error = std::max({time_error, truth.from - time, time - truth.to});
      distance = std::max(distance, std::abs(signedDistanceAt(pair, time).distance));
    }
    time_.add(time_error);
    distance_.add(distance);
  }

  int contacts_ = 0, missed_ = 0, late_ = 0, false_ = 0, undecided_ = 0;
  Errors time_, distance_, queries_;
};

/// Returns how many samples within the default tolerance of ours sampling would need until the contact: the mean of the
/// row.
double samplesForOurTolerance(const Row& row) {
  double sum = 0.0;
  for (std::size_t i = 0; i < row.motions.size(); ++i)
    sum += row.truth[i].to * row.motions[i].speedBound() / kOursTolerance;
  return sum / static_cast<double>(row.motions.size());
}

/// Returns one entry a library.
json measureContacts(const Row& row, const std::vector<ContactLibrary>& libraries) {
  json entries = json::array();
  for (const Run<ContactLibrary>& run : timedRuns(row, libraries)) {
    ContactErrors errors;
    for (std::size_t i = 0; i < row.motions.size(); ++i)
      if (run.answers()[i]) errors.compare(row.motions[i], row.truth[i], *run.answers()[i]);
    json entry = run.result();
    entry.update(errors.summary());
    if (run.library().name == "sampling" && run.isTimed()) {
      const double samples = samplesForOurTolerance(row);
      const double ns_a_sample = entry["mean_ns"].get<double>() / entry["queries"].get<double>();
      entry.update({{"samples_for_tolerance", samples}, {"ns_for_tolerance", samples * ns_a_sample}});
    }
    entries.push_back(entry);
  }
  showProgress();
  return entries;
}

/// Errors of the smallest distance, above the reference's: it is one of the distances during the motion. "below": how
/// much lower an answer was, which the reference did not find; "unproven": lower bounds above the reference.
json measureMinimum(const Row& row, const std::vector<MinimumLibrary>& libraries) {
  std::vector<double> truth;
  for (const MovingSolidPair& pair : row.motions) truth.push_back(lowestOf(pair, kReferenceSamples).distance);
  json entries = json::array();
  for (const Run<MinimumLibrary>& run : timedRuns(row, libraries)) {
    Errors above, below, queries;
    int unproven = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (!run.answers()[i]) continue;
      const MinimumAnswer& answer = *run.answers()[i];
      above.add(std::max(0.0, answer.distance - truth[i]));
      below.add(std::max(0.0, truth[i] - answer.distance));
      queries.add(answer.queries);
      // The reference ends with the square root of an epsilon in time, and with our default tolerance of the distance.
      if (answer.lower_bound > truth[i] + kOursTolerance) ++unproven;
    }
    json entry = run.result();
    entry.update({{"max_error", above.largest()},
                  {"mean_error", above.mean()},
                  {"below", below.largest()},
                  {"unproven", unproven},
                  {"queries", queries.mean()}});
    entries.push_back(entry);
  }
  showProgress();
  return entries;
}

/// Measures the wanted rows of pairs of solids.
json measurePairs(int motions, const Wanted& wanted) {
  json result = {{"rows", json::array()}, {"tolerances", json::array()}, {"minimum", json::array()}};
  const std::vector<ContactLibrary> libraries = contactLibraries(), tuned = tunedContactLibraries();
  const std::vector<MinimumLibrary> minimum = minimumLibraries();
  for (const Pairing& pairing : pairings())
    for (const auto& kind : kKinds)
      for (const auto& outcome : kOutcomes) {
        if (!wanted(rowName(pairing, kind, outcome))) continue;
        Row row = makeRow(pairing, kind, outcome, motions);
        append(result["rows"], measureContacts(row, libraries));
        row.motions.resize(std::min<std::size_t>(row.motions.size(), 100), row.motions.front());
        if (outcome.second == Outcome::Hit) append(result["tolerances"], measureContacts(row, tuned));
        if (outcome.second == Outcome::Miss) append(result["minimum"], measureMinimum(row, minimum));
      }
  return result;
}

}  // namespace
}  // namespace proximity_server::benchmark

int main(int argc, char** argv) {
  using namespace proximity_server::benchmark;
  proximity_server::tools::ProgramOptions program(
      "motion_benchmark", "Time of contact of moving solids and robots, beside FCL and sampling");
  int motions = 400;
  addPositive(program, "--motions", motions, "of each row");
  return benchmarkMain(program, argc, argv, [&](const Wanted& wanted) {
    nlohmann::json result = measurePairs(motions, wanted);
    result["robots"] = measureMovingRobots(robotsToMeasure(), motions, wanted);
    return result;
  });
}
