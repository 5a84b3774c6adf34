// The extension module proximity._native. Users import it through src/python/proximity/__init__.py. The docstrings are
// the reference of the module: help(proximity.Robot).
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "proximity_server/scene/sensed/cloud_file.h"
#include "proximity_server/scene/sensed/voxel_grid.h"
#include "python/loading.h"
#include "python/object_arguments.h"
#include "python/path_caster.h"
#include "python/questions.h"
#include "python/robot.h"
#include "python/rows.h"
#include "python/signal_watch.h"
#include "system/number_text.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

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

std::vector<JointInfo> jointsOf(const Robot& robot) {
  const std::vector<scene::Joint>& joints = robot.model()->robot.joints;
  std::vector<JointInfo> list;
  for (const scene::Joint& joint : joints) {
    std::optional<std::string> mimic;
    if (joint.mimic) mimic = joints[joint.mimic->joint].name;
    list.push_back({joint.name, toString(joint.type), joint.lower, joint.upper, mimic});
  }
  return list;
}

/// An array with a row (lower, upper) for each joint.
py::array_t<double> rangesOf(const Robot& robot) {
  const scene::RobotModel& model = robot.model()->robot;
  py::array_t<double> ranges({static_cast<py::ssize_t>(model.joints.size()), py::ssize_t{2}});
  auto rows = ranges.mutable_unchecked<2>();
  std::fill_n(ranges.mutable_data(), ranges.size(), 0.0);
  for (const scene::JointRange& range : scene::jointRanges(model)) {
    rows(range.joint, 0) = range.lower;
    rows(range.joint, 1) = range.upper;
  }
  return ranges;
}

using PairNames = std::pair<std::string, std::string>;

std::vector<PairNames> pairsOf(const Robot& robot) {
  std::vector<PairNames> names;
  const auto nameOf = [&](const scene::ShapeRef& ref) {
    return scene::nameOf(ref, robot.model()->robot, robot.objects().get());
  };
  for (const scene::ShapeRefPair& pair : robot.pairs().list()) names.emplace_back(nameOf(pair.a), nameOf(pair.b));
  return names;
}

std::vector<std::tuple<std::string, std::string, std::string>> uncheckedOf(const Robot& robot) {
  const scene::RobotModel& model = robot.model()->robot;
  std::vector<std::tuple<std::string, std::string, std::string>> list;
  for (const scene::LinkPair& pair : robot.model()->pairs.pairs) {
    if (pair.reason == scene::PairReason::Checked) continue;
    list.emplace_back(model.links[pair.link_a].name, model.links[pair.link_b].name, scene::toString(pair.reason));
  }
  return list;
}

std::vector<std::string> warningsOf(const scene::SceneModel& model) {
  std::vector<std::string> warnings = model.robot.warnings;
  warnings.insert(warnings.end(), model.pairs.warnings.begin(), model.pairs.warnings.end());
  return warnings;
}

std::string describe(const Robot& robot) {
  return "<proximity.Robot " + scene::quoted(robot.model()->robot.name) + ": " +
         std::to_string(robot.model()->robot.joints.size()) + " joints, " +
         std::to_string(robot.pairs().list().size()) + " pairs" +
         (robot.objects()->empty() ? ""
                                   : ", " + std::to_string(robot.objects()->size()) +
                                         (robot.objects()->size() == 1 ? " object" : " objects")) +
         ">";
}

using Folders = std::vector<std::filesystem::path>;

LoadOptions loadOptions(std::optional<double> mesh_tolerance, const std::optional<Folders>& packages,
                        std::optional<double> padding, std::string group, NamePairs exclude_pairs, NamePairs only_pairs,
                        bool allow_missing_meshes, bool allow_broken_mimics) {
  LoadOptions options{mesh_tolerance, padding, std::nullopt, {}, allow_missing_meshes, allow_broken_mimics, {}};
  if (packages) {
    options.packages.emplace();
    for (const std::filesystem::path& folder : *packages)
      options.packages->push_back(folder.empty() ? "" : std::filesystem::absolute(folder).string());
  }
  options.pairs.group = std::move(group);
  options.pairs.exclude_pairs = std::move(exclude_pairs);
  options.pairs.only_pairs = std::move(only_pairs);
  options.progress = [](const std::string& what) {
    const py::gil_scoped_acquire gil;
    py::module_::import("logging").attr("getLogger")("proximity").attr("info")("%s", what);
  };
  return options;
}

