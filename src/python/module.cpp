// The extension module proximity._native. Users import it through src/python/proximity/__init__.py. The docstrings are
// the reference of the module: help(proximity.Robot).
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "python/loading.h"
#include "python/object_arguments.h"
#include "python/path_caster.h"
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
#include <limits>
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
  const std::vector<scene::Joint>& joints = robot.model().robot.joints;
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

using PairNames = std::pair<std::string, std::string>;

std::vector<PairNames> pairsOf(const Robot& robot) {
  std::vector<PairNames> names;
  const auto nameOf = [&](const scene::ShapeRef& ref) {
    return scene::nameOf(ref, robot.model().robot, &robot.objects());
  };
  for (const scene::ShapeRefPair& pair : robot.pairs().list()) names.emplace_back(nameOf(pair.a), nameOf(pair.b));
  return names;
}

std::vector<std::tuple<std::string, std::string, std::string>> uncheckedOf(const Robot& robot) {
  const scene::RobotModel& model = robot.model().robot;
  std::vector<std::tuple<std::string, std::string, std::string>> list;
  for (const scene::LinkPair& pair : robot.model().pairs.pairs) {
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
  return "<proximity.Robot " + scene::quoted(robot.model().robot.name) + ": " +
         std::to_string(robot.model().robot.joints.size()) + " joints, " + std::to_string(robot.pairs().list().size()) +
         " pairs" +
         (robot.objects().empty() ? ""
                                  : ", " + std::to_string(robot.objects().size()) +
                                        (robot.objects().size() == 1 ? " object" : " objects")) +
         ">";
}

/// The keyword arguments of Robot() and Robot.from_text().
struct Keywords {
  double mesh_tolerance;
  std::optional<std::vector<std::filesystem::path>> packages;
  double padding;
  std::string group;
  NamePairs exclude_pairs, only_pairs;
  bool allow_missing_meshes, allow_broken_mimics;
  std::optional<int> threads;
};

LoadOptions loadOptions(const Keywords& keywords) {
  LoadOptions options;
  options.mesh_tolerance = keywords.mesh_tolerance;
  options.padding = keywords.padding;
  if (keywords.packages) {
    options.packages.emplace();
    for (const std::filesystem::path& folder : *keywords.packages)
      options.packages->push_back(folder.empty() ? "" : std::filesystem::absolute(folder).string());
  }
  options.pairs.group = keywords.group;
  options.pairs.exclude_pairs = keywords.exclude_pairs;
  options.pairs.only_pairs = keywords.only_pairs;
  options.allow_missing_meshes = keywords.allow_missing_meshes;
  options.allow_broken_mimics = keywords.allow_broken_mimics;
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

std::unique_ptr<Robot> makeRobot(RobotText text, const Keywords& keywords) {
  const int all_cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  SignalWatch watch;
  std::unique_ptr<Robot> robot;
  watch.run([&] {
    robot = std::make_unique<Robot>(std::move(text), loadOptions(keywords), keywords.threads.value_or(all_cores),
                                    watch.stop());
  });
  return robot;
}

std::unique_ptr<Robot> withWarnings(std::unique_ptr<Robot> robot) {
  for (const std::string& warning : warningsOf(robot->model())) warn(robot->text().urdf_name + ": " + warning);
  return robot;
}

std::unique_ptr<Robot> robotOfFiles(const std::filesystem::path& urdf, const std::optional<std::filesystem::path>& srdf,
                                    const std::optional<std::filesystem::path>& thresholds, const Keywords& keywords) {
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
  text.folder = std::filesystem::absolute(urdf).parent_path();
  return withWarnings(makeRobot(std::move(text), keywords));
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
  const std::string where = "object " + scene::quoted(name) + ": ";
  if (!link.empty() && !frame.empty()) throw std::invalid_argument(where + "it has a link or a frame, but not both");
  if (link.empty() && !touch_links.empty())
    throw std::invalid_argument(where + "touch_links goes with a link that holds the object");
  try {
    return {name, {link, std::move(touch_links), frame, poseOf(pose)}, padding, shapesOf(shapes), ""};
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(where + error.what());
  }
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
  for (const int number : robot.objects().numbers()) {
    const scene::Object& object = *robot.objects().object(number);
    objects[py::str(object.id)] = describedObject(object);
  }
  return objects;
}

std::unique_ptr<Robot> withObjectFile(const Robot& robot, const std::filesystem::path& path) {
  static_cast<void>(readTextFile(path));  // throws OSError if the file cannot be read
  scene::ObjectFile file = scene::readObjectFile(path.string());
  if (!file.changes.empty())
    throw std::invalid_argument(path.string() +
                                ": it has changes, which are those of states on a way: the tool clearance makes them");
  return withObjects(robot, std::move(file.objects), file.rules, ObjectWarnings::Give);
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

// --- pickles

py::dict stateOf(const Robot& robot) {
  const RobotText& text = robot.text();
  const LoadOptions& options = robot.options();
  std::vector<std::pair<int, std::string>> names;  // sorted by number, which decides the order of two objects in a pair
  for (const int number : robot.objects().numbers()) names.emplace_back(number, robot.objects().object(number)->id);
  std::sort(names.begin(), names.end());
  py::list objects, rules;
  for (const auto& [number, name] : names)
    objects.append(py::make_tuple(name, describedObject(*robot.objects().object(number))));
  for (const scene::WrittenRule& rule : robot.rules())
    rules.append(py::make_tuple(rule.a, rule.b, rule.rule == scene::AllowedPairs::Rule::Allowed));
  using namespace py::literals;
  return py::dict("urdf"_a = text.urdf, "srdf"_a = text.srdf, "urdf_name"_a = text.urdf_name,
                  "srdf_name"_a = text.srdf_name, "folder"_a = text.folder.string(), "thresholds"_a = text.thresholds,
                  "thresholds_name"_a = text.thresholds_name, "mesh_tolerance"_a = options.mesh_tolerance,
                  "padding"_a = options.padding, "packages"_a = options.packages, "group"_a = options.pairs.group,
                  "exclude_pairs"_a = options.pairs.exclude_pairs, "only_pairs"_a = options.pairs.only_pairs,
                  "allow_missing_meshes"_a = options.allow_missing_meshes,
                  "allow_broken_mimics"_a = options.allow_broken_mimics, "threads"_a = robot.threads(),
                  "objects"_a = objects, "rules"_a = rules);
}

template <typename Value>
Value valueOf(const py::dict& state, const char* name) {
  return state[name].cast<Value>();
}

std::unique_ptr<Robot> robotOf(const py::dict& state) {
  using Text = std::string;
  RobotText text{valueOf<Text>(state, "urdf"),           valueOf<Text>(state, "srdf"),
                 valueOf<Text>(state, "urdf_name"),      valueOf<Text>(state, "srdf_name"),
                 valueOf<Text>(state, "folder"),         valueOf<std::optional<Text>>(state, "thresholds"),
                 valueOf<Text>(state, "thresholds_name")};
  const Keywords keywords{valueOf<double>(state, "mesh_tolerance"),
                          valueOf<std::optional<std::vector<std::filesystem::path>>>(state, "packages"),
                          valueOf<double>(state, "padding"),
                          valueOf<Text>(state, "group"),
                          valueOf<NamePairs>(state, "exclude_pairs"),
                          valueOf<NamePairs>(state, "only_pairs"),
                          valueOf<bool>(state, "allow_missing_meshes"),
                          valueOf<bool>(state, "allow_broken_mimics"),
                          valueOf<int>(state, "threads")};
  std::unique_ptr<Robot> robot = makeRobot(std::move(text), keywords);
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
the order of Robot.joints, which need not be that of the URDF. The answer has the leading shape. The columns of mimic
joints are ignored, as they follow their leaders, and so are those of floating and planar joints, which stay where they
are at 0. Any array that numpy casts to float64 safely is taken, in C or Fortran order; other strides and types are
copied (float32 exactly), complex numbers, objects and masked arrays are a TypeError. A wrong shape is a ValueError. A
state with a position that is not finite, in any column, has no answer: Status.UNKNOWN, Verdict.UNKNOWN. Limits of
joints are not looked at.

Each answer depends on its state alone, to the last bit: not on the other states and their number, nor on the threads,
the processor and the C library, with objects as without. The fields of the rows are described at the top of the module,
help(proximity); where the robot has thresholds, those of PAIR are rows of LEVELED_PAIR.

A question that takes `time_budget` [s] ends when it is over, and returns what it has: the states that are not answered by
then have no answer (Status.UNKNOWN, Verdict.UNKNOWN, NaN), and neither have edges that were not begun. The bounds of an
edge that was begun hold; its status is ITERATION_LIMIT. Raises ValueError for a time that is negative or not a number.)";

constexpr char kLoadDoc[] = R"(Reads a URDF from a file.

urdf             path of the file; Robot.from_text takes the text
srdf             path of a file that tells which pairs not to check; None: neighbours are not checked, but all other
                 pairs are
mesh_tolerance   [m] how far the convex pieces may lie from the mesh that they stand for; 0: its triangles
packages         folders in which package:// is looked for; None: those of ROS_PACKAGE_PATH, and /usr/share
padding          [m] is added to every piece
group            of the SRDF: only pairs that its joints can move are checked; "": all
exclude_pairs    pairs of names of links that are not checked
only_pairs       if there are any, no other pair is checked
thresholds       path of YAML with the stop and warn distances, also those of single pairs, links and groups; then rows
                 about pairs have a level. None: they have none
allow_missing_meshes  True: a mesh that cannot be read is a warning, and that geometry is NOT checked
allow_broken_mimics   True: a mimic that makes no sense, as of a joint that does not exist, is a warning, and the joint
                 has a column of its own
threads          see Robot.threads; None: as many as there are cores

Pieces of meshes are kept in the user's cache, so that the next time is fast; steps that take long are logged to
logging.getLogger("proximity").
Raises OSError (FileNotFoundError, ...) for a file that cannot be read, and ValueError for what is wrong in it, naming
file and link, joint or mesh. What is odd but legal is a UserWarning.)";

constexpr char kFromTextDoc[] =
    R"(Reads a URDF from its text; the SRDF and the thresholds are texts too, "" if there are none.

Relative paths of meshes begin at `folder`. All else is as in Robot(urdf).)";

constexpr char kMinimumDoc[] = R"(The pair with the smallest signed distance in each state.

Returns rows of the dtype PAIR, of the shape of the states; for q of shape (joints,) one row. The status is UNKNOWN if a
position is not finite, or if the robot has no pair.

With `accuracy` [m], lower and upper bound the smallest distance of all pairs, are proven, and are at most so far apart;
1e-4 takes a fraction of the time. Then the status is THRESHOLD, the distance is the lower bound, and there are no
points. If upper is 0 or less, the pair overlaps; how deep is not told.
Raises ValueError if accuracy is not positive.)";

