// The extension module proximity._native; src/python/proximity/__init__.py is what users import. The docstrings are the reference of
// the module: help(proximity.Robot).
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/names.h"
#include "python/loading.h"
#include "python/robot.h"
#include "python/rows.h"

namespace proximity_server::python {
namespace {

namespace py = pybind11;
using namespace py::literals;

using NamePairs = std::vector<scene::PairFilterOptions::Names>;

/// A column of q.
struct JointInfo {
  std::string name;
  const char* type;
  double lower, upper;
  std::optional<std::string> mimic;
};

const char* typeName(scene::Joint::Type type) {
  switch (type) {
    case scene::Joint::Type::Revolute:
      return "revolute";
    case scene::Joint::Type::Continuous:
      return "continuous";
    case scene::Joint::Type::Prismatic:
      return "prismatic";
    case scene::Joint::Type::Floating:
      return "floating";
    case scene::Joint::Type::Planar:
      return "planar";
  }
  return "unknown";
}

std::vector<JointInfo> jointsOf(const Robot& robot) {
  const std::vector<scene::Joint>& joints = robot.model().robot.joints;
  std::vector<JointInfo> list;
  for (const scene::Joint& joint : joints) {
    std::optional<std::string> mimic;
    if (joint.mimic) mimic = joints[static_cast<std::size_t>(joint.mimic->joint)].name;
    list.push_back({joint.name, typeName(joint.type), joint.lower, joint.upper, mimic});
  }
  return list;
}

/// A row (lower, upper) for each joint.
py::array_t<double> rangesOf(const Robot& robot) {
  const scene::RobotModel& model = robot.model().robot;
  py::array_t<double> ranges({static_cast<py::ssize_t>(model.joints.size()), py::ssize_t{2}});
  auto rows = ranges.mutable_unchecked<2>();
  std::fill_n(ranges.mutable_data(), ranges.size(), 0.0);
  for (const scene::JointRange& range : scene::jointRanges(model)) {
    rows(range.joint, 0) = range.lower;
    rows(range.joint, 1) = range.upper;
  }
  return ranges;
}

using LinkNames = std::pair<std::string, std::string>;

std::vector<LinkNames> pairsOf(const Robot& robot) {
  const scene::RobotModel& model = robot.model().robot;
  std::vector<LinkNames> names;
  for (const scene::ShapeRefPair& pair : robot.candidates())
    names.emplace_back(model.links[static_cast<std::size_t>(pair.a.link)].name,
                       model.links[static_cast<std::size_t>(pair.b.link)].name);
  return names;
}

std::vector<std::tuple<std::string, std::string, std::string>> uncheckedOf(const Robot& robot) {
  const scene::RobotModel& model = robot.model().robot;
  std::vector<std::tuple<std::string, std::string, std::string>> list;
  for (const scene::LinkPair& pair : robot.model().pairs.pairs) {
    if (pair.reason == scene::PairReason::Checked) continue;
    list.emplace_back(model.links[static_cast<std::size_t>(pair.link_a)].name,
                      model.links[static_cast<std::size_t>(pair.link_b)].name, scene::toString(pair.reason));
  }
  return list;
}

std::vector<std::string> warningsOf(const scene::SceneModel& model) {
  std::vector<std::string> warnings = model.robot.warnings;
  warnings.insert(warnings.end(), model.pairs.warnings.begin(), model.pairs.warnings.end());
  return warnings;
}

std::string describe(const Robot& robot) {
  return "<proximity.Robot " + scene::quoted(robot.model().robot.name) + ": " +
         std::to_string(robot.model().robot.joints.size()) + " joints, " + std::to_string(robot.candidates().size()) +
         " pairs>";
}

/// The keyword arguments of both ways to make a robot.
struct Keywords {
  double mesh_tolerance;
  std::optional<std::vector<std::filesystem::path>> packages;
  double padding;
  std::string group;
  NamePairs exclude_pairs, only_pairs;
  std::optional<int> threads;
};

LoadOptions loadOptions(const Keywords& keywords) {
  LoadOptions options;
  options.mesh_tolerance = keywords.mesh_tolerance;
  options.padding = keywords.padding;
  if (keywords.packages) options.packages.emplace(keywords.packages->begin(), keywords.packages->end());
  options.pairs.group = keywords.group;
  options.pairs.exclude_pairs = keywords.exclude_pairs;
  options.pairs.only_pairs = keywords.only_pairs;
  options.progress = [](const std::string& what) {
    const py::gil_scoped_acquire gil;
    py::module_::import("logging").attr("getLogger")("proximity").attr("info")("%s", what);
  };
  return options;
}

void warn(const std::string& text) {
  if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0) throw py::error_already_set();
}

std::unique_ptr<Robot> makeRobot(const RobotText& text, const Keywords& keywords) {
  const LoadOptions options = loadOptions(keywords);
  const int all_cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  std::shared_ptr<const scene::SceneModel> model;
  std::optional<scene::LevelThresholds> thresholds;
  {
    const py::gil_scoped_release released;
    model = load(text, options);
    thresholds = thresholdsOf(text, model->robot);
  }
  for (const std::string& warning : warningsOf(*model)) warn(text.urdf_name + ": " + warning);
  return std::make_unique<Robot>(std::move(model), std::move(thresholds), keywords.threads.value_or(all_cores));
}

std::unique_ptr<Robot> robotOfFiles(const std::filesystem::path& urdf, const std::optional<std::filesystem::path>& srdf,
                                    const std::optional<std::filesystem::path>& thresholds, const Keywords& keywords) {
  if (urdf.native().find('<') != std::string::npos && !std::filesystem::exists(urdf))
    throw std::invalid_argument("the first argument is the path of a URDF; Robot.from_text takes its text");
  RobotText text;
  text.urdf = readTextFile(urdf);
  text.urdf_name = urdf.string();
  text.srdf = srdf ? readTextFile(*srdf) : "";
  text.srdf_name = srdf ? srdf->string() : text.urdf_name;
  if (thresholds) text.thresholds = readTextFile(*thresholds);
  text.thresholds_name = thresholds ? thresholds->string() : "";
  text.folder = std::filesystem::absolute(urdf).parent_path();
  return makeRobot(text, keywords);
}

constexpr char kRobotDoc[] = R"(A robot with the pairs of its links that are checked against each other.

It never changes, but for `threads`. It may be used by many threads of Python at once: the GIL is released while a question
is computed. Ctrl-C ends a question.

The argument q of each question holds joint positions [rad] or [m]: shape (states, joints), or (joints,) for one state, in
the order of Robot.joints, which need not be that of the URDF. The columns of mimic joints are ignored, as they follow their
leaders, and so are those of floating and planar joints, which stay where they are at 0. Any array that numpy casts to float64
safely is taken, in C or Fortran order; other strides and types are copied (float32 exactly), complex numbers and objects
are a TypeError. A wrong shape is a ValueError. A state with a position that is not finite, in any column, has no answer:
Status.UNKNOWN, Verdict.UNKNOWN. Limits of joints are not looked at.

Each answer is a function of its state alone, to the last bit: the other states, their number and the threads do not count,
nor do the processor and the C library. The fields of the rows are described at the top of the module, help(proximity); where
the robot has thresholds, those of PAIR are rows of LEVELED_PAIR.)";

