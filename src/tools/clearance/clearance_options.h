#pragma once

#include <CLI/CLI.hpp>

#include <optional>
#include <string>

#include "proximity_server/scene/motion/moving_scene.h"
#include "proximity_server/scene/query/question.h"
#include "tools/clearance/clearance_question.h"
#include "tools/robot/robot_files.h"
#include "tools/second_opinion/second_opinion.h"
#include "tools/states/state_options.h"
#include "tools/sweep/output_format.h"
#include "tools/sweep/state_range.h"

namespace proximity_server::tools {

/// What the command line of `clearance` says.
struct ClearanceOptions {
  RobotFiles robot;
  bool list = false;  ///< the joints, and no states
  StateOptions states;
  std::string objects, thresholds, pairs = "minimum", out, plot;
  RowFormat format = RowFormat::Csv;
  RowKind rows = RowKind::State;
  scene::MotionQuestion motion;
  std::optional<double> assert_above;  // [m]
  SecondOpinionOptions second_opinion;
  scene::Skipping skipping = scene::Skipping::On;
  int threads = 1;
  PairFilter filter = PairFilter::On;
  SweepOptions sweep;
};

void declareClearance(CLI::App& app, ClearanceOptions& options);

/// Throws std::invalid_argument for options that do not go with each other.
void requireConsistent(const ClearanceOptions& options);

}  // namespace proximity_server::tools