/// Raises a ValueError whose names, which come from the caller, are cut to a readable length.
void raiseReadable(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const std::invalid_argument& error) {
    PyErr_SetString(PyExc_ValueError, system::readable(error.what()).c_str());
  }
}

void warn(const std::string& text) {
  if (PyErr_WarnEx(PyExc_UserWarning, system::readable(text).c_str(), 1) != 0) throw py::error_already_set();
}

/// `threads`: nullopt: as many as there are cores.
std::unique_ptr<Robot> makeRobot(RobotText text, LoadOptions options, std::optional<int> threads) {
  const int all_cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  SignalWatch watch;
  std::unique_ptr<Robot> robot;
  watch.run([&] {
    robot = std::make_unique<Robot>(std::move(text), std::move(options), threads.value_or(all_cores), watch.stop());
  });
  return robot;
}

// --- objects

using Operation = scene::ObjectEdit::Operation;

/// Returns the robot with these objects and rules. Gives the warnings about the objects unless they are to be omitted.
enum class ObjectWarnings : unsigned char { Give, Omit };
std::unique_ptr<Robot> withObjects(const Robot& robot, std::vector<scene::ObjectEdit> objects,
                                   const std::vector<scene::WrittenRule>& rules, ObjectWarnings object_warnings) {
  std::vector<std::string> warnings;
  std::unique_ptr<Robot> next;
  SignalWatch watch;  // because meshes may take long
  watch.run([&] { next = robot.with(std::move(objects), rules, watch.stop(), warnings); });
  if (object_warnings == ObjectWarnings::Give)
    for (const std::string& warning : warnings) warn(warning);
  return next;
}

scene::ObjectEdit objectOf(const std::string& name, const py::object& shapes, const py::object& pose,
                           const std::string& link, std::vector<std::string> touch_links, const std::string& frame,
                           double padding) {
  return withNameInErrors("object " + scene::quoted(name), [&] {
    scene::ObjectEdit edit{name, {link, std::move(touch_links), frame, poseOf(pose)}, padding, shapesOf(shapes), ""};
    scene::completeFields(edit);
    return edit;
  });
}

using PointArray = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// An object of the voxels that contain points.
scene::ObjectEdit objectOf(const std::string& name, const PointArray& points, double resolution) {
  return withNameInErrors("object " + scene::quoted(name), [&] {
    if (points.ndim() == 0 || points.shape(points.ndim() - 1) != 3)
      throw std::invalid_argument("points must be of shape (..., 3)");
    scene::VoxelGrid grid(resolution);
    for (py::ssize_t i = 0; i < points.size(); i += 3)
      if (const Eigen::Vector3d point(points.data() + i); point.allFinite()) grid.add(point);
    if (grid.size() == 0) throw std::invalid_argument("none of its points is finite");
    const scene::ObjectShape voxels{scene::Boxes{grid.boxes()}};
    scene::ObjectEdit edit;
    edit.id = name;
    edit.shapes.push_back(voxels);
    return edit;
  });
}

scene::ObjectEdit objectOf(const std::string& name, const py::object& object) {
  return objectOf(name, object.attr("shapes"), object.attr("pose"), object.attr("link").cast<std::string>(),
                  object.attr("touch_links").cast<std::vector<std::string>>(), object.attr("frame").cast<std::string>(),
                  object.attr("padding").cast<double>());
}

/// Makes the proximity.Object that describes an object.
py::object describedObject(const scene::Object& object) {
  const auto* const held = std::get_if<scene::Attached>(&object.placement);
  const auto* const moving = std::get_if<scene::Moving>(&object.placement);
  return py::module_::import("proximity._shapes")
      .attr("Object")(shapesOf(scene::givenShapesOf(object)), matrixOf(scene::poseInCarrier(object)),
                      held ? held->link : "",
                      py::tuple(py::cast(held ? held->touch_links : std::vector<std::string>())),
                      moving ? moving->frame : "", scene::paddingOf(object));
}