constexpr char kLoadDoc[] = R"(Reads a URDF from a file.

urdf             path of the file; Robot.from_text takes the text
srdf             path of a file that tells which pairs not to check; None: neighbours are not checked, all other pairs are
mesh_tolerance   [m] how far the convex pieces may lie from the mesh that they stand for; 0: its triangles
packages         folders in which package:// is looked for, as in ROS_PACKAGE_PATH; None: those of that variable
padding          [m] is added to every piece
group            of the SRDF: only pairs that its joints can move are checked; "": all
exclude_pairs    pairs of names of links that are not checked
only_pairs       if there are any, no other pair is checked
thresholds       path of YAML with the stop and warn distances, also those of single pairs, links and groups; then rows about
                 pairs have a level. None: they have none
threads          see Robot.threads; None: as many as there are cores

Pieces of meshes are kept in the user's cache, so that the next time is fast; steps that take long are logged to
logging.getLogger("proximity").
Raises OSError (FileNotFoundError, ...) for a file that cannot be read, and ValueError for what is wrong in it, naming file and
link, joint or mesh. What is odd but legal is a UserWarning.)";

constexpr char kFromTextDoc[] =
    R"(Reads a URDF from its text; the SRDF and the thresholds are texts too, "" if there are none.

Relative paths of meshes begin at `folder`. All else is as in Robot(urdf).)";

