// One query of the narrowphase, step by step.
#include "tools/explain/explanation.h"
#include "tools/explain/link_pieces.h"
#include "tools/explain/shape_text.h"
#include "tools/program/options.h"
#include "tools/program/plot_script.h"
#include "tools/program/tool_main.h"
#include "tools/text/output_file.h"

#include <CLI/CLI.hpp>

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
template <typename Value>
CLI::Option* addText(CLI::App& app, const std::string& name, Value& value, const std::string& description) {
  const auto read = [](const std::string& text) {
    if (text.empty()) throw std::invalid_argument("the text is empty");
    return text;
  };
  return addRead(app, name, value, read, description);
}

void declarePair(CLI::App& app, ExplainArguments& arguments) {
  app.add_option("a", arguments.a,
                 "a shape: \"box x y z\", \"sphere radius\", \"capsule radius length\", \"cylinder radius length\", "
                 "\"cone radius length\", \"ellipsoid rx ry rz\" or \"hull n x y z ...\", and behind it \"pad m\" and "
                 "\"sweep\" with 12 numbers as of --pose; or, with --urdf, a link")
      ->required()
      ->type_name("SHAPE");
  app.add_option("b", arguments.b, "the other one")->required()->type_name("SHAPE");
  CLI::Option* xyz =
      addText(app, "--xyz", arguments.xyz, "place of b in the frame of a, as in a URDF (default: \"0 0 0\")")
          ->type_name("\"X Y Z\"");
  CLI::Option* rpy =
      addText(app, "--rpy", arguments.rpy, "its rotation [rad] (default: \"0 0 0\")")->type_name("\"R P Y\"");
  CLI::Option* pose = addText(app, "--pose", arguments.pose, "both as 12 numbers: rotation row by row, translation")
                          ->type_name("NUMBERS")
                          ->excludes(xyz)
                          ->excludes(rpy);
  CLI::Option* urdf = addText(app, "--urdf", arguments.robot.urdf, "a and b are links of this robot")
                          ->type_name("FILE")
                          ->excludes(xyz)
                          ->excludes(rpy)
                          ->excludes(pose);
  addText(app, "--state", arguments.state,
          "positions of its joints; the others are at 0. The two closest pieces of the links are explained")
      ->type_name("\"JOINT=POSITION ...\"")
      ->needs(urdf);
  for (CLI::Option* option : addRobotOptions(app, arguments.robot)) option->needs(urdf);
}

void declareQuestion(CLI::App& app, ExplainArguments& arguments) {
  addText(app, "--first-direction", arguments.first_direction,
          "where the search begins, from a to b (default: from centre to centre)")
      ->type_name("\"X Y Z\"");
  addLength(app, "--tolerance", arguments.options.distance_tolerance, 0.0,
            "accepted gap of the bounds (default: 1e-9)");
  addText(app, "--stop-above", arguments.stop_above, "end where the lower bound is above this")->type_name("METRES");
  addText(app, "--stop-below", arguments.stop_below, "end where the upper bound is not above this")
      ->type_name("METRES");
}

void declareOutput(CLI::App& app, ExplainArguments& arguments) {
  const auto readFormat = [](const std::string& name) {
    if (name != "table" && name != "json") throw std::invalid_argument("'" + name + "' is neither table nor json");
    return name == "table" ? ExplainArguments::Format::Table : ExplainArguments::Format::Json;
  };
  addRead(app, "--format", arguments.format, readFormat, "table or json (default: table)")->type_name("NAME");
  addText(app, "--plot", arguments.plot,
          "a picture (.png, .pdf or .svg): the CSO, the simplex of each iteration, the polytope of EPA, the bounds")
      ->type_name("FILE");
  addQuiet(app, arguments.robot.warnings);
  app.footer("Exit codes: 0: done; 1: bad input, or memory or disk did not suffice.");
}

/// Three numbers; zero where nothing is given.
Vector3d vectorOf(const std::string& option, const std::optional<std::string>& text) {
  if (!text) return Vector3d::Zero();
  return Vector3d(numbersOf(option, *text, 3).data());
}

ExplainedPair pairOf(const ExplainArguments& arguments) {
  if (!arguments.robot.urdf.empty()) {
    return closestPieces(arguments.robot, arguments.a, arguments.b, arguments.state);
  }
  const Eigen::Isometry3d a_T_b = arguments.pose
                                      ? readPose("--pose", *arguments.pose)
                                      : poseOf(vectorOf("--xyz", arguments.xyz), vectorOf("--rpy", arguments.rpy));
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
  if (arguments.plot) plot.emplace("explain_plot.py", *arguments.plot);
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
  CLI::App app("One query of the narrowphase, step by step; lengths in metres, in the frame of shape a", "explain");
  proximity_server::tools::ExplainArguments arguments;
  proximity_server::tools::declarePair(app, arguments);
  proximity_server::tools::declareQuestion(app, arguments);
  proximity_server::tools::declareOutput(app, arguments);
  return proximity_server::tools::runTool(app, argc, argv, [&] { return proximity_server::tools::run(arguments); });
}