py::dict objectsOf(const Robot& robot) {
  py::dict objects;
  for (const int number : robot.objects()->numbers()) {
    const scene::Object& object = *robot.objects()->object(number);
    objects[py::str(object.id)] = describedObject(object);
  }
  return objects;
}

/// Refuses the changes of a file, whose name is `source`.
std::unique_ptr<Robot> withObjectsOf(const Robot& robot, scene::ObjectFile file, const std::string& source) {
  if (!file.changes.empty())
    throw std::invalid_argument(source +
                                ": it has changes, which are those of states on a way: the tool clearance makes them");
  for (const std::string& warning : file.warnings) warn(warning);
  return withObjects(robot, std::move(file.objects), file.rules, ObjectWarnings::Give);
}

std::unique_ptr<Robot> withObjectFile(const Robot& robot, const std::filesystem::path& path) {
  static_cast<void>(readTextFile(path));  // throws OSError if the file cannot be read
  return withObjectsOf(robot, scene::readObjectFile(path.string()), path.string());
}

/// Returns the robot after an operation that places an object: at `pose`, or where the object is in the state q. The
/// other one of the two is None.
std::unique_ptr<Robot> editedAtPoseOrState(const Robot& robot, scene::ObjectEdit edit, const py::object& pose,
                                           const py::object& q) {
  if (pose.is_none() == q.is_none())
    throw std::invalid_argument("object " + scene::quoted(edit.id) +
                                ": needs either its pose, or the state q in which it stays where it is");
  edit.place.pose = poseOf(pose);
  return robot.edited(std::move(edit), q);
}

/// An operation on an object, without a pose.
scene::ObjectEdit editOf(Operation operation, const std::string& name, scene::ObjectPlace place = {}) {
  scene::ObjectEdit edit;
  edit.id = name;
  edit.place = std::move(place);
  edit.operation = operation;
  return edit;
}

// --- files

/// Returns the robot, or that with the objects of its configuration, and gives the warnings of the load.
std::unique_ptr<Robot> asConfigured(std::unique_ptr<Robot> robot) {
  for (const std::string& warning : warningsOf(*robot->model())) warn(robot->text().urdf_name + ": " + warning);
  scene::ConfigFile config = configOf(robot->text(), robot->options());
  for (const std::string& warning : config.warnings) warn(warning);
  if (!config.robot.uncertaintyOf(robot->model()->robot, robot->text().config_name).isZero())
    warn(robot->text().config_name + ": its uncertainty counts where a question is given it: guaranteed()");
  scene::ObjectFile& file = config.robot.objects;
  if (file.objects.empty() && file.rules.empty() && file.changes.empty()) return robot;
  return withObjectsOf(*robot, std::move(file), robot->text().config_name);
}

std::unique_ptr<Robot> robotOfFiles(const std::filesystem::path& urdf, const std::optional<std::filesystem::path>& srdf,
                                    const std::optional<std::filesystem::path>& thresholds,
                                    const std::optional<std::filesystem::path>& config, LoadOptions options,
                                    std::optional<int> threads) {
  std::error_code is_no_path;  // a text may be longer than a path can be
  if (urdf.native().find('<') != std::string::npos && !std::filesystem::exists(urdf, is_no_path))
    throw std::invalid_argument("the first argument is the path of a URDF; Robot.from_text takes its text");
  RobotText text;
  text.urdf = readTextFile(urdf);
  text.urdf_name = urdf.string();
  text.srdf = srdf ? readTextFile(*srdf) : "";
  text.srdf_name = srdf ? srdf->string() : text.urdf_name;
  if (thresholds) text.thresholds = readTextFile(*thresholds);
  text.thresholds_name = thresholds ? thresholds->string() : "";
  if (config) text.config = readTextFile(*config);
  text.config_name = config ? config->string() : "";
  if (config) text.config_folder = std::filesystem::absolute(*config).parent_path();
  text.folder = std::filesystem::absolute(urdf).parent_path();
  return asConfigured(makeRobot(std::move(text), std::move(options), threads));
}

// --- pickles