constexpr char kMinimumDoc[] = R"(The pair with the smallest signed distance in each state.

Returns rows of the dtype PAIR, of shape (states,); for q of shape (joints,) one row. The status is UNKNOWN if a position is not
finite, or if the robot has no pair.)";

constexpr char kLevelDoc[] = R"(The level of each state: the pair that sets it, with its level.

That is, of the pairs at the worst level the one with the smallest distance less its threshold (that of WARN if the level is
CLEAR). It need not be the closest one.
Returns rows of the dtype LEVELED_PAIR, of shape (states,); for q of shape (joints,) one row. The level is INVALID where the
status is UNKNOWN, as in minimum.
Raises ValueError if the robot was made without thresholds.)";

constexpr char kClosestDoc[] = R"(The k pairs with the smallest signed distances in each state, sorted.

Returns rows of the dtype PAIR, of shape (states, k); for q of shape (joints,) of shape (k,). If there are fewer pairs than
k, the rows behind them have the status UNKNOWN and the pair -1.
Raises ValueError if k is less than 1.)";

constexpr char kBelowDoc[] =
    R"(Whether anything is at or below a signed distance [m] in each state: much cheaper than minimum.

Returns rows of the dtype VERDICT, of shape (states,); for q of shape (joints,) one row. ABOVE is proven; a pair counts as below
unless its lower bound proves otherwise.
Raises ValueError if the distance is NaN.)";

constexpr char kPairsBelowDoc[] = R"(All pairs at or below a signed distance [m] in each state.

Returns rows of the dtype PAIR in one dimension, sorted by state, and within a state by distance. A state without an answer
has one row, of status UNKNOWN and pair -1: a state without a row is proven to be above the distance.
Raises ValueError if the distance is NaN.)";

constexpr char kGradientDoc[] = R"(Distances with their derivatives by q.

Returns the rows of minimum(q), or those of closest(q, k) if k is given, and the gradients of their distances: the same shape
with one more dimension, for the columns of q. Units are [m/rad] and [m/m]; positive where the distance grows, in overlap where
the depth shrinks. Columns that are ignored have 0: the part of a mimic joint is in the column of its leader. A row without an
answer has NaN.
The distance has a kink where the field `unique` is False: this is then the derivative of one choice of points.
The smallest distance has another kink where two pairs are equally close, which rows of closest(q, 2) show.
Raises ValueError if k is less than 1.)";

constexpr char kThreadsDoc[] = R"(How many threads a question uses, from 1 to 1024; fewer if there are few states.

The answers do not depend on it. Raises ValueError for another number.)";

constexpr char kRangesDoc[] =
    R"(Lowest and highest position of each joint, [rad] or [m], of shape (joints, 2), for sampling:
    numpy.random.default_rng(1).uniform(*robot.ranges.T, (states, len(robot.joints)))

The limits of the URDF; a full turn of a continuous joint; -1 m to 1 m, a guess, for a prismatic joint without limits; 0 for
joints whose positions are ignored.)";

void declareJoint(py::module_& module) {
  py::class_<JointInfo> joint(module, "Joint", "A joint that moves: a column of q.");
  joint.def_readonly("name", &JointInfo::name, "as in the URDF");
  joint.def_readonly("type", &JointInfo::type, "revolute, continuous, prismatic, floating or planar");
  joint.def_readonly("lower", &JointInfo::lower, "[rad] or [m] lower limit, or -inf");
  joint.def_readonly("upper", &JointInfo::upper, "[rad] or [m] upper limit, or inf");
  joint.def_readonly("mimic", &JointInfo::mimic, "the name of the joint that it follows, or None");
  joint.def("__repr__", [](const JointInfo& self) {
    return "<proximity.Joint " + scene::quoted(self.name) + ": " + self.type + ">";
  });
  joint.attr("__module__") = "proximity";
}

