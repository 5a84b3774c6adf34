#include "python/questions.h"

#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/motion/motion_search.h"
#include "proximity_server/scene/points/point_search.h"
#include "proximity_server/scene/points/ray_search.h"
#include "proximity_server/scene/proof/prove_apart.h"
#include "python/driven_edges.h"
#include "python/rows.h"
#include "python/signal_watch.h"
#include "system/numbers.h"
#include "system/pipeline.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::python {
namespace {

namespace py = pybind11;
using namespace py::literals;

using Eigen::Index;
using Block = JointPositions::Block;
using TimeBudget = std::optional<double>;  // [s]; nullopt: none

// --- arrays

/// Makes a new array. Its shape is the shape of the states, followed by `shape`.
py::array newArray(const py::dtype& type, const JointPositions& positions, std::vector<py::ssize_t> shape) {
  shape.insert(shape.begin(), positions.shape().begin(), positions.shape().end());
  py::ssize_t bytes = type.itemsize();
  for (const py::ssize_t length : shape)
    if (__builtin_mul_overflow(bytes, std::max<py::ssize_t>(1, length), &bytes)) throw std::bad_alloc();
  return {type, shape};
}

template <typename Item>
py::array_t<Item> newArray(const JointPositions& positions, const std::vector<py::ssize_t>& shape = {}) {
  return newArray(py::dtype::of<Item>(), positions, shape);
}

/// A new array with NaN everywhere.
py::array_t<double> newNumbers(const JointPositions& positions, const std::vector<py::ssize_t>& shape = {}) {
  py::array_t<double> numbers = newArray<double>(positions, shape);
  std::fill_n(numbers.mutable_data(), numbers.size(), kNaN);
  return numbers;
}

/// Converts an array without dimensions into its single element, a numpy.void, whose fields also have names.
py::object scalarIfSingle(const py::array& array) {
  return array.ndim() == 0 ? py::object(array[py::tuple()]) : py::object(array);
}

/// An array of rows about pairs, with levels if the robot has thresholds.
class RowTable {
 public:
  explicit RowTable(py::array array)
      : array_(std::move(array)), data_(static_cast<char*>(array_.mutable_data())), row_size_(array_.itemsize()) {}

  const py::array& array() const { return array_; }

  /// Writes the beginning of `row`, as much as the array has fields. Does not need the GIL.
  void write(Index index, const LevelRow& row) {
    std::memcpy(data_ + index * row_size_, &row, static_cast<std::size_t>(row_size_));
  }

 private:
  py::array array_;
  char* data_;
  py::ssize_t row_size_;
};

py::dtype rowType(const Robot& robot) {
  return robot.thresholds() ? py::dtype::of<LevelRow>() : py::dtype::of<PairRow>();
}

RowTable newRows(const Robot& robot, const JointPositions& positions, const std::vector<py::ssize_t>& shape = {}) {
  return RowTable(newArray(rowType(robot), positions, shape));
}

LevelRow pairRow(const Robot& robot, Index state, const scene::PairProximity& pair) {
  return rowOf(state, pair, robot.pairs(), robot.thresholds());
}

// --- threads

/// Calls `answer(scratch, first, count)` for all blocks of `block` items, without the GIL. There are `count` items.
template <typename Answer>
void answerBlocks(Robot& robot, Index count, Index block, SignalWatch& watch, const Answer& answer) {
  const Index threads = std::max<Index>(1, std::min<Index>(robot.threads(), (count + block - 1) / block));
  watch.run([&] {
    std::vector<std::shared_ptr<Scratch>> scratch(static_cast<std::size_t>(threads));
    Index next = 0;
    const auto read = [&](Index& first) {
      first = next;
      next += block;
      return !watch.isInterrupted() && first < count;
    };
    const auto work = [&](Index first, int thread) {
      std::shared_ptr<Scratch>& own = scratch[thread];
      if (!own) own = robot.borrow();
      answer(*own, first, std::min(block, count - first));
    };
    system::runPipeline<Index>({read, work}, {static_cast<int>(threads), system::PipelineThreads::TooFew::Enough});
  });
}

/// The number of states in a block: large enough that the time to begin a block does not matter, and small enough that
/// many threads have work.
constexpr Index kBlock = 256;

/// Calls `answer(scratch, block, first)` for all blocks of states.
template <typename Answer>
void answerStates(Robot& robot, const JointPositions& positions, SignalWatch& watch, const Answer& answer) {
  const auto answerBlock = [&](Scratch& scratch, Index first, Index count) {
    answer(scratch, positions.block(first, count), first);
  };
  // The distances of one state take about as long as to start a thread.
  if (positions.count() != 1) return answerBlocks(robot, positions.count(), kBlock, watch, answerBlock);
  const py::gil_scoped_release released;
  answerBlock(*robot.borrow(), 0, 1);
}

double requireNumber(double value, const char* name) {
  if (std::isnan(value)) throw std::invalid_argument(std::string("the ") + name + " is not a number");
  return value;
}

// --- pairs

/// The closest pairs of one state, sorted.
struct AnsweredPairs {
  const scene::PairProximity *begin, *end;