py::dict stateOf(const Robot& robot) {
  const RobotText& text = robot.text();
  const LoadOptions& options = robot.options();
  std::vector<std::pair<int, std::string>> names;  // sorted by number, which decides the order of two objects in a pair
  for (const int number : robot.objects()->numbers()) names.emplace_back(number, robot.objects()->object(number)->id);
  std::sort(names.begin(), names.end());
  py::list objects, rules;
  for (const auto& [number, name] : names)
    objects.append(py::make_tuple(name, describedObject(*robot.objects()->object(number))));
  for (const scene::WrittenRule& rule : robot.rules())
    rules.append(py::make_tuple(rule.a, rule.b, rule.rule == scene::AllowedPairs::Rule::Allowed));
  return py::dict(
      "urdf"_a = text.urdf, "srdf"_a = text.srdf, "urdf_name"_a = text.urdf_name, "srdf_name"_a = text.srdf_name,
      "folder"_a = text.folder.string(), "thresholds"_a = text.thresholds, "thresholds_name"_a = text.thresholds_name,
      "config"_a = text.config, "config_name"_a = text.config_name, "config_folder"_a = text.config_folder.string(),
      "mesh_tolerance"_a = options.mesh_tolerance, "padding"_a = options.padding, "packages"_a = options.packages,
      "group"_a = options.pairs.group, "exclude_pairs"_a = options.pairs.exclude_pairs,
      "only_pairs"_a = options.pairs.only_pairs, "allow_missing_meshes"_a = options.allow_missing_meshes,
      "allow_broken_mimics"_a = options.allow_broken_mimics, "threads"_a = robot.threads(), "objects"_a = objects,
      "rules"_a = rules);
}

template <typename Value>
Value valueOf(const py::dict& state, const char* name) {
  return state[name].cast<Value>();
}

std::unique_ptr<Robot> robotOf(const py::dict& state) {
  using Text = std::string;
  RobotText text{valueOf<Text>(state, "urdf"),
                 valueOf<Text>(state, "srdf"),
                 valueOf<Text>(state, "urdf_name"),
                 valueOf<Text>(state, "srdf_name"),
                 valueOf<Text>(state, "folder"),
                 valueOf<std::optional<Text>>(state, "thresholds"),
                 valueOf<Text>(state, "thresholds_name"),
                 valueOf<std::optional<Text>>(state, "config"),
                 valueOf<Text>(state, "config_name"),
                 valueOf<Text>(state, "config_folder")};
  LoadOptions options = loadOptions(
      valueOf<std::optional<double>>(state, "mesh_tolerance"), valueOf<std::optional<Folders>>(state, "packages"),
      valueOf<std::optional<double>>(state, "padding"), valueOf<Text>(state, "group"),
      valueOf<NamePairs>(state, "exclude_pairs"), valueOf<NamePairs>(state, "only_pairs"),
      valueOf<bool>(state, "allow_missing_meshes"), valueOf<bool>(state, "allow_broken_mimics"));
  std::unique_ptr<Robot> robot = makeRobot(std::move(text), std::move(options), valueOf<int>(state, "threads"));
  std::vector<scene::ObjectEdit> objects;
  for (const auto& [name, object] : valueOf<std::vector<std::pair<Text, py::object>>>(state, "objects"))
    objects.push_back(objectOf(name, object));
  std::vector<scene::WrittenRule> rules;
  for (const auto& [a, b, is_allowed] : valueOf<std::vector<std::tuple<Text, Text, bool>>>(state, "rules"))
    rules.push_back({a, b, is_allowed ? scene::AllowedPairs::Rule::Allowed : scene::AllowedPairs::Rule::Checked});
  if (objects.empty() && rules.empty()) return robot;
  return withObjects(*robot, std::move(objects), rules, ObjectWarnings::Omit);
}

constexpr char kRobotDoc[] = R"(A robot with the pairs of its links, and of objects, that are checked.

Only its `threads` can be changed: with_object(), moved(), attached() and the like return another robot, which shares
all unchanged data. So the numbers of pairs in existing rows keep their meaning, a question of another thread is not
disturbed, and the robot without objects stays as it is. Many threads of Python may use a robot at once: the GIL is
released while a question is computed. Ctrl-C ends a question, and a load. A robot can be pickled; it is loaded again
from the texts of its files, and its meshes are read again from their files.

