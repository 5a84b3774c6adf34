#pragma once

#include "tools/states/npy_array.h"
#include "tools/states/state_source.h"

#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// States as a table of a .npy, or of a .npz: a row for each state, a column for each joint. Only the part that is
/// asked for is read, so the file may be larger than the memory.
///
/// The columns are named by the caller; else by an array "joints" or "names" of the .npz; else by a text file beside
/// it, with the suffix .joints: one name a line, or separated by commas. A column "time" is the time of the state,
/// unless a joint has that name; so is an array "time" of a .npz. The table of a .npz is its array "states",
/// "positions" or "q"; else the only one that is left.
///
/// Failure: the constructor throws std::invalid_argument as NpyTable and jointColumns() do, and if there are not as
///          many names as columns. next() throws for a number that is not finite.
class NumpyStates : public StateSource {
 public:
  /// `joints` may be empty.
  NumpyStates(const std::string& file, const std::vector<std::string>& joints, const scene::RobotModel& robot);

  std::optional<std::uint64_t> count() const override { return table_->rows(); }
  std::string identity() const override;
  std::string place() const override;

 protected:
  std::optional<const double*> fetch() override;

 private:
  void openMembers(std::vector<std::string>& names);
  void nameColumns(const std::vector<std::string>& names);
  void readBlock();

  std::optional<NpyTable> table_, times_;  ///< the times are one more column, behind the columns of the table
  // The block of rows that was read last.
  std::uint64_t block_begin_ = 0, block_end_ = 0;
  std::vector<double> block_;  ///< row by row, a number for each column
};

}  // namespace proximity_server::tools