constexpr char kLevelDoc[] = R"(The level of each state: the pair that sets it, with its level.

That is, of the pairs at the worst level the one with the smallest distance less its threshold (that of WARN if the
level is CLEAR). It need not be the closest one.
Returns rows of the dtype LEVELED_PAIR, of the shape of the states; for q of shape (joints,) one row. The level is
INVALID where the status is UNKNOWN, as in minimum.
Raises ValueError if the robot was made without thresholds.)";

constexpr char kClosestDoc[] = R"(The k pairs with the smallest signed distances in each state, sorted.

Returns rows of the dtype PAIR, of the shape of the states and k; for q of shape (joints,) of shape (k,). If there are
fewer pairs than k, the rows behind them have the status UNKNOWN and the pair -1.
Raises ValueError if k is less than 1.)";

constexpr char kBelowDoc[] =
    R"(Whether anything is at or below a signed distance [m] in each state: much cheaper than minimum.

Returns rows of the dtype VERDICT, of the shape of the states; for q of shape (joints,) one row. ABOVE is proven; a pair
counts as below unless its lower bound proves otherwise.
Raises ValueError if the distance is NaN.)";

constexpr char kPairsBelowDoc[] = R"(All pairs at or below a signed distance [m] in each state.

Returns rows of the dtype PAIR in one dimension, sorted by state, and within a state by distance. A state without an
answer has one row, of status UNKNOWN and pair -1: a state without a row is proven to be above the distance.
Raises ValueError if the distance is NaN.)";