  /// The i-th pair; an Unknown one if there are fewer.
  scene::PairProximity operator[](Index i) const { return i < end - begin ? begin[i] : scene::PairProximity{}; }
};

AnsweredPairs pairsOf(const scene::StatePairs& lists, Index state) {
  return {lists.pairs.data() + lists.begins[state], lists.pairs.data() + lists.begins[state + 1]};
}

AnsweredPairs pairsOf(const std::vector<scene::PairProximity>& minima, Index state) {
  const scene::PairProximity& minimum = minima[state];
  return {&minimum, &minimum + (minimum.result.status == narrowphase::Status::Unknown ? 0 : 1)};
}

/// Calls `visit(column of q, degree of freedom)` for all joints but floating and planar ones, and mimic joints, whose
/// part is in the column of the leader.
template <typename Visit>
void forEachColumn(const scene::State& state, const Visit& visit) {
  const scene::DegreesOfFreedom& degrees = state.degreesOfFreedom();
  for (int degree = 0; degree < degrees.size(); ++degree)
    if (scene::hasOnePosition(state.robot().joints[degrees[degree].joint])) visit(degrees[degree].joint, degree);
}

/// Writes the derivative of a pair's distance with respect to each column of q; NaN if it is not known.
void writeGradient(Scratch& scratch, const scene::PairProximity& pair, double* gradient) {
  const scene::State& state = scratch.state();
  scratch.by_degrees.resize(state.degreesOfFreedom().size());
  const bool is_known = pair.result.has_points && scene::gradient(state, pair, scratch.by_degrees);
  std::fill_n(gradient, state.robot().joints.size(), is_known ? 0.0 : kNaN);
  if (is_known) forEachColumn(state, [&](int column, int degree) { gradient[column] = scratch.by_degrees[degree]; });
}

/// Returns k rows for each state about the pairs that `ask(batch, block, deadline)` returns, or one row without k.
/// Writes as many gradients, unless `gradients` is nullptr.
template <typename Ask>
py::object answerRows(Robot& robot, const JointPositions& positions, std::optional<int> k, TimeBudget time_budget,
                      double* gradients, const Ask& ask) {
  RowTable rows = newRows(robot, positions, std::vector<py::ssize_t>(k ? 1 : 0, k.value_or(0)));
  const Index count = k.value_or(1);
  SignalWatch watch(time_budget);
  answerStates(robot, positions, watch, [&](Scratch& scratch, const Block& block, Index first) {
    const auto& answers = ask(scratch.batch(), block, watch.deadline());
    for (Index i = 0; i < block.rows(); ++i) {
      const AnsweredPairs of_state = pairsOf(answers, i);
      if (gradients && of_state.begin != of_state.end) scratch.place(block, i);
      for (Index j = 0, row = (first + i) * count; j < count; ++j, ++row) {
        rows.write(row, pairRow(robot, first + i, of_state[j]));
        if (gradients) writeGradient(scratch, of_state[j], gradients + row * block.cols());
      }
    }
  });
  return scalarIfSingle(rows.array());
}

/// The rows of the k closest pairs, or of the closest one without k.
py::object closestRows(Robot& robot, const JointPositions& positions, std::optional<int> k, TimeBudget time_budget,
                       double* gradients) {
  const auto one = [](auto& batch, auto& block, auto& deadline) -> auto& { return batch.minimum(block, deadline); };
  const auto some = [&](auto& batch, auto& block, auto& deadline) -> auto& {
    return batch.closest(block, *k, deadline);
  };
  return k ? answerRows(robot, positions, k, time_budget, gradients, some)
           : answerRows(robot, positions, k, time_budget, gradients, one);
}

int checkedCount(long k) {
  if (k < 1 || k > std::numeric_limits<int>::max())
    throw std::invalid_argument("k is " + std::to_string(k) + ", but must be from 1 to " +
                                std::to_string(std::numeric_limits<int>::max()));
  return static_cast<int>(k);
}

constexpr char kMinimumDoc[] = R"(The pair with the smallest signed distance in each state.

Returns rows of the dtype PAIR, of the shape of the states; for q of shape (joints,) one row. The status is UNKNOWN if a
position is not finite, or if the robot has no pair.

With `accuracy` [m], lower and upper bound the smallest distance of all pairs, are proven, and are at most so far apart;
1e-4 takes a fraction of the time. Then the status is THRESHOLD, the distance is the lower bound, and there are no
points. If upper is 0 or less, the pair overlaps; how deep is not told.
Raises ValueError if accuracy is not positive.)";

py::object minimum(Robot& robot, const py::object& q, std::optional<double> accuracy, TimeBudget time_budget) {
  if (accuracy && !(*accuracy > 0.0)) throw std::invalid_argument("accuracy must be positive");
  const JointPositions positions(q, robot.model()->robot);
  if (!accuracy) return closestRows(robot, positions, std::nullopt, time_budget, nullptr);
  const auto within = [&](auto& batch, auto& block, auto& deadline) -> auto& {
    return batch.minimumWithin(block, *accuracy, deadline);
  };
  return answerRows(robot, positions, std::nullopt, time_budget, nullptr, within);
}

constexpr char kLevelDoc[] = R"(The level of each state: the pair that sets it, with its level.