The argument q of each question holds joint positions [rad] or [m]: shape (..., joints), or (joints,) for one state, in
the order of Robot.joints, which need not be the order of the URDF. The answer has the leading shape. The columns of
mimic joints are ignored, as they follow their leaders, and so are floating and planar joints, which stay where they
are at 0. Any array that numpy casts to float64 safely is taken, in C or Fortran order; other strides and types are
copied (float32 exactly), complex numbers, objects and masked arrays are a TypeError. A wrong shape is a ValueError. A
state with a position that is not finite, in any column, has no answer: Status.UNKNOWN, Verdict.UNKNOWN. Limits of
joints are not looked at.

Each answer depends on its state alone, to the last bit: not on the other states and their number, nor on the threads,
the processor and the C library, with objects as without. The fields of the rows are described at the top of the module,
help(proximity); if the robot has thresholds, rows of PAIR become rows of LEVELED_PAIR.

A question that takes `time_budget` [s] ends when it is over, and returns what it has: the states that are not answered by
then have no answer (Status.UNKNOWN, Verdict.UNKNOWN, NaN), and neither have edges that were not begun. The bounds of an
edge that was begun hold; its status is ITERATION_LIMIT. Raises ValueError for a time that is negative or not a number.)";

constexpr char kLoadDoc[] = R"(Reads a URDF from a file.

urdf             path of the file; Robot.from_text takes the text
srdf             path of a file that tells which pairs not to check; None: neighbours are not checked, but all other
                 pairs are
mesh_tolerance   [m] how far the convex pieces may lie from the mesh that they stand for; 0: its triangles; None: that
                 of `config`, or 0.005
packages         folders in which package:// is looked for; None: the folders of ROS_PACKAGE_PATH, and /usr/share
padding          [m] is added to every piece; None: as in `config`, or 0
group            of the SRDF: only pairs that its joints can move are checked; "": as in `config`, or all
exclude_pairs    pairs of names of links that are not checked, in place of the pairs of `config`
only_pairs       if there are any, no other pair is checked
thresholds       path of YAML with the stop and warn distances, also of single pairs, links and groups; then rows
                 about pairs have a level. None: as in `config`, or none
config           path of YAML with the node's parameters, or of a dump of rosparam: what they say about geometry, pairs,
                 coupled limits, levels and objects counts; an argument that says otherwise is stronger
allow_missing_meshes  True: a mesh that cannot be read is a warning, and that geometry is NOT checked
allow_broken_mimics   True: a mimic that makes no sense, as of a joint that does not exist, is a warning, and the joint
                 has a column of its own
threads          see Robot.threads; None: as many as there are cores

Pieces of meshes are kept in the user's cache, so that the next time is fast; steps that take long are logged to
logging.getLogger("proximity").
Raises OSError (FileNotFoundError, ...) for a file that cannot be read, and ValueError for what is wrong in it, naming
file and link, joint or mesh. What is odd but legal is a UserWarning.)";

constexpr char kFromTextDoc[] =
    R"(Reads a URDF from its text; the SRDF, the thresholds and the configuration are texts too, "" if
there are none.

Relative paths of meshes begin at `folder`. All else is as in Robot(urdf).)";

constexpr char kWithObjectDoc[] = R"(Returns the robot with one more object.

name         neither the name of a link nor "*"; the pairs with the object are named by it
shapes       a shape (proximity.Box, Sphere, Mesh, ...), or a list of shapes and of pairs of a shape and its pose in the
             object
pose         of the object, in the frame of the root link, or in the frame of `link` or `frame`: a matrix (4, 4), or a
             position (3,);
             None: the identity
link         that holds the object, so that they do not touch each other; "": none
touch_links  other links that it may touch then
frame        a link that the object moves with, but that may not touch it; "": it stands still
padding      [m] is added to every shape
Meshes become convex pieces with the robot's mesh_tolerance. An object that stands still is not checked against links
that do. Raises ValueError naming the object and what is wrong; also for a name that is there.)";

constexpr char kWithPointsDoc[] =
    R"(Returns the robot with an object of the voxels that contain points, as of a depth camera.