constexpr char kGradientDoc[] = R"(Distances with their derivatives by q.

Returns the rows of minimum(q), or those of closest(q, k) if k is given, and the gradients of their distances: the same
shape with one more dimension, for the columns of q. Units are [m/rad] and [m/m]; positive where the distance grows, in
overlap where the depth shrinks. Columns that are ignored have 0: the part of a mimic joint is in the column of its
leader. A row without an answer has NaN.
The distance has a kink where the field `unique` is False: this is then the derivative of one choice of points.
The smallest distance has another kink where two pairs are equally close, which rows of closest(q, 2) show.
Raises ValueError if k is less than 1.)";

constexpr char kFreeMotionDoc[] =
    R"(How far each joint can move while every pair stays farther apart than the distance [m].

Returns float64 of the shape of q, [rad] or [m]: each joint alone is free to move so far in both directions, and all
together as long as sum |motion / free| <= 1 (numpy.nansum, if there are joints with 0). That is proven without a
search, and holds for motions of any length: a bound on how far each point of a link moves. Infinity for a joint that
moves no pair; 0 where a pair is at or below the distance, and for columns that are ignored: a mimic joint moves with its
leader, and its part is in the column of the leader. NaN for a state without an answer.
influence_distance  [m] beyond the distance. All pairs that are farther apart share one bound; a larger one costs more,
                    and finds more for states that are far from everything.
