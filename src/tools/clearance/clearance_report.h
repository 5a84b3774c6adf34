#pragma once

#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/levels/clearance_level.h"
#include "tools/clearance/clearance_question.h"
#include "tools/clearance/clearance_rows.h"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::tools {

/// Collects what --report shows of the answers: the smallest distance of every pair and of every state or segment, the
/// states beyond limits, and the pairs that were never checked. clearance_report.py makes a page of it.
///
/// Frame: that of the root link. Metres, radians, seconds.
class ClearanceReport {
 public:
  static constexpr std::size_t kMoments = 5;  ///< the pairs whose closest state is shown with a picture

  /// The question must outlive this.
  ClearanceReport(const ClearanceQuestion& question, RowKind rows);

  /// Takes the answer about a state, of which StateClearance::all_pairs counts; and about a segment, of which
  /// SegmentClearance::of_pairs counts too. The numbers must ascend.
  void add(const StateClearance& answer);
  void add(const SegmentClearance& answer);

  /// All facts, with the outlines of the pieces of the worst moments. Numbers that are not finite are null.
  nlohmann::ordered_json toJson() const;

 private:
  using Names = std::pair<std::string, std::string>;

  /// What is known of one pair.
  struct PairRecord {
    scene::PairProximity closest;                                ///< the first one with the smallest distance
    double lower = std::numeric_limits<double>::infinity();      ///< [m] of all states or segments
    scene::ClearanceLevel level = scene::ClearanceLevel::Clear;  ///< the worst one, if there are thresholds
    long number = -1;  ///< of the state or segment of `closest`; -1: there is no answer
    double time = std::numeric_limits<double>::quiet_NaN();
    scene::Positions positions;
    std::shared_ptr<const scene::Objects> objects;
  };
  using NamedRecord = std::pair<const Names, PairRecord>;

  /// Where and when an answer about a pair holds.
  struct Moment {
    long number;
    double time;
    const scene::Positions& positions;
    const std::shared_ptr<const scene::Objects>& objects;
  };

  /// The states that set a joint beyond its limits.
  struct Excess {
    std::uint64_t states = 0;
    long first = 0;
    double position = 0.0;  ///< of the first one
  };

  using Beyond = std::map<int, double>;  ///< positions by joint

  double take(const scene::PairProximity& pair, const Moment& moment);
  PairRecord& recordOf(const scene::ShapeRefPair& pair, const scene::Objects* objects);
  void useObjects(const std::shared_ptr<const scene::Objects>& objects);
  void countExcess(long number, const Beyond& beyond);
  Beyond beyondLimits(const scene::Positions& positions) const;
  std::vector<const NamedRecord*> sortedRecords() const;
  nlohmann::ordered_json toJson(const NamedRecord& named) const;
  nlohmann::ordered_json momentOf(const PairRecord& record) const;
  nlohmann::ordered_json uncheckedPairs() const;
  nlohmann::ordered_json limits() const;

  const ClearanceQuestion& question_;
  const RowKind rows_;
  const PairColumns numbers_;
  std::map<Names, PairRecord> records_;
  std::vector<PairRecord*> of_links_;  ///< by PairColumns; nullptr: there is none yet
  std::shared_ptr<const scene::Objects> objects_;
  std::map<Names, std::array<std::string, 2>> unchecked_;  ///< the reason and its detail
  std::uint64_t states_beyond_ = 0;
  std::map<int, Excess> beyond_;  ///< by joint
  /// The curves over the states or segments, by their names. A level is its number, -1 without an answer; contact is 1
  /// or 0, or NaN if it is not known.
  std::map<std::string, std::vector<double>> curves_;
};

}  // namespace proximity_server::tools
