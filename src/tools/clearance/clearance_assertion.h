#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>

#include "tools/clearance/clearance_rows.h"
#include "tools/clearance/clearance_run.h"
#include "tools/clearance/trajectory_run.h"

namespace proximity_server::tools {

/// Whether a robot is proven to keep a distance from itself, in every state or segment that it was told of.
///
/// A state or segment is proven where the lower bound of its smallest signed distance is above the wanted distance, and
/// something is known of every pair. Where there is none at all nothing is proven.
class ClearanceAssertion {
 public:
  /// `distance` [m] is what to stay above; `pairs` is how many are checked. The robot must outlive this.
  ClearanceAssertion(double distance, RowKind kind, const scene::RobotModel& robot, std::size_t pairs)
      : distance_(distance), kind_(kind), robot_(robot), pairs_(pairs) {}

  void take(const StateClearance& answer);
  void take(const SegmentClearance& answer);

  bool hasRows() const { return rows_ > 0; }
  bool holds() const { return hasRows() && !first_; }

  /// For people, where there are rows: what was proven; or how many are not and why, the first of them, and the worst,
  /// which is the one with the smallest upper bound.
  std::string report() const;

 private:
  enum class Verdict : unsigned char {
    Proven,
    TooClose,   ///< the upper bound is at the distance or below
    Enclosed,   ///< the bounds, within the tolerance of each other, lie on either side of the distance
    Undecided,  ///< so do bounds that the budget of the search left farther apart
    Unknown     ///< nothing is known of some pair
  };
  static constexpr std::size_t kVerdicts = 5;

  /// The smallest distance of a state or segment.
  struct Row {
    long number = 0;
    std::string place;         ///< begin and end of a segment, and when it is that close
    scene::ShapeRefPair pair;  ///< the closest; no links where nothing is known
    double distance = std::numeric_limits<double>::quiet_NaN();     ///< [m]
    double lower_bound = -std::numeric_limits<double>::infinity();  ///< [m] of all pairs
    double upper_bound = std::numeric_limits<double>::infinity();   ///< [m]
    narrowphase::Status status = narrowphase::Status::Unknown;
    int unknown_pairs = 0;
    std::string joints;  ///< those that move the pair, at their positions; "" where they are many
    Verdict verdict = Verdict::Unknown;
  };
  void add(Row row, const scene::Positions& positions);
  Verdict verdictOf(const Row& row) const;
  std::string joints(const scene::ShapeRefPair& pair, const scene::Positions& positions) const;
  std::string describe(const Row& row) const;
  std::string countText(long count) const;
  std::string causes() const;

  double distance_;
  RowKind kind_;
  const scene::RobotModel& robot_;
  std::size_t pairs_;
  long rows_ = 0;
  std::array<long, kVerdicts> counts_{};  ///< by verdict
  std::optional<Row> closest_;            ///< of all, by its lower bound
  std::optional<Row> first_, worst_;      ///< of those that are not proven
};

}  // namespace proximity_server::tools