Source: Quinlan, Real-Time Modification of Collision-Free Paths, 1994.
Raises ValueError if distance or influence_distance is not finite, or influence_distance is negative.)";

constexpr char kFreeScaleDoc[] = R"(How much of a motion [rad] or [m] is proven to be free without a search.

q and motion are arrays of shapes that broadcast to one. Returns float64 of the shape of the states: the largest s in
[0, 1] for which the straight motion from q to q + s motion, and every part of it, keeps each pair farther apart than the
distance, as far as free_motion() can tell; it takes each pair by itself, and so finds more than the sum over the joints
there. first_contact() searches, and finds all. Columns of motion that q ignores are ignored. NaN for a state or a motion
that is not finite.)";

constexpr char kGuaranteedDoc[] = R"(The smallest distance that is guaranteed where the state is not known exactly.

uncertainty  how far all may be off: a number, [rad] or [m] of the position of every joint; or a dict, or YAML, with the
             names of the node's parameters: {"joint_uncertainty": {"*": 0.001, "lift": 0.002}, "object_uncertainty":
             0.003}; see config/README.md
Returns (rows, guaranteed): the pair that decides as a row of the dtype PAIR, with its distance in q itself, and a lower
bound [m] of the distance of every pair over all states within the uncertainty. Both have the shape of the states; NaN
for a state without an answer. The bound is proven, with rounding, and may be lower than any state within gives.
Raises ValueError for an uncertainty that makes no sense, naming the field.)";

constexpr char kProveDoc[] =
    R"(Which pairs cannot come to a distance [m] or below in a whole box of joint positions: proofs, not samples.

lower, upper  the ends of the intervals, float64 of shape (joints,); by default the limits of the URDF, and a turn of a
              continuous joint. Columns of mimic joints are ignored: they follow their leader
distance      at least 0; flush faces are 0 apart by rounding only
boxes         parts of the box that are examined for each pair at most
time_budget   [s] after which what is left is undecided; with it the answer depends on the computer
seconds       another name of time_budget
Returns (rows, closest): for each of Robot.pairs a row of the dtype PROOF, and the state in which the pair was found
closest, float64 of shape (pairs, joints), NaN where none was measured. See scene/proof/prove_apart.h.
Raises ValueError, with its name, for a floating or planar joint between two links of a pair, and for a joint whose
interval is missing, empty or not finite.)";

constexpr char kLinkPosesDoc[] = R"(The pose of each link in the frame of the root link.

Returns float64 of the shape of the states, the links in the order of Robot.links, and (4, 4): a matrix that maps
coordinates of the link into the root link. A state with a position that is not finite has NaN.)";

constexpr char kFirstContactDoc[] = R"(When anything first comes to a signed distance [m] on the way from start to goal.

All joints move at once, each at constant speed; the time is 0 at the start and 1 at the goal. start and goal are arrays
as q, of shapes that broadcast to one. With velocities the way is the cubic spline that joint_trajectory_controller
drives, with accelerations too the quintic one; a row is then about one segment of a trajectory.
Returns rows of the dtype CONTACT, of the shape of the edges; for one edge one row. Nothing is missed between samples:
until t_free every pair is proven to be farther than the distance.
tolerance       [m] of the distance at which a contact is found
velocities      a pair of arrays as start and goal, [rad/s] or [m/s]: at the start and at the goal; they broadcast too
accelerations   the same by second squared; only with velocities
duration        [s] of an edge, a number or an array of the shape of the edges; needed for velocities only
tracking_error  [rad] or [m], a number, or one for each joint: how far each joint may be off the way at any time. t_free
                then holds for every motion within it. A contact is a state within it; without a known state the status
                is DEGENERATE from t_free on