That is, of the pairs at the worst level the one with the smallest distance less its threshold (of WARN if the
level is CLEAR). It need not be the closest one.
Returns rows of the dtype LEVELED_PAIR, of the shape of the states; for q of shape (joints,) one row. The level is
INVALID where the status is UNKNOWN, as in minimum.
Raises ValueError if the robot was made without thresholds.)";

py::object level(Robot& robot, const py::object& q, TimeBudget time_budget) {
  if (!robot.thresholds()) throw std::invalid_argument("the robot was made without thresholds=, and has no levels");
  const auto deciding = [&](auto& batch, auto& block, auto& deadline) -> auto& {
    return batch.deciding(block, *robot.thresholds(), deadline);
  };
  return answerRows(robot, {q, robot.model()->robot}, std::nullopt, time_budget, nullptr, deciding);
}

constexpr char kClosestDoc[] = R"(The k pairs with the smallest signed distances in each state, sorted.

Returns rows of the dtype PAIR, of the shape of the states and k; for q of shape (joints,) of shape (k,). If there are
fewer pairs than k, the rows behind them have the status UNKNOWN and the pair -1.
Raises ValueError if k is less than 1.)";

py::object closest(Robot& robot, const py::object& q, long k, TimeBudget time_budget) {
  const JointPositions positions(q, robot.model()->robot);
  return closestRows(robot, positions, checkedCount(k), time_budget, nullptr);
}

constexpr char kGradientDoc[] = R"(Distances with their derivatives by q.

Returns the rows of minimum(q), or of closest(q, k) if k is given, and the gradients of their distances: the same
shape with one more dimension, for the columns of q. Units are [m/rad] and [m/m]; positive where the distance grows, in
overlap where the depth shrinks. Columns that are ignored have 0: the part of a mimic joint is in the column of its
leader. A row without an answer has NaN.
The distance has a kink where the field `unique` is False: this is then the derivative of one choice of points.
The smallest distance has another kink where two pairs are equally close, which rows of closest(q, 2) show.
Raises ValueError if k is less than 1.)";

py::tuple gradient(Robot& robot, const py::object& q, std::optional<long> k, TimeBudget time_budget) {
  const JointPositions positions(q, robot.model()->robot);
  std::vector<py::ssize_t> shape;
  if (k) shape.push_back(checkedCount(*k));
  shape.push_back(static_cast<py::ssize_t>(robot.model()->robot.joints.size()));
  py::array_t<double> gradients = newArray<double>(positions, shape);
  const std::optional<int> count = k ? std::optional(static_cast<int>(*k)) : std::nullopt;
  const py::object rows = closestRows(robot, positions, count, time_budget, gradients.mutable_data());
  return py::make_tuple(rows, gradients);
}

constexpr char kBelowDoc[] =
    R"(Whether anything is at or below a signed distance [m] in each state: much cheaper than minimum.

Returns rows of the dtype VERDICT, of the shape of the states; for q of shape (joints,) one row. ABOVE is proven; a pair
counts as below unless its lower bound proves otherwise.
Raises ValueError if the distance is NaN.)";

py::object below(Robot& robot, const py::object& q, double distance, TimeBudget time_budget) {
  const JointPositions positions(q, robot.model()->robot);
  py::array_t<VerdictRow> rows = newArray<VerdictRow>(positions);
  VerdictRow* const out = rows.mutable_data();
  SignalWatch watch(time_budget);
  answerStates(robot, positions, watch, [&](Scratch& scratch, const Block& block, Index first) {
    const std::vector<scene::StateVerdict>& verdicts = scratch.batch().anyBelow(block, distance, watch.deadline());
    std::transform(verdicts.begin(), verdicts.end(), out + first,
                   [](const scene::StateVerdict& verdict) { return rowOf(verdict); });
  });
  return scalarIfSingle(rows);
}

constexpr char kPairsBelowDoc[] = R"(All pairs at or below a signed distance [m] in each state.

Returns rows of the dtype PAIR in one dimension, sorted by state, and within a state by distance. A state without an
answer has one row, of status UNKNOWN and pair -1: a state without a row is proven to be above the distance.
Raises ValueError if the distance is NaN.)";

py::object pairsBelow(Robot& robot, const py::object& q, double distance, TimeBudget time_budget) {
  const JointPositions positions(q, robot.model()->robot);
  std::mutex mutex;
  std::map<Index, std::vector<LevelRow>> found;  // by the first state of the block
  SignalWatch watch(time_budget);
  answerStates(robot, positions, watch, [&](Scratch& scratch, const Block& block, Index first) {
    const scene::StatePairs& below = scratch.batch().below(block, distance, watch.deadline());
    std::vector<LevelRow> rows;
    rows.reserve(below.pairs.size());
    for (Index i = 0; i < block.rows(); ++i) {
      const AnsweredPairs pairs = pairsOf(below, i);
      const Index count = below.unknown[i] != 0 ? 1 : pairs.end - pairs.begin;  // 1: a row without an answer
      for (Index j = 0; j < count; ++j) rows.push_back(pairRow(robot, first + i, pairs[j]));
    }
    const std::lock_guard<std::mutex> lock(mutex);
    found.emplace(first, std::move(rows));
  });
  py::ssize_t count = 0;
  for (const auto& [first, rows] : found) count += static_cast<py::ssize_t>(rows.size());
  RowTable all(py::array(rowType(robot), std::vector<py::ssize_t>{count}));
  Index next = 0;
  for (const auto& [first, rows] : found)
    for (const LevelRow& row : rows) all.write(next++, row);
  return all.array();
}

