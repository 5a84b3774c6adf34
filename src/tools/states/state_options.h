#pragma once

#include "tools/states/bag_states.h"
#include "tools/states/grid_states.h"
#include "tools/states/state_source.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

class ProgramOptions;

/// The options of the states.
struct StateOptions {
  std::string file = "-";           ///< CSV, .npy or .npz; "-": CSV from standard input
  std::vector<std::string> joints;  ///< the joints of the columns of a .npy or .npz; empty: named beside it
  BagOptions bag;                   ///< if it has a file
  std::optional<std::uint64_t> sample;
  std::uint64_t seed = 0;      ///< the seed of the sample
  std::vector<GridAxis> grid;  ///< if there is one
  bool is_zero = false;        ///< one state, all joints at 0 or nearest to it
};

/// Declares the options of the states: --states, --joints, --bag, --topic, --rate, --sample, --seed, --grid, --zero.
void declareStateOptions(ProgramOptions& program, StateOptions& options);

/// Whether a file is a .npy or .npz. A pipe is not looked into, as its bytes would be gone.
bool isNumpy(const std::string& file);

/// Throws std::invalid_argument with the name of the file and the reason if it cannot be read, so that this is known
/// before the robot is loaded; and system::FileConflict if it is standard input, and an output.
void requireReadable(const StateOptions& options);

/// Opens the source of the states, which the robot must outlive. The suffix of a file tells its format, or else its
/// first bytes.
/// Failure: throws std::invalid_argument naming the file or the option.
std::unique_ptr<StateSource> openStates(const StateOptions& options, const scene::RobotModel& robot);

}  // namespace proximity_server::tools