Raises ValueError if distance or tolerance is NaN, for a duration that is not positive, a tracking_error that is
negative or not finite, and accelerations without velocities.)";

constexpr char kMinimumBetweenDoc[] = R"(The smallest signed distance on the way from start to goal.

The way is that of first_contact, with the same keywords.
Returns rows of the dtype EDGE_MINIMUM, of the shape of the edges; for one edge one row. lower and upper are proven for
the whole way, and upper is the distance of the pair at the time. With a tracking_error lower is proven for every motion
within it, and upper is the distance of a state within it; the two may be farther apart than the tolerance.
tolerance  [m] between lower and upper
Raises ValueError as first_contact.)";

constexpr char kWithObjectDoc[] = R"(Returns the robot with one more object; one of the same name is replaced.

name         neither that of a link nor "*"; the pairs with the object are named by it
shapes       a shape (proximity.Box, Sphere, Mesh, ...), or a list of shapes and of pairs of a shape and its pose in the
             object
pose         of the object, in the frame of the root link, or in that of `link` or `frame`: a matrix (4, 4), or a
             position (3,);
             None: the identity
link         that holds the object, so that they do not touch each other; "": none
touch_links  other links that it may touch then
frame        a link that the object moves with, but that may not touch it; "": it stands still
padding      [m] is added to every shape
Meshes become convex pieces with the robot's mesh_tolerance. An object that stands still is not checked against links
that do. Raises ValueError naming the object and what is wrong.)";

constexpr char kWithObjectsDoc[] =
    R"(Returns the robot with the objects of a file, and with its rules about what may touch.

The file is what `clearance --objects` reads: YAML, or MoveIt's text if the name ends with ".scene". Objects that have
the name of one that is there replace it.
Raises OSError for a file that cannot be read, and ValueError naming file, line and object; also if the file has
changes.)";

constexpr char kMovedDoc[] =
    R"(Returns the robot with an object in another place, in which it stands or moves with a frame.

The arguments are those of with_object(). Raises ValueError for an object that a link holds: see detached().)";

constexpr char kAttachedDoc[] = R"(Returns the robot with a link that holds an object.

Either `pose`, in the frame of the link, or a state q in which the object stays where it is. Raises ValueError for an
object with a half-space.)";

constexpr char kDetachedDoc[] = R"(Returns the robot with an object that no link holds any more.

Either `pose`, in the frame of `frame` or of the root link, or a state q in which the object stays where it is.)";

constexpr char kWithoutDoc[] = R"(Returns the robot without an object.)";

constexpr char kAllowingDoc[] =
    R"(Returns the robot with two that may touch each other: an object, and a link or another object.

"*" stands for all others. Pairs of two links are those of the SRDF, exclude_pairs and only_pairs.)";

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
  robot.def(
      py::init([](const std::filesystem::path& urdf, const std::optional<std::filesystem::path>& srdf,
                  double mesh_tolerance, std::optional<std::vector<std::filesystem::path>> packages, double padding,
                  std::string group, NamePairs exclude_pairs, NamePairs only_pairs,
                  const std::optional<std::filesystem::path>& thresholds, bool allow_missing_meshes,
                  bool allow_broken_mimics, std::optional<int> threads) {
        return robotOfFiles(urdf, srdf, thresholds,
                            {mesh_tolerance, std::move(packages), padding, std::move(group), std::move(exclude_pairs),
                             std::move(only_pairs), allow_missing_meshes, allow_broken_mimics, threads});
      }),
      kLoadDoc, "urdf"_a, "srdf"_a = py::none(), py::kw_only(), "mesh_tolerance"_a = 0.005, "packages"_a = py::none(),
      "padding"_a = 0.0, "group"_a = "", "exclude_pairs"_a = NamePairs{}, "only_pairs"_a = NamePairs{},
      "thresholds"_a = py::none(), "allow_missing_meshes"_a = false, "allow_broken_mimics"_a = false,
      "threads"_a = py::none());
  robot.def_static(
      "from_text",
      [](const std::string& urdf, const std::string& srdf, const std::filesystem::path& folder, double mesh_tolerance,
         std::optional<std::vector<std::filesystem::path>> packages, double padding, std::string group,
         NamePairs exclude_pairs, NamePairs only_pairs, const std::string& thresholds, bool allow_missing_meshes,
         bool allow_broken_mimics, std::optional<int> threads) {
        return withWarnings(
            makeRobot({urdf, srdf, "the URDF", "the SRDF", std::filesystem::absolute(folder),
                       thresholds.empty() ? std::nullopt : std::make_optional(thresholds), "the thresholds"},
                      {mesh_tolerance, std::move(packages), padding, std::move(group), std::move(exclude_pairs),
                       std::move(only_pairs), allow_missing_meshes, allow_broken_mimics, threads}));
      },
      kFromTextDoc, "urdf"_a, "srdf"_a = "", py::kw_only(), "folder"_a = ".", "mesh_tolerance"_a = 0.005,
      "packages"_a = py::none(), "padding"_a = 0.0, "group"_a = "", "exclude_pairs"_a = NamePairs{},
      "only_pairs"_a = NamePairs{}, "thresholds"_a = "", "allow_missing_meshes"_a = false,
      "allow_broken_mimics"_a = false, "threads"_a = py::none());
}