// --- uncertainty and motions

/// [m] In each state of the block the smallest guaranteed distance belongs to a pair that is not farther apart.
double reachOfGuarantees(Scratch& scratch, const Block& block, const scene::Deadline& deadline) {
  constexpr double kSlack = 1e-6;  // [m] more than the tolerance of a distance and all rounding
  const std::vector<scene::PairProximity>& closest = scratch.batch().minimum(block, deadline);
  double reach = 0.0;
  for (Index i = 0; i < block.rows(); ++i) {
    const narrowphase::SignedDistance& result = closest[i].result;
    if (result.status == narrowphase::Status::Unknown) continue;
    scratch.guaranteed().forget();  // no state depends on the states before it
    reach = std::max(reach, result.upper_bound + scratch.guaranteed().largestLoss(scratch.place(block, i)) + kSlack);
  }
  return reach;
}

constexpr char kGuaranteedDoc[] = R"(The smallest distance that is guaranteed where the state is not known exactly.

uncertainty  how far all may be off: a number, [rad] or [m] of the position of every joint; or a dict, or YAML, with the
             names of the node's parameters: {"joint_uncertainty": {"*": 0.001, "lift": 0.002}, "object_uncertainty":
             0.003}; see config/README.md
Returns (rows, guaranteed): the pair that decides as a row of the dtype PAIR, with its distance in q itself, and a lower
bound [m] of the distance of every pair over all states within the uncertainty. Both have the shape of the states; NaN
for a state without an answer. The bound is proven, with rounding, and may be lower than any state within gives.
Raises ValueError for an uncertainty that makes no sense, naming the field.)";

py::tuple guaranteed(Robot& robot, const py::object& q, const py::object& uncertainty, TimeBudget time_budget) {
  const bool is_text = py::isinstance<py::str>(uncertainty);
  const py::object text = is_text ? uncertainty : py::module_::import("json").attr("dumps")(uncertainty);
  const scene::RobotModel& model = robot.model()->robot;
  const scene::Uncertainty within = scene::uncertaintyFrom(text.cast<std::string>(), "uncertainty", model);
  const JointPositions positions(q, model);
  RowTable rows = newRows(robot, positions);
  py::array_t<double> guaranteed = newArray<double>(positions);
  double* const out = guaranteed.mutable_data();
  SignalWatch watch(time_budget);
  scene::GuaranteeLimits limits;
  limits.deadline = watch.deadline();
  answerBlocks(robot, positions.count(), kBlock, watch, [&](Scratch& scratch, Index first, Index count) {
    const Block block = positions.block(first, count);
    scene::GuaranteedDistances& bounds = scratch.guaranteed();
    bounds.assume(within);
    bounds.limit(limits);
    const double reach = reachOfGuarantees(scratch, block, limits.deadline);
    const scene::StatePairs& near = scratch.batch().below(block, reach, limits.deadline);
    for (Index i = 0; i < count; ++i) {
      scene::GuaranteedMinimum found;
      const AnsweredPairs pairs = pairsOf(near, i);
      const bool is_known = near.unknown[i] == 0 && !limits.deadline.hasPassed();
      bounds.forget();
      if (is_known) found = bounds.find(scratch.place(block, i), {pairs.begin, pairs.end, reach});
      rows.write(first + i, pairRow(robot, first + i, found.pair));
      out[first + i] = is_known && found.unknown == 0 ? found.guaranteed : kNaN;
    }
  });
  return py::make_tuple(scalarIfSingle(rows.array()), scalarIfSingle(guaranteed));
}

/// Calls `write(state, scratch)` for each state with an answer: Scratch::freeMotion() is about this state.
template <typename Write>
void answerFreeMotions(Robot& robot, const JointPositions& positions, double distance, double influence_distance,
                       TimeBudget time_budget, const Write& write) {
  if (!std::isfinite(distance)) throw std::invalid_argument("the distance must be finite");
  if (!(influence_distance >= 0.0) || std::isinf(influence_distance))
    throw std::invalid_argument("influence_distance must be finite and not negative");
  scene::FreeMotionQuestion question;
  question.thresholds = scene::PairDistances(distance, distance);
  question.influence_distance = distance + influence_distance;
  SignalWatch watch(time_budget);
  answerStates(robot, positions, watch, [&](Scratch& scratch, const Block& block, Index first) {
    const scene::StatePairs& near = scratch.batch().below(block, question.influence_distance, watch.deadline());
    for (Index i = 0; i < block.rows(); ++i) {
      if (near.unknown[i] != 0 || watch.deadline().hasPassed()) continue;
      const AnsweredPairs pairs = pairsOf(near, i);
      scratch.freeMotion().find(scratch.place(block, i), pairs.begin, pairs.end, question);
      write(first + i, scratch);
    }
  });
}

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

