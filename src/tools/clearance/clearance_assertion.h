#pragma once

#include "tools/clearance/clearance_question.h"

#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace proximity_server::tools {

/// What the lower bounds of states hold for: the state itself, or all states within an uncertainty of it.
enum class LowerBounds : unsigned char { OfTheState, Guaranteed };

/// Decides whether a robot is proven to keep a distance from itself in all states or segments that are added.
///
/// A state or segment is proven if the lower bound of its smallest signed distance is above the wanted distance, and no
/// pair is unknown. Without any state or segment nothing is proven.
class ClearanceAssertion {
 public:
  /// `distance` [m] must be exceeded; `pairs` says which are checked: "all 12 pairs". The robot must outlive this
  /// object.
  ClearanceAssertion(double distance, RowKind kind, const scene::RobotModel& robot, std::string pairs,
                     LowerBounds lower_bounds = LowerBounds::OfTheState)
      : distance_(distance), kind_(kind), lower_bounds_(lower_bounds), robot_(robot), pairs_(std::move(pairs)) {}

  void add(const StateClearance& answer);
  void add(const SegmentClearance& answer);

  bool hasRows() const { return rows_ > 0; }
  bool holds() const { return hasRows() && !first_; }

  /// A report for people; it needs at least one row. It says what was proven; or how many rows are not proven and why,
  /// the first of them, and the worst one, which has the smallest upper bound.
  std::string report() const;

 private:
  enum class Verdict : unsigned char {
    Proven,
    TooClose,   ///< the upper bound does not exceed the distance
    Enclosed,   ///< the bounds enclose the distance and differ by no more than the tolerance
    Uncertain,  ///< the uncertainty of the state may bring the pair to the distance
    Undecided,  ///< the bounds enclose the distance, and the budget of the search ended before they were closer
    Unknown     ///< some pair has no answer
  };
  static const char* toString(Verdict verdict);

  /// The smallest distance of a state or segment.
  struct Row {
    long number = 0;
    std::string place;  ///< begin and end of a segment, and the time of its smallest distance
    std::string pair;   ///< the names of the closest pair; "" if no pair has an answer
    double distance = std::numeric_limits<double>::quiet_NaN();     ///< [m]
    double lower_bound = -std::numeric_limits<double>::infinity();  ///< [m] of all pairs
    double upper_bound = std::numeric_limits<double>::infinity();   ///< [m]
    narrowphase::Status status = narrowphase::Status::Unknown;
    int unknown_pairs = 0;
    std::string joints;  ///< the positions of the joints that move the pair; "" if that is a long text
    Verdict verdict = Verdict::Unknown;
  };
  void addRow(Row row, const scene::ShapeRefPair& pair, const scene::Objects* objects,
              const scene::Positions& positions);
  Verdict verdictOf(const Row& row) const;
  std::string joints(const scene::ShapeRefPair& pair, const scene::Objects* objects,
                     const scene::Positions& positions) const;
  std::string describe(const Row& row) const;
  std::string countText(long count) const;
  std::string causes() const;

  double distance_;
  RowKind kind_;
  LowerBounds lower_bounds_;
  const scene::RobotModel& robot_;
  std::string pairs_;
  long rows_ = 0;
  std::map<Verdict, long> counts_;
  std::optional<Row> closest_;        ///< the row with the smallest lower bound
  std::optional<Row> first_, worst_;  ///< rows that are not proven
};

}  // namespace proximity_server::tools