void declareProperties(py::class_<Robot>& robot) {
  robot.def_property_readonly(
      "name", [](const Robot& self) { return self.model().robot.name; }, "of the robot in the URDF");
  robot.def_property_readonly("joints", &jointsOf, "The joints that move, in the order of the columns of q.");
  robot.def_property_readonly("ranges", &rangesOf, kRangesDoc);
  robot.def_property_readonly("pairs", &pairsOf,
                              "The checked pairs, as the names of two links, or of a link and an object, or of two "
                              "objects; the field `pair` is an index of it.");
  robot.def_property_readonly(
      "links", [](const Robot& self) { return scene::namesOf(self.model().robot.links); },
      "The names of all links, in the order of link_poses; the root is the first.");
  robot.def_property_readonly("objects", &objectsOf, "The objects by their names: where each is now, and its shapes.");
  robot.def_property_readonly(
      "unchecked", &uncheckedOf,
      "The pairs of links with geometry that are not checked: the names of both links, and the reason.");
  robot.def_property_readonly(
      "warnings", [](const Robot& self) { return warningsOf(self.model()); },
      "What is odd but legal in URDF and SRDF, a sentence each.");
  robot.def_property("threads", &Robot::threads, &Robot::setThreads, kThreadsDoc);
  robot.def("__repr__", &describe);
}

using Names = std::vector<std::string>;

