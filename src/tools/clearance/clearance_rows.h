#pragma once

#include "proximity_server/scene/batch/state_verdict.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/question.h"
#include "tools/clearance/clearance_question.h"
#include "tools/sweep/row_output.h"

#include <cstdint>
#include <string>
#include <vector>

namespace proximity_server::tools {

// Rows are in the root link's frame and have neither separator nor line end. An unknown number is nan in CSV and null
// in JSON.

/// The columns that rows of states have only if they are asked for: the level of the pair, and its guaranteed distance;
/// and the number of the point in place of the second link.
struct StateColumns {
  bool level = false, guaranteed = false, point = false;
};

/// The format of the rows of states, where so many pairs of links have numbers; and the format of the rows of segments.
OutputFormat stateFormat(RowFormat format, const PairSelection& selection, std::size_t pairs, StateColumns columns);
OutputFormat segmentFormat(const ClearanceQuestion& question, RowFormat format);

/// One segment: the closest pair at the time when it is closest, with the bounds of the whole segment, then the first
/// contact, and with thresholds the level; all times count as in the trajectory. A contact that is not decided is
/// `unknown` in CSV and null in JSON. JSON also has the positions of the joints at contact, without mimic joints.
std::string rowText(const ClearanceAnswer& answer, const ClearanceQuestion& question, RowFormat format);

/// The verdict about a state where the question is whether any pair is at or below a distance.
using Verdict = scene::StateVerdict::Kind;

/// The rows of states in one format. Lists have a row for each selected pair, and one for a state without an answer;
/// for "any" there is one for each state.
/// Thread-safe: it never changes.
class StateRows {
 public:
  /// The pairs of the question are those that numbers in .npy mean. The question must outlive this.
  StateRows(const ClearanceQuestion& question, RowFormat format);

  OutputFormat format() const;

  /// The place of a pair in the list of the question; -1 for a pair that is not in it, and one with an object.
  int numberOf(const scene::ShapeRefPair& pair) const;

  /// One pair of a state, with its guaranteed distance if the question has an uncertainty. One without links is the row
  /// of a state without an answer. Without objects `objects` is nullptr.
  void addPair(std::uint64_t state, const scene::PairProximity& pair, double guaranteed, const scene::Objects* objects,
               WrittenRows& to) const;

  /// The verdict about a state, with the pair that is below, or one without links.
  void addVerdict(std::uint64_t state, Verdict verdict, const scene::ShapeRefPair& pair, const scene::Objects* objects,
                  WrittenRows& to) const;

 private:
  std::size_t placeOf(const scene::ShapeRefPair& pair) const;

  const ClearanceQuestion& question_;
  RowFormat format_;
  std::string between_;
  std::size_t links_;
  std::vector<int> numbers_;  ///< the place of two links is link a * links + link b
  NpyInteger integer_;
};

}  // namespace proximity_server::tools
