#pragma once

#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "tools/sweep/output_format.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::tools {

/// Whether each state has the smallest of its listed distances, or only a verdict whether something is below a
/// distance.
enum class SummaryKind : unsigned char { Distances, Verdicts };

/// A state that is worth to be looked at.
struct NotableState {
  NumberedPair closest;
  std::string link_a, link_b;
  nlohmann::ordered_json positions;  ///< positions of the joints that lead, by their names
};

/// The results of a sweep, in numbers that do not depend on how it was divided: they are counts, and states in a total
/// order. So the summary of merged parts has the bytes of the summary of the whole.
struct SweepSummary {
  static constexpr std::size_t kNotable = 10;
  using Names = std::pair<std::string, std::string>;

  SummaryKind kind = SummaryKind::Distances;
  std::uint64_t states = 0;
  std::uint64_t unknown = 0;   ///< states without an answer
  std::uint64_t unlisted = 0;  ///< states in which no pair is listed
  std::uint64_t below = 0;     ///< not proven to be above: of Distances above 0, of Verdicts above the distance
  std::map<int, std::uint64_t> histogram;                 ///< states by bin, see SummaryCounter; for Distances
  std::map<scene::ClearanceLevel, std::uint64_t> levels;  ///< states by level, where it is known
  std::vector<NotableState> notable;     ///< the closest, the first of equals first; of Verdicts the first below
  std::map<Names, std::uint64_t> pairs;  ///< the number of states in which it is the closest, or the one that was found

  void add(const SweepSummary& other);

  nlohmann::ordered_json toJson() const;
  /// Throws std::invalid_argument if this is no summary.
  static SweepSummary fromJson(const nlohmann::ordered_json& json);

  /// One or two lines for people.
  std::string text() const;
};

/// Counts the states of one thread. Nothing is allocated for a state, except the first time that something is in a bin.
///
/// A bin is 1 cm wide: bin n has the distances from n / 100 up to, but not including, (n + 1) / 100. All below -10 m
/// and from 10 m on are in the outermost bins.
class SummaryCounter {
 public:
  explicit SummaryCounter(SummaryKind kind) : bins_(kBins, 0) { counts_.kind = kind; }

  void addUnknown() {
    ++counts_.states;
    ++counts_.unknown;
  }
  void addUnlisted() {
    ++counts_.states;
    ++counts_.unlisted;
  }

  /// The level of a state that is added besides.
  void addLevel(scene::ClearanceLevel level) { ++counts_.levels[level]; }

  /// A state with its closest pair; of Verdicts one that is below. `namesOf()` gives the names of the two, which may have
  /// no number, and `positionsOf()` the positions of all joints.
  template <typename NamesOf, typename PositionsOf>
  void add(const NumberedPair& closest, const NamesOf& namesOf, const PositionsOf& positionsOf) {
    count(closest);
    if (closest.pair < 0) ++counts_.pairs[namesOf()];
    if (isNotable(closest)) keep({closest, namesOf(), positionsOf()});
  }

  /// `namesOf(pair)` gives the names of the two of a pair that has a number.
  template <typename NamesOf>
  SweepSummary summary(const scene::RobotModel& robot, const NamesOf& namesOf) const {
    SweepSummary made = withoutNumbers(robot);
    for (std::size_t pair = 0; pair < by_pair_.size(); ++pair)
      if (by_pair_[pair] > 0) made.pairs[namesOf(static_cast<int>(pair))] += by_pair_[pair];
    return made;
  }

  static constexpr int kOutermost = 1000;  ///< the bins are -kOutermost - 1 to kOutermost
  static int binOf(double distance);

 private:
  static constexpr std::size_t kBins = 2 * kOutermost + 2;
  struct Notable {
    NumberedPair closest;
    SweepSummary::Names names;
    scene::Positions positions;
  };

  void count(const NumberedPair& closest);
  bool isNotable(const NumberedPair& closest) const;
  void keep(const Notable& notable);
  SweepSummary withoutNumbers(const scene::RobotModel& robot) const;

  SweepSummary counts_;  ///< without what follows
  std::vector<std::uint64_t> bins_, by_pair_;
  std::vector<Notable> notable_;  ///< sorted
};

}  // namespace proximity_server::tools