void declareObjects(py::class_<Robot>& robot) {
  robot.def(
      "with_object",
      [](const Robot& self, const std::string& name, const py::object& shapes, const py::object& pose,
         const std::string& link, Names touch_links, const std::string& frame, double padding) {
        std::vector<scene::ObjectEdit> objects{
            objectOf(name, shapes, pose, link, std::move(touch_links), frame, padding)};
        return withObjects(self, std::move(objects), {}, ObjectWarnings::Give);
      },
      kWithObjectDoc, "name"_a, "shapes"_a, "pose"_a = py::none(), py::kw_only(), "link"_a = "",
      "touch_links"_a = Names{}, "frame"_a = "", "padding"_a = 0.0);
  robot.def("with_objects", &withObjectFile, kWithObjectsDoc, "file"_a);
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

void declareQuestions(py::class_<Robot>& robot) {
  robot.def("minimum", &Robot::minimum, kMinimumDoc, "q"_a, py::kw_only(), "accuracy"_a = py::none(),
            "time_budget"_a = py::none());
  robot.def("level", &Robot::level, kLevelDoc, "q"_a, py::kw_only(), "time_budget"_a = py::none());
  robot.def("closest", &Robot::closest, kClosestDoc, "q"_a, "k"_a, py::kw_only(), "time_budget"_a = py::none());
  robot.def("below", &Robot::below, kBelowDoc, "q"_a, "distance"_a, py::kw_only(), "time_budget"_a = py::none());
  robot.def("pairs_below", &Robot::pairsBelow, kPairsBelowDoc, "q"_a, "distance"_a, py::kw_only(),
            "time_budget"_a = py::none());
  robot.def("gradient", &Robot::gradient, kGradientDoc, "q"_a, "k"_a = py::none(), py::kw_only(),
            "time_budget"_a = py::none());
  robot.def(
      "guaranteed",
      [](Robot& self, const py::object& q, const py::object& uncertainty, Robot::TimeBudget time_budget) {
        const bool is_text = py::isinstance<py::str>(uncertainty);
        const py::object text = is_text ? uncertainty : py::module_::import("json").attr("dumps")(uncertainty);
        return self.guaranteed(q, text.cast<std::string>(), time_budget);
      },
      kGuaranteedDoc, "q"_a, "uncertainty"_a, py::kw_only(), "time_budget"_a = py::none());
  robot.def("free_motion", &Robot::freeMotion, kFreeMotionDoc, "q"_a, "distance"_a = 0.0, py::kw_only(),
            "influence_distance"_a = 0.2, "time_budget"_a = py::none());
  robot.def("free_scale", &Robot::freeScale, kFreeScaleDoc, "q"_a, "motion"_a, "distance"_a = 0.0, py::kw_only(),
            "influence_distance"_a = 0.2, "time_budget"_a = py::none());
  robot.def(
      "prove",
      [](Robot& self, const py::object& lower, const py::object& upper, double distance, long boxes,
         Robot::TimeBudget time_budget, Robot::TimeBudget seconds) {
        if (time_budget && seconds) throw py::type_error("seconds is another name of time_budget: give one of them");
        return self.prove(lower, upper, distance, boxes, time_budget ? time_budget : seconds);
      },
      kProveDoc, "lower"_a = py::none(), "upper"_a = py::none(), "distance"_a = scene::kContactDistance, py::kw_only(),
      "boxes"_a = 100000, "time_budget"_a = py::none(), "seconds"_a = py::none());
  robot.def("link_poses", &Robot::linkPoses, kLinkPosesDoc, "q"_a);
  robot.def(
      "first_contact",
      [](Robot& self, const py::object& start, const py::object& goal, double distance, double tolerance,
         const py::object& velocities, const py::object& accelerations, const py::object& duration,
         const py::object& tracking_error, Robot::TimeBudget time_budget) {
        return self.firstContact(start, goal, distance, tolerance,
                                 {velocities, accelerations, duration, tracking_error}, time_budget);
      },
      kFirstContactDoc, "start"_a, "goal"_a, "distance"_a = 0.0, py::kw_only(), "tolerance"_a = 1e-6,
      "velocities"_a = py::none(), "accelerations"_a = py::none(), "duration"_a = 1.0, "tracking_error"_a = py::none(),
      "time_budget"_a = py::none());
  robot.def(
      "minimum_between",
      [](Robot& self, const py::object& start, const py::object& goal, double tolerance, const py::object& velocities,
         const py::object& accelerations, const py::object& duration, const py::object& tracking_error,
         Robot::TimeBudget time_budget) {
        return self.minimumBetween(start, goal, tolerance, {velocities, accelerations, duration, tracking_error},
                                   time_budget);
      },
      kMinimumBetweenDoc, "start"_a, "goal"_a, py::kw_only(), "tolerance"_a = 1e-6, "velocities"_a = py::none(),
      "accelerations"_a = py::none(), "duration"_a = 1.0, "tracking_error"_a = py::none(),
      "time_budget"_a = py::none());
}

}  // namespace
}  // namespace proximity_server::python

PYBIND11_MODULE(_native, module) {
  using namespace proximity_server::python;
  module.doc() = "The compiled part of proximity.";
  pybind11::register_exception_translator(raiseReadable);
  PYBIND11_NUMPY_DTYPE(PairRow, state, status, unique, depth_is_lower_bound, representation, pair, distance, lower,
                       upper, point_a, point_b, normal);
  PYBIND11_NUMPY_DTYPE(VerdictRow, verdict, pair);
  PYBIND11_NUMPY_DTYPE(ProofRow, pair, outcome, lower, upper, undecided);
  PYBIND11_NUMPY_DTYPE(ContactRow, edge, status, contact, unique, representation, pair, t_free, t_contact, distance,
                       lower, upper, point_a, point_b, normal);
  module.attr("__version__") = PROXIMITY_VERSION;
  module.attr("CONTACT") = pybind11::dtype::of<ContactRow>();
  module.attr("EDGE_MINIMUM") = minimumType();
  module.attr("PAIR") = pybind11::dtype::of<PairRow>();
  module.attr("LEVELED_PAIR") = leveledPairType();
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