py::object freeMotion(Robot& robot, const py::object& q, double distance, double influence_distance,
                      TimeBudget time_budget) {
  const JointPositions positions(q, robot.model()->robot);
  const auto columns = static_cast<Index>(robot.model()->robot.joints.size());
  py::array_t<double> free_of_joints = newNumbers(positions, {columns});
  double* const out = free_of_joints.mutable_data();
  answerFreeMotions(robot, positions, distance, influence_distance, time_budget, [&](Index state, Scratch& scratch) {
    double* const row = out + state * columns;
    std::fill_n(row, columns, 0.0);
    forEachColumn(scratch.state(), [&](int column, int degree) { row[column] = scratch.freeMotion().alone(degree); });
  });
  return free_of_joints;
}

constexpr char kFreeScaleDoc[] = R"(How much of a motion [rad] or [m] is proven to be free without a search.

q and motion are arrays of shapes that broadcast to one. Returns float64 of the shape of the states: the largest s in
[0, 1] for which the straight motion from q to q + s motion, and every part of it, keeps each pair farther apart than the
distance, as far as free_motion() can tell; it takes each pair by itself, and so finds more than the sum over the joints
there. first_contact() searches, and finds all. Columns of motion that q ignores are ignored. NaN for a state or a motion
that is not finite.)";

py::object freeScale(Robot& robot, const py::object& q, const py::object& motion, double distance,
                     double influence_distance, TimeBudget time_budget) {
  const scene::RobotModel& model = robot.model()->robot;
  const std::vector<JointPositions> given =
      JointPositions::broadcast({{"q", jointArray(q, model, "q")}, {"motion", jointArray(motion, model, "motion")}});
  py::array_t<double> scales = newNumbers(given[0]);
  double* const out = scales.mutable_data();
  answerFreeMotions(robot, given[0], distance, influence_distance, time_budget, [&](Index state, Scratch& scratch) {
    const Block moved = given[1].block(state, 1);
    if (!moved.allFinite()) return;
    scratch.by_degrees.setZero(scratch.state().degreesOfFreedom().size());
    forEachColumn(scratch.state(), [&](int column, int degree) { scratch.by_degrees[degree] = moved(0, column); });
    out[state] = scratch.freeMotion().scale(scratch.by_degrees);
  });
  return scalarIfSingle(scales);
}

/// The known ranges of the joints, with these ends in their place if they are not None.
scene::JointBox boxBetween(const py::object& lower, const py::object& upper, const scene::RobotModel& robot) {
  scene::JointBox box = scene::knownRanges(robot);
  const auto setEnds = [&](const py::object& ends, const std::string& name, double scene::JointRange::*end) {
    if (ends.is_none()) return;
    const JointPositions positions(ends, robot, name);
    if (!positions.shape().empty()) throw std::invalid_argument(name + " must have one number for each joint");
    for (const scene::JointRange& sampled : scene::jointRanges(robot)) {
      const int joint = sampled.joint;
      const auto found = std::find_if(box.begin(), box.end(), [&](const auto& range) { return range.joint == joint; });
      scene::JointRange& range = found == box.end() ? box.emplace_back(scene::JointRange{joint, kNaN, kNaN}) : *found;
      range.*end = positions.block(0, 1)(0, joint);
    }
  };
  setEnds(lower, "lower", &scene::JointRange::lower);
  setEnds(upper, "upper", &scene::JointRange::upper);
  return box;
}

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

py::tuple prove(Robot& robot, const py::object& lower, const py::object& upper, double distance, long boxes,
                TimeBudget time_budget, TimeBudget seconds) {
  if (time_budget && seconds) throw py::type_error("seconds is another name of time_budget: give one of them");
  const scene::JointBox box = boxBetween(lower, upper, robot.model()->robot);
  SignalWatch watch(time_budget ? time_budget : seconds);
  scene::ProofQuestion question;
  question.contact_distance = distance;
  question.most_boxes = boxes;
  question.deadline = watch.deadline();
  question.objects = robot.objects();
  question.threads = robot.threads();
  const std::vector<scene::ShapeRefPair>& asked = robot.pairs().list();
  std::vector<scene::PairProof> proofs;
  watch.run([&] { proofs = scene::proveApart(robot.model(), asked, box, question); });
  py::array_t<ProofRow> rows(static_cast<py::ssize_t>(proofs.size()));
  const auto joints = static_cast<py::ssize_t>(robot.model()->robot.joints.size());
  py::array_t<double> closest({rows.size(), joints});
  double* const out = closest.mutable_data();
  std::fill_n(out, closest.size(), kNaN);
  for (int i = 0; i < static_cast<int>(proofs.size()); ++i) {
    rows.mutable_data()[i] = rowOf(i, proofs[i]);
    std::copy(proofs[i].closest.begin(), proofs[i].closest.end(), out + i * joints);
  }
  return py::make_tuple(rows, closest);
}

// --- points and rays

using Names = std::optional<std::vector<std::string>>;

