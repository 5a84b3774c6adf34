#pragma once

#include "tools/clearance/clearance_question.h"
#include "tools/robot/robot_files.h"
#include "tools/second_opinion/second_opinion.h"
#include "tools/states/state_options.h"
#include "tools/sweep/output_format.h"
#include "tools/sweep/state_range.h"

#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// The options of `clearance`.
struct ClearanceOptions {
  RobotFiles robot;
  bool list = false;               ///< the joints, and no states
  std::optional<double> accuracy;  ///< [m] PairSelection::accuracy, as an option of its own
  StateOptions states;
  ClearanceQuestion question;     ///< without its robot, pairs, objects and thresholds, which are to be loaded
  std::string out, plot, report;  ///< files; "": none
  RowFormat format = RowFormat::Csv;
  RowKind rows = RowKind::State;
  std::optional<double> assert_above;  ///< [m]
  SecondOpinionOptions second_opinion;
  SweepOptions sweep;
  std::vector<std::string> command;  ///< all arguments, as they were given
};

void declareClearance(ProgramOptions& program, ClearanceOptions& options);

/// Throws std::invalid_argument for options that do not go with each other.
void requireConsistent(const ClearanceOptions& options);

}  // namespace proximity_server::tools