points       float64 of shape (..., 3), in the frame of the root link; those with a number that is not finite are no
             returns, and left out. Points of the robot itself count, too: no state of it is known here
resolution   [m] the edge of a voxel. Distances are lower bounds for all points, and at most its diagonal too small
name         of the object, see with_object()
Raises ValueError naming the object; also if no point is left.)";

constexpr char kWithObjectsDoc[] =
    R"(Returns the robot with the objects of a file, and with its rules about what may touch.

The file is what `clearance --objects` reads: YAML, MoveIt's text if the name ends with ".scene", or a cloud. Objects that have
the name of one that is there replace it.
Raises OSError for a file that cannot be read, and ValueError naming file, line and object; also if the file has
changes.)";

constexpr char kMovedDoc[] =
    R"(Returns the robot with an object in another place, in which it stands or moves with a frame.

The arguments are the same as of with_object(). Raises ValueError for an object that a link holds: see detached().)";

constexpr char kAttachedDoc[] = R"(Returns the robot with a link that holds an object.

Either `pose`, in the frame of the link, or a state q in which the object stays where it is. Raises ValueError for an
object with a half-space.)";

constexpr char kDetachedDoc[] = R"(Returns the robot with an object that no link holds any more.

Either `pose`, in the frame of `frame` or of the root link, or a state q in which the object stays where it is.)";

constexpr char kWithoutDoc[] = R"(Returns the robot without an object.)";

constexpr char kAllowingDoc[] =
    R"(Returns the robot with two that may touch each other: an object, and a link or another object.

"*" stands for all others. Pairs of two links depend on the SRDF, exclude_pairs and only_pairs.)";

constexpr char kThreadsDoc[] = R"(How many threads a question uses, from 1 to 1024; fewer if there are few states.

The answers do not depend on it. Raises ValueError for another number.)";

constexpr char kRangesDoc[] =
    R"(Lowest and highest position of each joint, [rad] or [m], of shape (joints, 2), for sampling:
    numpy.random.default_rng(1).uniform(*robot.ranges.T, (states, len(robot.joints)))

The limits of the URDF, except for these: a continuous joint, and a revolute one without limits, makes one turn, from
-pi to pi; a revolute joint whose limits are more than a turn apart makes one turn about the middle of its limits,
unless other joints mimic it; a prismatic joint without limits goes from -1 m to 1 m, a guess; joints whose positions
are ignored have 0. The limits themselves are in Robot.joints.)";

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
                        std::optional<double> mesh_tolerance, const std::optional<Folders>& packages,
                        std::optional<double> padding, std::string group, NamePairs exclude_pairs, NamePairs only_pairs,
                        const std::optional<std::filesystem::path>& thresholds,
                        const std::optional<std::filesystem::path>& config, bool allow_missing_meshes,
                        bool allow_broken_mimics, std::optional<int> threads) {
              return robotOfFiles(
                  urdf, srdf, thresholds, config,
                  loadOptions(mesh_tolerance, packages, padding, std::move(group), std::move(exclude_pairs),
                              std::move(only_pairs), allow_missing_meshes, allow_broken_mimics),
                  threads);
            }),
            kLoadDoc, "urdf"_a, "srdf"_a = py::none(), py::kw_only(), "mesh_tolerance"_a = py::none(),
            "packages"_a = py::none(), "padding"_a = py::none(), "group"_a = "", "exclude_pairs"_a = NamePairs{},
            "only_pairs"_a = NamePairs{}, "thresholds"_a = py::none(), "config"_a = py::none(),
            "allow_missing_meshes"_a = false, "allow_broken_mimics"_a = false, "threads"_a = py::none());
  robot.def_static(
      "from_text",
      [](const std::string& urdf, const std::string& srdf, const std::filesystem::path& folder,
         std::optional<double> mesh_tolerance, const std::optional<Folders>& packages, std::optional<double> padding,
         std::string group, NamePairs exclude_pairs, NamePairs only_pairs, const std::string& thresholds,
         const std::string& config, bool allow_missing_meshes, bool allow_broken_mimics, std::optional<int> threads) {
        const auto given = [](const std::string& text) {
          return text.empty() ? std::nullopt : std::make_optional(text);
        };
        return asConfigured(
            makeRobot({urdf, srdf, "the URDF", "the SRDF", std::filesystem::absolute(folder), given(thresholds),
                       "the thresholds", given(config), "the configuration", std::filesystem::absolute(folder)},
                      loadOptions(mesh_tolerance, packages, padding, std::move(group), std::move(exclude_pairs),
                                  std::move(only_pairs), allow_missing_meshes, allow_broken_mimics),
                      threads));
      },
      kFromTextDoc, "urdf"_a, "srdf"_a = "", py::kw_only(), "folder"_a = ".", "mesh_tolerance"_a = py::none(),
      "packages"_a = py::none(), "padding"_a = py::none(), "group"_a = "", "exclude_pairs"_a = NamePairs{},
      "only_pairs"_a = NamePairs{}, "thresholds"_a = "", "config"_a = "", "allow_missing_meshes"_a = false,
      "allow_broken_mimics"_a = false, "threads"_a = py::none());
}