/// The links and objects of these names; nullopt gives none, which stands for all.
std::vector<scene::ShapeRef> shapesNamed(const Robot& robot, const Names& links) {
  std::vector<scene::ShapeRef> shapes;
  if (links && links->empty()) throw std::invalid_argument("links is empty; None stands for all");
  for (const std::string& name : links.value_or(std::vector<std::string>())) {
    shapes.push_back(robot.shapeNamed(name));
    if (shapes.back().isLink() && !robot.model()->robot.hasGeometry(shapes.back().link()))
      throw std::invalid_argument("link " + scene::quoted(name) + " has no collision geometry");
  }
  return shapes;
}

Eigen::Vector3d vectorOf(const JointPositions& vectors, Index index) {
  return vectors.block(index, 1).row(0).transpose();
}

scene::Question questionWithin(double tolerance, const SignalWatch& watch) {
  scene::Question question;
  question.tolerance = requireNumber(tolerance, "tolerance");
  question.deadline = watch.deadline();
  return question;
}

/// Calls `answer(scratch, state, first, count, is_known)` for all points or rays in all states, of which there are
/// `count` in each, in parts. The state is placed if its positions are finite; else it is not known.
template <typename Answer>
void answerParts(Robot& robot, const JointPositions& positions, Index count, SignalWatch& watch, const Answer& answer) {
  constexpr Index kPart = 1024;  // so many that the time to place a state does not matter
  const Index parts = (count + kPart - 1) / kPart, together = std::max<Index>(1, kPart / std::max<Index>(1, count));
  answerBlocks(robot, positions.count() * parts, together, watch, [&](Scratch& scratch, Index begin, Index tasks) {
    for (Index task = begin; task < begin + tasks; ++task) {
      const Index state = task / parts, first = task % parts * kPart;
      const Block block = positions.block(state, 1);
      const bool is_known = block.allFinite();
      if (is_known) scratch.place(block, 0);
      answer(scratch, state, first, std::min(kPart, count - first), is_known);
    }
  });
}

constexpr char kPointDistanceDoc[] =
    R"(The signed distance of points from the robot, each from the closest link or held object.

points       float64 of shape (..., 3), in the frame of the root link; points and radii are of shapes that broadcast to one
radii        [m] of balls about the points: a number, or one for each; it is subtracted from the distance
links        names of the links and objects that count; None: all links, and all objects that links hold
threshold    [m] beyond it a lower bound is enough: the status is THRESHOLD, and there is no link. Much cheaper where most
             points are far
gradient     True: returns (rows, gradients), as the question gradient() does, of points at rest
tolerance    [m] between lower and upper
Returns rows of the dtype POINT, of the shape of the states and then of the points; for one of each one row. Negative
inside: minus the shortest way out of a convex piece or of a closed mesh, which may be longer for the whole link where
depth_is_lower_bound. The same bits for a point alone and among others.
Raises ValueError for a point that is not finite and a radius that is negative or not finite, by their numbers; for a
name of nothing, a link without geometry, and a threshold or tolerance that is NaN.)";

py::object pointDistance(Robot& robot, const py::object& q, const py::object& points, const py::object& radii,
                         const Names& links, double threshold, bool wants_gradient, double tolerance,
                         TimeBudget time_budget) {
  const JointPositions positions(q, robot.model()->robot);
  const std::vector<JointPositions> given =
      JointPositions::broadcast({{"points", vectorArray(points, "points")}, {"radii", columnArray(radii, "radii")}});
  scene::Points all{{}, {}, shapesNamed(robot, links)};
  for (Index i = 0; i < given[0].count(); ++i) {
    all.centres.push_back(vectorOf(given[0], i));
    all.radii.push_back(vectorOf(given[1], i).x());
  }
  scene::requireValid(all);
  SignalWatch watch(time_budget);
  scene::Question question = questionWithin(tolerance, watch);
  question.threshold = requireNumber(threshold, "threshold");

  const Index count = given[0].count(), columns = static_cast<Index>(robot.model()->robot.joints.size());
  std::vector<py::ssize_t> shape = given[0].shape();
  py::array_t<PointRow> rows = newArray<PointRow>(positions, shape);
  shape.push_back(wants_gradient ? columns : 0);
  py::array_t<double> gradients = newArray<double>(positions, shape);
  PointRow* const out = rows.mutable_data();
  double* const out_gradients = gradients.mutable_data();
  const auto answer = [&](Scratch& scratch, Index state, Index first, Index of_part, bool is_known) {
    const auto part = [&](const auto& list) {
      return std::vector(list.begin() + first, list.begin() + first + of_part);
    };
    const scene::Points asked{part(all.centres), part(all.radii), all.shapes};
    const auto* found = is_known ? &scratch.points().closest(scratch.state(), asked, question) : nullptr;
    if (!scratch.points().unplaced().empty()) found = nullptr;
    const scene::PairProximity no_answer;
    for (Index i = 0; i < of_part; ++i) {
      const scene::PairProximity& pair = found ? (*found)[i] : no_answer;
      const Index row = state * count + first + i;
      out[row] = rowOf(state, first + i, pair, *robot.objects());
      if (wants_gradient) writeGradient(scratch, pair, out_gradients + row * columns);
    }
  };
  answerParts(robot, positions, count, watch, answer);
  const py::object answered = scalarIfSingle(rows);
  return wants_gradient ? py::object(py::make_tuple(answered, gradients)) : answered;
}

