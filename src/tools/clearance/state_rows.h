#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/clearance/clearance_rows.h"
#include "tools/clearance/clearance_run.h"
#include "tools/sweep/output_format.h"

namespace proximity_server::tools {

/// Rows as they are written, with what stands between them.
struct WrittenRows {
  std::string bytes;
  std::uint64_t rows = 0;

  void clear() {
    bytes.clear();
    rows = 0;
  }
};

/// The numbers of pairs of links: their places in a list.
class PairNumbers {
 public:
  PairNumbers(const std::vector<scene::ShapeRefPair>& pairs, std::size_t links);

  /// -1 for a pair that is not in the list, and one with an object.
  int of(const scene::ShapeRefPair& pair) const;

 private:
  std::size_t links_;
  std::vector<int> numbers_;  ///< of link a * links + link b
};

/// What is known of a state where the question is whether any pair is at or below a distance.
enum class Verdict : unsigned char { Unknown, Above, Below };

/// The rows of states in one format. Lists have a row for each selected pair, and one for a state without an answer; for "any"
/// there is one for each state.
/// Thread-safe: it never changes.
class StateRows {
 public:
  /// The pairs of the question are those that numbers in .npy mean. The question must outlive this.
  StateRows(const PairSelection& selection, RowFormat format, const ClearanceQuestion& question);

  /// What stands around the rows of a selection, of which there are so many pairs.
  static OutputFormat format(const PairSelection& selection, RowFormat format, std::size_t pairs, LevelColumn levels);
  OutputFormat format() const;

  const PairNumbers& numbers() const { return numbers_; }

  /// One pair of a state. One without links is that of a state without an answer.
  void addPair(std::uint64_t state, const scene::PairProximity& pair, const scene::Objects* objects,
               WrittenRows& to) const;

  /// The verdict about a state, with the number of the pair that is below, or with the pair where there are objects.
  void addVerdict(std::uint64_t state, Verdict verdict, int pair, WrittenRows& to) const;
  void addVerdict(std::uint64_t state, Verdict verdict, const scene::ShapeRefPair& pair, const scene::Objects* objects,
                  WrittenRows& to) const;

 private:
  void addVerdictText(std::uint64_t state, const std::string& rest, WrittenRows& to) const;
  std::string restOf(Verdict verdict, const std::string& link_a, const std::string& link_b) const;

  const ClearanceQuestion& question_;
  PairSelection selection_;
  RowFormat format_;
  const scene::RobotModel& robot_;
  PairNumbers numbers_;
  std::string separator_;
  NpyInteger integer_;
  std::vector<std::string> below_;  ///< what follows the state in the row of each pair that is below
  std::string above_, unknown_;
};

}  // namespace proximity_server::tools