void declareProperties(py::class_<Robot>& robot) {
  robot.def_property_readonly(
      "name", [](const Robot& self) { return self.model()->robot.name; }, "of the robot in the URDF");
  robot.def_property_readonly("joints", &jointsOf, "The joints that move, in the order of the columns of q.");
  robot.def_property_readonly("ranges", &rangesOf, kRangesDoc);
  robot.def_property_readonly("pairs", &pairsOf,
                              "The checked pairs, as the names of two links, or of a link and an object, or of two "
                              "objects; the field `pair` is an index of it.");
  robot.def_property_readonly(
      "links", [](const Robot& self) { return scene::namesOf(self.model()->robot.links); },
      "The names of all links, in the order of link_poses; the root is the first.");
  robot.def_property_readonly("objects", &objectsOf, "The objects by their names: where each is now, and its shapes.");
  robot.def_property_readonly(
      "unchecked", &uncheckedOf,
      "The pairs of links with geometry that are not checked: the names of both links, and the reason.");
  robot.def_property_readonly(
      "warnings", [](const Robot& self) { return warningsOf(*self.model()); },
      "What is odd but legal in URDF and SRDF, a sentence each.");
  robot.def_property("threads", &Robot::threads, &Robot::setThreads, kThreadsDoc);
  robot.def("__repr__", &describe);
}

using Names = std::vector<std::string>;

void requireNewObject(const Robot& robot, const std::string& name) {
  if (robot.objects()->find(name) >= 0)
    throw std::invalid_argument("object " + scene::quoted(name) + ": there is one already; without() removes it");
}

void declareObjects(py::class_<Robot>& robot) {
  robot.def(
      "with_object",
      [](const Robot& self, const std::string& name, const py::object& shapes, const py::object& pose,
         const std::string& link, Names touch_links, const std::string& frame, double padding) {
        requireNewObject(self, name);
        std::vector<scene::ObjectEdit> objects{
            objectOf(name, shapes, pose, link, std::move(touch_links), frame, padding)};
        return withObjects(self, std::move(objects), {}, ObjectWarnings::Give);
      },
      kWithObjectDoc, "name"_a, "shapes"_a, "pose"_a = py::none(), py::kw_only(), "link"_a = "",
      "touch_links"_a = Names{}, "frame"_a = "", "padding"_a = 0.0);
  robot.def("with_objects", &withObjectFile, kWithObjectsDoc, "file"_a);
  robot.def(
      "with_points",
      [](const Robot& self, const PointArray& points, double resolution, const std::string& name) {
        requireNewObject(self, name);
        return withObjects(self, {objectOf(name, points, resolution)}, {}, ObjectWarnings::Give);
      },
      kWithPointsDoc, "points"_a, "resolution"_a = scene::kVoxelEdge, "name"_a = "points");
  robot.def(
      "moved",
      [](const Robot& self, const std::string& name, const py::object& pose, const std::string& frame) {
        return self.edited(editOf(Operation::Move, name, {"", {}, frame, poseOf(pose)}), py::none());
      },
      kMovedDoc, "name"_a, "pose"_a, py::kw_only(), "frame"_a = "");
  robot.def(
      "attached",
      [](const Robot& self, const std::string& name, const std::string& link, const py::object& pose,
         const py::object& q, Names touch_links) {
        return editedAtPoseOrState(self, editOf(Operation::Attach, name, {link, std::move(touch_links), ""}), pose, q);
      },
      kAttachedDoc, "name"_a, "link"_a, "pose"_a = py::none(), py::kw_only(), "q"_a = py::none(),
      "touch_links"_a = Names{});
  robot.def(
      "detached",
      [](const Robot& self, const std::string& name, const py::object& pose, const py::object& q,
         const std::string& frame) {
        return editedAtPoseOrState(self, editOf(Operation::Detach, name, {"", {}, frame}), pose, q);
      },
      kDetachedDoc, "name"_a, "pose"_a = py::none(), py::kw_only(), "q"_a = py::none(), "frame"_a = "");
  robot.def(
      "without",
      [](const Robot& self, const std::string& name) {
        return self.edited(editOf(Operation::Remove, name), py::none());
      },
      kWithoutDoc, "name"_a);
  robot.def("allowing", &Robot::allowing, kAllowingDoc, "a"_a, "b"_a);
}

}  // namespace
}  // namespace proximity_server::python

