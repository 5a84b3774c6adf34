// One query of the narrowphase, step by step.
#include "tools/explain/explanation.h"
#include "tools/explain/link_pieces.h"
#include "tools/explain/shape_text.h"
#include "tools/program/options.h"
#include "tools/program/plot_script.h"
#include "tools/program/tool_main.h"
#include "tools/text/output_file.h"

#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>

namespace proximity_server::tools {
namespace {

using Eigen::Vector3d;

struct ExplainArguments {
  std::string a, b;
  std::optional<std::string> xyz, rpy, pose;
  RobotFiles robot;  ///< without urdf: a and b are shapes
  std::optional<std::string> state;
  std::optional<std::string> first_direction, stop_above, stop_below;
  narrowphase::Options options;
  enum class Format : unsigned char { Table, Json } format = Format::Table;
  std::optional<std::string> plot;
};

/// An option that is a text. An empty one is an error: it may come from an empty variable of a shell.
template <typename Text>
Option& addFilled(ProgramOptions& program, const std::string& name, const std::string& type, Text& value,
                  const std::string& description) {
  const auto read = [](const std::string& text) {
    if (text.empty()) throw std::invalid_argument("the text is empty");
    return text;
  };
  return program.addRead(name, type, value, read, description);
}

void declarePair(ProgramOptions& program, ExplainArguments& arguments) {
  program
      .addText("a", "SHAPE", arguments.a,
               "a shape: \"box x y z\", \"sphere radius\", \"capsule radius length\", \"cylinder radius length\", "
               "\"cone radius length\", \"ellipsoid rx ry rz\" or \"hull n x y z ...\", and behind it \"pad m\" and "
               "\"sweep\" with 12 numbers as of --pose; or, with --urdf, a link")
      .is_required = true;
  program.addText("b", "SHAPE", arguments.b, "the other one").is_required = true;
  addFilled(program, "--xyz", "\"X Y Z\"", arguments.xyz,
            "place of b in the frame of a, as in a URDF (default: \"0 0 0\")");
  addFilled(program, "--rpy", "\"R P Y\"", arguments.rpy,
            "its rotation [rad], or like \"0 0 90deg\" (default: \"0 0 0\")");
  addFilled(program, "--pose", "NUMBERS", arguments.pose, "both as 12 numbers: rotation row by row, translation");
  addFilled(program, "--urdf", "FILE", arguments.robot.urdf, "a and b are links of this robot");
  program.atMostOneOf({"--xyz", "--pose", "--urdf"});
  program.atMostOneOf({"--rpy", "--pose", "--urdf"});
  addFilled(program, "--state", "\"JOINT=POSITION ...\"", arguments.state,
            "positions of its joints; the others are at 0. The two closest pieces of the links are explained")
      .needs = "--urdf";
  addFilled(program, "--srdf", "FILE", arguments.robot.srdf, "its groups, which --config may name").needs = "--urdf";
  addRobotOptions(program, arguments.robot, "--urdf");
}

void declareQuestion(ProgramOptions& program, ExplainArguments& arguments) {
  addFilled(program, "--first-direction", "\"X Y Z\"", arguments.first_direction,
            "where the search begins, from a to b (default: from centre to centre)");
  addLength(program, "--tolerance", arguments.options.distance_tolerance, 0.0,
            "accepted gap of the bounds (default: 1e-9)");
  addFilled(program, "--stop-above", "METRES", arguments.stop_above, "end where the lower bound is above this");
  addFilled(program, "--stop-below", "METRES", arguments.stop_below, "end where the upper bound is not above this");
}

void declareOutput(ProgramOptions& program, ExplainArguments& arguments) {
  const auto readFormat = [](const std::string& name) {
    if (name != "table" && name != "json") throw std::invalid_argument("'" + name + "' is neither table nor json");
    return name == "table" ? ExplainArguments::Format::Table : ExplainArguments::Format::Json;
  };
  program.addRead("--format", "NAME", arguments.format, readFormat, "table or json (default: table)");
  addFilled(program, "--plot", "FILE", arguments.plot,
            "a picture (.png, .pdf or .svg): the CSO, the simplex of each iteration, the polytope of EPA, the bounds")
      .is_output = true;
  addQuiet(program, arguments.robot.warnings);
  program.setFooter("Exit codes: 0: done; 1: bad input, or memory or disk did not suffice.");
}

/// Three numbers; zero where nothing is given.
Vector3d vectorOf(const std::string& option, const std::optional<std::string>& text, bool are_angles = false) {
  if (!text) return Vector3d::Zero();
  return Vector3d(numbersOf(option, *text, 3, are_angles).data());
}

ExplainedPair pairOf(const ExplainArguments& arguments) {
  if (!arguments.robot.urdf.empty()) {
    return closestPieces(arguments.robot, arguments.a, arguments.b, arguments.state);
  }
  const Eigen::Isometry3d a_T_b =
      arguments.pose ? readPose("--pose", *arguments.pose)
                     : poseOf(vectorOf("--xyz", arguments.xyz), vectorOf("--rpy", arguments.rpy, true));
  return {readShape("a", arguments.a), readShape("b", arguments.b), a_T_b};
}

narrowphase::Options optionsOf(const ExplainArguments& arguments) {
  narrowphase::Options options = arguments.options;
  const auto read = [](const std::string& option, const std::optional<std::string>& text, double& threshold) {
    if (text) threshold = numbersOf(option, *text, 1)[0];
  };
  read("--stop-above", arguments.stop_above, options.stop_above);
  read("--stop-below", arguments.stop_below, options.stop_below);
  return options;
}

ExitCode run(const ExplainArguments& arguments) {
  std::optional<PlotScript> plot;
  if (arguments.plot) plot.emplace(PlotKind{"--plot", "explain_plot.py"}, *arguments.plot);
  const Explanation explanation =
      explain(pairOf(arguments), optionsOf(arguments), vectorOf("--first-direction", arguments.first_direction));
  const bool is_table = arguments.format == ExplainArguments::Format::Table;
  writeTo(std::cout, "standard output", is_table ? tableOf(explanation) : jsonOf(explanation, CsoSurface::Omitted));
  flushTo(std::cout, "standard output");
  if (plot) {
    plot->data() << jsonOf(explanation, CsoSurface::Added);
    plot->draw();
  }
  return ExitCode::Done;
}

}  // namespace
}  // namespace proximity_server::tools

int main(int argc, char** argv) {
  proximity_server::tools::ProgramOptions program(
      "explain", "One query of the narrowphase, step by step; lengths in metres, in the frame of shape a");
  proximity_server::tools::ExplainArguments arguments;
  proximity_server::tools::declarePair(program, arguments);
  proximity_server::tools::declareQuestion(program, arguments);
  proximity_server::tools::declareOutput(program, arguments);
  return proximity_server::tools::runTool(program, argc, argv, [&] { return proximity_server::tools::run(arguments); });
}
