#pragma once

#include "tools/clearance/clearance_question.h"

#include <map>
#include <optional>
#include <string>
#include <utility>

namespace proximity_server::tools {

/// The states for which a lower bound holds: the state itself, or all states within an uncertainty of it.
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

  void add(const ClearanceAnswer& answer);

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

  Verdict verdictOf(const ClearanceAnswer& answer) const;
  std::string joints(const ClearanceAnswer& answer) const;
  std::string describe(const ClearanceAnswer& answer) const;
  std::string countText(long count) const;
  std::string causes() const;

  double distance_;
  RowKind kind_;
  LowerBounds lower_bounds_;
  const scene::RobotModel& robot_;
  std::string pairs_;
  long rows_ = 0;
  std::map<Verdict, long> counts_;
  std::optional<ClearanceAnswer> closest_;        ///< with the smallest lower bound
  std::optional<ClearanceAnswer> first_, worst_;  ///< those that are not proven
};

}  // namespace proximity_server::tools