void declareConstructors(py::class_<Robot>& robot) {
  robot.def(py::init([](const std::filesystem::path& urdf, const std::optional<std::filesystem::path>& srdf,
                        double mesh_tolerance, std::optional<std::vector<std::filesystem::path>> packages,
                        double padding, std::string group, NamePairs exclude_pairs, NamePairs only_pairs,
                        const std::optional<std::filesystem::path>& thresholds, std::optional<int> threads) {
              return robotOfFiles(urdf, srdf, thresholds,
                                  {mesh_tolerance, std::move(packages), padding, std::move(group),
                                   std::move(exclude_pairs), std::move(only_pairs), threads});
            }),
            kLoadDoc, "urdf"_a, "srdf"_a = py::none(), py::kw_only(), "mesh_tolerance"_a = 0.005,
            "packages"_a = py::none(), "padding"_a = 0.0, "group"_a = "", "exclude_pairs"_a = NamePairs{},
            "only_pairs"_a = NamePairs{}, "thresholds"_a = py::none(), "threads"_a = py::none());
  robot.def_static(
      "from_text",
      [](const std::string& urdf, const std::string& srdf, const std::filesystem::path& folder, double mesh_tolerance,
         std::optional<std::vector<std::filesystem::path>> packages, double padding, std::string group,
         NamePairs exclude_pairs, NamePairs only_pairs, const std::string& thresholds, std::optional<int> threads) {
        return makeRobot({urdf, srdf, "the URDF", "the SRDF", std::filesystem::absolute(folder),
                          thresholds.empty() ? std::nullopt : std::make_optional(thresholds), "the thresholds"},
                         {mesh_tolerance, std::move(packages), padding, std::move(group), std::move(exclude_pairs),
                          std::move(only_pairs), threads});
      },
      kFromTextDoc, "urdf"_a, "srdf"_a = "", py::kw_only(), "folder"_a = ".", "mesh_tolerance"_a = 0.005,
      "packages"_a = py::none(), "padding"_a = 0.0, "group"_a = "", "exclude_pairs"_a = NamePairs{},
      "only_pairs"_a = NamePairs{}, "thresholds"_a = "", "threads"_a = py::none());
}

void declareProperties(py::class_<Robot>& robot) {
  robot.def_property_readonly(
      "name", [](const Robot& self) { return self.model().robot.name; }, "of the robot in the URDF");
  robot.def_property_readonly("joints", &jointsOf, "The joints that move, in the order of the columns of q.");
  robot.def_property_readonly("ranges", &rangesOf, kRangesDoc);
  robot.def_property_readonly(
      "pairs", &pairsOf, "The checked pairs, as the names of their two links; the field `pair` is an index of it.");
  robot.def_property_readonly(
      "unchecked", &uncheckedOf,
      "The pairs of links with geometry that are not checked: the names of both links, and the reason.");
  robot.def_property_readonly(
      "warnings", [](const Robot& self) { return warningsOf(self.model()); },
      "What is odd but legal in URDF and SRDF, a sentence each.");
  robot.def_property("threads", &Robot::threads, &Robot::setThreads, kThreadsDoc);
  robot.def("__repr__", &describe);
}

void declareQuestions(py::class_<Robot>& robot) {
  robot.def("minimum", &Robot::minimum, kMinimumDoc, "q"_a);
  robot.def("level", &Robot::level, kLevelDoc, "q"_a);
  robot.def("closest", &Robot::closest, kClosestDoc, "q"_a, "k"_a);
  robot.def("below", &Robot::below, kBelowDoc, "q"_a, "distance"_a);
  robot.def("pairs_below", &Robot::pairsBelow, kPairsBelowDoc, "q"_a, "distance"_a);
  robot.def("gradient", &Robot::gradient, kGradientDoc, "q"_a, "k"_a = py::none());
}

}  // namespace
}  // namespace proximity_server::python

PYBIND11_MODULE(_native, module) {
  using namespace proximity_server::python;
  module.doc() = "The compiled part of proximity.";
  PYBIND11_NUMPY_DTYPE(PairRow, state, status, unique, depth_is_lower_bound, representation, pair, distance, lower,
                       upper, point_a, point_b, normal);
  PYBIND11_NUMPY_DTYPE(VerdictRow, verdict, pair);
  module.attr("PAIR") = pybind11::dtype::of<PairRow>();
  module.attr("LEVELED_PAIR") = leveledPairType();
  module.attr("VERDICT") = pybind11::dtype::of<VerdictRow>();
  declareJoint(module);
  pybind11::class_<Robot> robot(module, "Robot", kRobotDoc);
  robot.attr("__module__") = "proximity";
  declareConstructors(robot);
  declareProperties(robot);
  declareQuestions(robot);
}