constexpr char kFirstHitDoc[] =
    R"(What rays meet first, or the proof that they are free: for simulated sensors, and for views.

origins      float64 of shape (..., 3), in the frame of the root link
directions   the same, of any length; origins, directions and ranges are of shapes that broadcast to one
ranges       [m] how far the rays go: a number, or one for each
links        names of the links and objects that count; None: all links and all objects
tolerance    [m] a ray that passes a surface as near as that may be a hit
Returns rows of the dtype HIT, of the shape of the states and then of the rays; for one of each one row. A ray that
begins inside hits at 0.
Raises ValueError for an origin or direction that is not finite, a direction of 0 and a range that is not positive, by their
numbers; for a name of nothing, a link without geometry, and a tolerance that is NaN.)";

py::object firstHit(Robot& robot, const py::object& q, const py::object& origins, const py::object& directions,
                    const py::object& ranges, const Names& links, double tolerance, TimeBudget time_budget) {
  const JointPositions positions(q, robot.model()->robot);
  const std::vector<JointPositions> given =
      JointPositions::broadcast({{"origins", vectorArray(origins, "origins")},
                                 {"directions", vectorArray(directions, "directions")},
                                 {"ranges", columnArray(ranges, "ranges")}});
  const std::vector<scene::ShapeRef> shapes = shapesNamed(robot, links);
  const Index count = given[0].count();
  std::vector<scene::Ray> rays;
  for (Index i = 0; i < count; ++i)
    rays.push_back({vectorOf(given[0], i), vectorOf(given[1], i), vectorOf(given[2], i).x()});
  scene::requireValid(rays);
  SignalWatch watch(time_budget);
  const scene::Question question = questionWithin(tolerance, watch);
  py::array_t<HitRow> rows = newArray<HitRow>(positions, given[0].shape());
  HitRow* const out = rows.mutable_data();
  answerParts(
      robot, positions, count, watch, [&](Scratch& scratch, Index state, Index first, Index of_part, bool is_known) {
        const std::vector<scene::Ray> part(rays.begin() + first, rays.begin() + first + of_part);
        const auto* hits = is_known ? &scratch.rays().firstHits(scratch.state(), part, shapes, question) : nullptr;
        if (!scratch.rays().unplaced().empty()) hits = nullptr;
        const scene::RayHit no_answer;
        for (Index i = 0; i < of_part; ++i)
          out[state * count + first + i] =
              rowOf(state, first + i, part[i], hits ? (*hits)[i] : no_answer, *robot.objects());
      });
  return scalarIfSingle(rows);
}

constexpr char kLinkPosesDoc[] = R"(The pose of each link in the frame of the root link.

Returns float64 of the shape of the states, the links in the order of Robot.links, and (4, 4): a matrix that maps
coordinates of the link into the root link. A state with a position that is not finite has NaN.)";

py::object linkPoses(Robot& robot, const py::object& q) {
  using Matrix = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  const scene::RobotModel& model = robot.model()->robot;
  const int links = static_cast<int>(model.links.size());
  const JointPositions positions(q, model);
  py::array_t<double> poses = newArray<double>(positions, {links, 4, 4});
  double* const out = poses.mutable_data();
  SignalWatch watch;
  answerStates(robot, positions, watch, [&](Scratch& scratch, const Block& block, Index first) {
    for (Index i = 0; i < block.rows(); ++i) {
      double* pose = out + (first + i) * links * Matrix::SizeAtCompileTime;
      if (!block.row(i).allFinite()) {
        std::fill_n(pose, links * Matrix::SizeAtCompileTime, kNaN);
        continue;
      }
      positionsOf(block, i, scratch.positions);
      const scene::BodyPoses of_bodies = scene::forwardKinematics(model, scratch.positions);
      for (int link = 0; link < links; ++link, pose += Matrix::SizeAtCompileTime)
        Eigen::Map<Matrix>{pose} = scene::poseOfLink(model, link, of_bodies).matrix();
    }
  });
  return poses;
}

// --- edges

/// Returns the row of the answer of each edge; `ask` is a question of MotionSearch.
template <typename Found>
py::object answerEdges(Robot& robot, const DrivenEdges& edges, scene::MotionQuestion question, TimeBudget time_budget,
                       Found (scene::MotionSearch::*ask)(const scene::Pairs&, const scene::Motion&,
                                                         const scene::MotionQuestion&)) {
  constexpr Index kEdgesInBlock = 16;  // fewer than states, because an edge takes much longer
  using Row = decltype(rowOf(0, Found(), robot.pairs()));
  SignalWatch watch(time_budget);
  question.deadline = watch.deadline();
  py::array_t<Row> rows = newArray<Row>(edges.start());
  Row* const out = rows.mutable_data();
  const scene::RobotMotion::ObjectFrames frames = scene::framesOnLinks(*robot.objects());
  // No edge depends on the edges before it, and so each has a search of its own.
  const auto answerEdge = [&](const DrivenEdges::Edge& edge, const scene::State& state) -> Found {
    if (!edge.is_finite || watch.deadline().hasPassed()) return {};
    scene::Motion motion(robot.model()->robot, edge.start, edge.goal, edges.trackingError());
    motion.carryObjects(frames);
    scene::MotionSearch search(state);
    return (search.*ask)(robot.candidates(), motion, question);
  };
  answerBlocks(robot, edges.start().count(), kEdgesInBlock, watch, [&](Scratch& scratch, Index first, Index count) {
    for (Index i = first; i < first + count; ++i)
      out[i] = rowOf(i, answerEdge(edges.at(i), scratch.state()), robot.pairs());
  });
  return scalarIfSingle(rows);
}

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