// The fields of a PairRow in a row with more of them, with names of the state and of the pair.
#define PROXIMITY_FIELDS_OF_PAIR(STATE, PAIR)                                                                         \
  pair.state, STATE, pair.status, "status", pair.unique, "unique", pair.depth_is_lower_bound, "depth_is_lower_bound", \
      pair.representation, "representation", pair.pair, PAIR, pair.distance, "distance", pair.lower, "lower",         \
      pair.upper, "upper", pair.point_a, "point_a", pair.point_b, "point_b", pair.normal, "normal"

PYBIND11_MODULE(_native, module) {
  using namespace proximity_server::python;
  module.doc() = "The compiled part of proximity.";
  pybind11::register_exception_translator(raiseReadable);
  PYBIND11_NUMPY_DTYPE(PairRow, state, status, unique, depth_is_lower_bound, representation, pair, distance, lower,
                       upper, point_a, point_b, normal);
  PYBIND11_NUMPY_DTYPE_EX(LevelRow, PROXIMITY_FIELDS_OF_PAIR("state", "pair"), level, "level");
  PYBIND11_NUMPY_DTYPE_EX(MinimumRow, PROXIMITY_FIELDS_OF_PAIR("edge", "pair"), time, "time");
  PYBIND11_NUMPY_DTYPE_EX(PointRow, PROXIMITY_FIELDS_OF_PAIR("state", "link"), point, "point");
  PYBIND11_NUMPY_DTYPE(HitRow, state, ray, hit, link, distance, free_until, point, normal);
  PYBIND11_NUMPY_DTYPE(VerdictRow, verdict, pair);
  PYBIND11_NUMPY_DTYPE(ProofRow, pair, outcome, lower, upper, undecided);
  PYBIND11_NUMPY_DTYPE(ContactRow, edge, status, contact, unique, representation, pair, t_free, t_contact, distance,
                       lower, upper, point_a, point_b, normal);
  module.attr("__version__") = PROXIMITY_VERSION;
  module.attr("CONTACT") = pybind11::dtype::of<ContactRow>();
  module.attr("EDGE_MINIMUM") = pybind11::dtype::of<MinimumRow>();
  module.attr("HIT") = pybind11::dtype::of<HitRow>();
  module.attr("PAIR") = pybind11::dtype::of<PairRow>();
  module.attr("LEVELED_PAIR") = pybind11::dtype::of<LevelRow>();
  module.attr("POINT") = pybind11::dtype::of<PointRow>();
  module.attr("PROOF") = pybind11::dtype::of<ProofRow>();
  module.attr("VERDICT") = pybind11::dtype::of<VerdictRow>();
  declareJoint(module);
  pybind11::class_<Robot> robot(module, "Robot", kRobotDoc);
  robot.attr("__module__") = "proximity";
  declareConstructors(robot);
  declareProperties(robot);
  declareObjects(robot);
  robot.def(pybind11::pickle(&stateOf, &robotOf));
  declareQuestions(robot);
}