py::object firstContact(Robot& robot, const py::object& start, const py::object& goal, double distance,
                        double tolerance, const py::object& velocities, const py::object& accelerations,
                        const py::object& duration, const py::object& tracking_error, TimeBudget time_budget) {
  scene::MotionQuestion question;
  question.contact_distance = requireNumber(distance, "distance");
  question.tolerance = requireNumber(tolerance, "tolerance");
  const DrivenEdges edges(start, goal, {velocities, accelerations, duration, tracking_error}, robot.model()->robot);
  return answerEdges(robot, edges, question, time_budget, &scene::MotionSearch::timeOfContact);
}

constexpr char kMinimumBetweenDoc[] = R"(The smallest signed distance on the way from start to goal.

The way is the same as in first_contact, with the same keywords.
Returns rows of the dtype EDGE_MINIMUM, of the shape of the edges; for one edge one row. lower and upper are proven for
the whole way, and upper is the distance of the pair at the time. With a tracking_error lower is proven for every motion
within it, and upper is the distance of a state within it; the two may be farther apart than the tolerance.
tolerance  [m] between lower and upper
Raises ValueError as first_contact.)";

py::object minimumBetween(Robot& robot, const py::object& start, const py::object& goal, double tolerance,
                          const py::object& velocities, const py::object& accelerations, const py::object& duration,
                          const py::object& tracking_error, TimeBudget time_budget) {
  scene::MotionQuestion question;
  question.tolerance = requireNumber(tolerance, "tolerance");
  const DrivenEdges edges(start, goal, {velocities, accelerations, duration, tracking_error}, robot.model()->robot);
  return answerEdges(robot, edges, question, time_budget, &scene::MotionSearch::minimum);
}

}  // namespace

void declareQuestions(py::class_<Robot>& robot) {
  const py::arg_v budget = "time_budget"_a = py::none();
  robot.def("minimum", &minimum, kMinimumDoc, "q"_a, py::kw_only(), "accuracy"_a = py::none(), budget);
  robot.def("level", &level, kLevelDoc, "q"_a, py::kw_only(), budget);
  robot.def("closest", &closest, kClosestDoc, "q"_a, "k"_a, py::kw_only(), budget);
  robot.def("below", &below, kBelowDoc, "q"_a, "distance"_a, py::kw_only(), budget);
  robot.def("pairs_below", &pairsBelow, kPairsBelowDoc, "q"_a, "distance"_a, py::kw_only(), budget);
  robot.def("gradient", &gradient, kGradientDoc, "q"_a, "k"_a = py::none(), py::kw_only(), budget);
  robot.def("guaranteed", &guaranteed, kGuaranteedDoc, "q"_a, "uncertainty"_a, py::kw_only(), budget);
  robot.def("free_motion", &freeMotion, kFreeMotionDoc, "q"_a, "distance"_a = 0.0, py::kw_only(),
            "influence_distance"_a = 0.2, budget);
  robot.def("free_scale", &freeScale, kFreeScaleDoc, "q"_a, "motion"_a, "distance"_a = 0.0, py::kw_only(),
            "influence_distance"_a = 0.2, budget);
  robot.def("prove", &prove, kProveDoc, "lower"_a = py::none(), "upper"_a = py::none(),
            "distance"_a = scene::kContactDistance, py::kw_only(), "boxes"_a = 100000, budget,
            "seconds"_a = py::none());
  robot.def("point_distance", &pointDistance, kPointDistanceDoc, "q"_a, "points"_a, "radii"_a = 0.0, py::kw_only(),
            "links"_a = py::none(), py::arg_v("threshold", kInfinity, "math.inf"), "gradient"_a = false,
            "tolerance"_a = 1e-9, budget);
  robot.def("first_hit", &firstHit, kFirstHitDoc, "q"_a, "origins"_a, "directions"_a,
            py::arg_v("ranges", kInfinity, "math.inf"), py::kw_only(), "links"_a = py::none(), "tolerance"_a = 1e-9,
            budget);
  robot.def("link_poses", &linkPoses, kLinkPosesDoc, "q"_a);
  robot.def("first_contact", &firstContact, kFirstContactDoc, "start"_a, "goal"_a, "distance"_a = 0.0, py::kw_only(),
            "tolerance"_a = 1e-6, "velocities"_a = py::none(), "accelerations"_a = py::none(), "duration"_a = 1.0,
            "tracking_error"_a = py::none(), budget);
  robot.def("minimum_between", &minimumBetween, kMinimumBetweenDoc, "start"_a, "goal"_a, py::kw_only(),
            "tolerance"_a = 1e-6, "velocities"_a = py::none(), "accelerations"_a = py::none(), "duration"_a = 1.0,
            "tracking_error"_a = py::none(), budget);
}

}  // namespace proximity_server::python
