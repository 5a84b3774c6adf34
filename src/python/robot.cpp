#include "python/robot.h"

#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/derivative/free_motion.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "proximity_server/scene/motion/spline_scene.h"
#include "proximity_server/scene/proof/prove_apart.h"
#include "proximity_server/scene/uncertainty/guaranteed_distances.h"
#include "python/signal_watch.h"
#include "system/numbers.h"
#include "system/pipeline.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
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

namespace py = pybind11;

/// The number of states in a block: large enough that the time to begin a block does not matter, and small enough that
/// many threads have work.
constexpr Eigen::Index kBlock = 256;

struct LoadedRobot {
  LoadedRobot(RobotText robot_text, LoadOptions load_options, const std::atomic<bool>* stop)
      : text(std::move(robot_text)),
        options(std::move(load_options)),
        model(load(text, options, stop)),
        thresholds(thresholdsOf(text, model->robot)),
        batch(model) {}

  /// Each thread takes copies made by forAnotherThread(). It is made when it is first needed.
  const scene::State& state() const {
    std::call_once(has_state, [this] { fresh_state.emplace(model); });
    return *fresh_state;
  }

  RobotText text;
  LoadOptions options;
  std::shared_ptr<const scene::SceneModel> model;
  std::optional<scene::LevelThresholds> thresholds;
  scene::SceneBatch batch;  ///< without objects
  mutable std::once_flag has_state;
  mutable std::optional<scene::State> fresh_state;
};

/// The scenes of one thread. Each of them is made when a question first needs it.
struct Scratch {
  Scratch(std::shared_ptr<const LoadedRobot> shared, std::shared_ptr<const scene::Objects> robot_objects)
      : loaded(std::move(shared)), objects(std::move(robot_objects)) {}

  /// With the objects.
  scene::State& posed() {
    if (!state) {
      state.emplace(loaded->state().forAnotherThread());
      state->set(objects, scene::carriersOnLinks(*objects));
    }
    return *state;
  }

  std::shared_ptr<const LoadedRobot> loaded;
  std::shared_ptr<const scene::Objects> objects;
  std::optional<scene::SceneBatch> batch;
  std::optional<scene::State> state;
  std::optional<scene::FreeMotion> free_motion;
  std::optional<scene::GuaranteedDistances> guaranteed;
  std::vector<double> positions, goal;  ///< of one state, or of an edge
  Eigen::VectorXd by_degrees;           ///< a gradient or a motion with respect to the degrees of freedom
};

/// An array of rows. A row has the fields of a PairRow, or of another struct that begins with these fields.
class RowTable {
 public:
  explicit RowTable(py::array array)
      : array_(std::move(array)), data_(static_cast<char*>(array_.mutable_data())), row_size_(array_.itemsize()) {}

  const py::array& array() const { return array_; }

  /// Writes the beginning of `row`, as much as the fields of the array need. Does not need the GIL.
  template <typename Row>
  void write(Eigen::Index index, const Row& row) {
    std::memcpy(data_ + index * row_size_, &row, static_cast<std::size_t>(row_size_));
  }

 private:
  py::array array_;
  char* data_;
  py::ssize_t row_size_;
};

namespace {

/// Makes the dtype of PAIR with one more field at its end. `rename` maps names of fields to new names.
py::dtype pairTypeAnd(const std::string& name, const py::dtype& type, std::size_t offset, std::size_t size,
                      const std::map<std::string, std::string>& rename) {
  const py::dtype pair = py::dtype::of<PairRow>();
  const py::dict fields = pair.attr("fields");
  py::list names, formats, offsets;
  for (const py::handle& field : pair.attr("names")) {
    const auto renamed = rename.find(field.cast<std::string>());
    names.append(renamed == rename.end() ? py::object(py::str(field)) : py::str(renamed->second));
    formats.append(fields[field][py::int_(0)]);
    offsets.append(fields[field][py::int_(1)]);
  }
  names.append(name);
  formats.append(type);
  offsets.append(offset);
  return {names, formats, offsets, static_cast<py::ssize_t>(size)};
}

}  // namespace

py::dtype leveledPairType() {
  return pairTypeAnd("level", py::dtype::of<std::int64_t>(), offsetof(LevelRow, level), sizeof(LevelRow), {});
}

py::dtype minimumType() {
  return pairTypeAnd("time", py::dtype::of<double>(), offsetof(MinimumRow, time), sizeof(MinimumRow),
                     {{"state", "edge"}});
}

namespace {

using RowMajor4d = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

using Operation = scene::ObjectEdit::Operation;

constexpr int kMaxThreads = 1024;

/// Makes a new array. Its shape is that of the states, followed by `shape`.
py::array newArray(const py::dtype& type, const JointPositions& positions, std::vector<py::ssize_t> shape) {
  shape.insert(shape.begin(), positions.shape().begin(), positions.shape().end());
  py::ssize_t bytes = type.itemsize();
  for (const py::ssize_t length : shape)
    if (__builtin_mul_overflow(bytes, std::max<py::ssize_t>(1, length), &bytes)) throw std::bad_alloc();
  return {type, shape};
}

template <typename Item>
py::array_t<Item> newArray(const JointPositions& positions, const std::vector<py::ssize_t>& shape) {
  return newArray(py::dtype::of<Item>(), positions, shape);
}

/// Converts an array without dimensions into its single element, a numpy.void, whose fields also have names.
py::object scalarIfSingle(const py::array& array) {
  return array.ndim() == 0 ? py::object(array[py::tuple()]) : py::object(array);
}

int checkedCount(long k) {
  if (k < 1 || k > std::numeric_limits<int>::max())
    throw std::invalid_argument("k is " + std::to_string(k) + ", but must be from 1 to " +
                                std::to_string(std::numeric_limits<int>::max()));
  return static_cast<int>(k);
}

double requireNumber(double value, const char* name) {
  if (std::isnan(value)) throw std::invalid_argument(std::string("the ") + name + " is not a number");
  return value;
}

py::dtype rowType(const scene::LevelThresholds* thresholds) {
  return thresholds ? leveledPairType() : py::dtype::of<PairRow>();
}

/// Writes the matrix of each link's pose. All numbers are NaN if a position is not finite.
void writePoses(const scene::RobotModel& robot, const std::vector<double>& positions, double* out) {
  const bool is_finite = std::all_of(positions.begin(), positions.end(), [](double p) { return std::isfinite(p); });
  if (!is_finite) {
    std::fill_n(out, 16 * robot.links.size(), kNaN);
    return;
  }
  const scene::BodyPoses poses = scene::forwardKinematics(robot, positions);
  for (int link = 0; link < static_cast<int>(robot.links.size()); ++link, out += 16)
    Eigen::Map<RowMajor4d>{out} = scene::poseOfLink(robot, link, poses).matrix();
}

/// The closest pairs of one state, sorted.
struct AnsweredPairs {
  const scene::PairProximity* first;
  Eigen::Index count;
};

AnsweredPairs pairsOf(const scene::StatePairs& lists, Eigen::Index state) {
  const auto i = static_cast<std::size_t>(state);
  return {lists.pairs.data() + lists.begins[i], static_cast<Eigen::Index>(lists.begins[i + 1] - lists.begins[i])};
}

AnsweredPairs pairsOf(const std::vector<scene::PairProximity>& minima, Eigen::Index state) {
  const scene::PairProximity& minimum = minima[state];
  return {&minimum, minimum.result.status == narrowphase::Status::Unknown ? 0 : 1};
}

// These function objects ask the questions that return a fixed number of pairs for each state.
using Block = JointPositions::Block;
struct Closest {
  int k;
  const auto& operator()(scene::SceneBatch& batch, const Block& states, const scene::Deadline& deadline) const {
    return batch.closest(states, k, deadline);
  }
};
struct Minimum {
  const auto& operator()(scene::SceneBatch& batch, const Block& states, const scene::Deadline& deadline) const {
    return batch.minimum(states, deadline);
  }
};
struct MinimumWithin {
  double accuracy;
  const auto& operator()(scene::SceneBatch& batch, const Block& states, const scene::Deadline& deadline) const {
    return batch.minimumWithin(states, accuracy, deadline);
  }
};
struct Deciding {
  const scene::LevelThresholds& thresholds;
  const auto& operator()(scene::SceneBatch& batch, const Block& states, const scene::Deadline& deadline) const {
    return batch.deciding(states, thresholds, deadline);
  }
};

/// The i-th pair of a state. If there are fewer pairs, an Unknown one is returned.
scene::PairProximity pairOf(const AnsweredPairs& pairs, Eigen::Index i) {
  return i < pairs.count ? pairs.first[i] : scene::PairProximity{};
}

/// The rows of all pairs of a block; a state without an answer has one row, which is Unknown.
std::vector<LevelRow> listedRows(const scene::StatePairs& lists, Eigen::Index first, const PairNumbers& numbers,
                                 const scene::LevelThresholds* thresholds) {
  std::vector<LevelRow> rows;
  rows.reserve(lists.pairs.size());
  for (Eigen::Index state = 0; state < static_cast<Eigen::Index>(lists.unknown.size()); ++state) {
    const bool is_unknown = lists.unknown[state] != 0;
    const AnsweredPairs pairs = pairsOf(lists, state);
    for (Eigen::Index i = 0; i < (is_unknown ? 1 : pairs.count); ++i)
      rows.push_back(rowOf(first + state, pairOf(pairs, i), numbers, thresholds));
  }
  return rows;
}

/// Joins the rows of all blocks in one array. Needs the GIL.
py::array joined(const std::map<Eigen::Index, std::vector<LevelRow>>& blocks, const py::dtype& type) {
  py::ssize_t count = 0;
  for (const auto& [first, rows] : blocks) count += static_cast<py::ssize_t>(rows.size());
  RowTable all(py::array(type, std::vector<py::ssize_t>{count}));
  Eigen::Index next = 0;
  for (const auto& [first, rows] : blocks)
    for (const LevelRow& row : rows) all.write(next++, row);
  return all.array();
}

/// Takes the poses of a state of the block.
const scene::State& place(const JointPositions::Block& block, Eigen::Index index, Scratch& scratch) {
  positionsOf(block, index, scratch.positions);
  scene::State& state = scratch.posed();
  const scene::BodyPoses poses = scene::forwardKinematics(state.robot(), scratch.positions);
  state.set(poses, scene::framePoses(*scratch.objects, poses));
  return state;
}

/// The known ranges of the joints, with these ends in their place if they are not None.
scene::JointBox boxBetween(const py::object& lower, const py::object& upper, const scene::RobotModel& robot) {
  scene::JointBox box = scene::knownRanges(robot);
  const auto setEnds = [&](const py::object& ends, const std::string& name, double scene::JointRange::*end) {
    if (ends.is_none()) return;
    const JointPositions positions(ends, robot, name);
    if (!positions.shape().empty()) throw std::invalid_argument(name + " must have one number for each joint");
    const JointPositions::Block block = positions.block(0, 1);
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      const auto joint = static_cast<int>(i);
      if (robot.joints[i].mimic || !scene::hasOnePosition(robot.joints[i])) continue;
      const auto found = std::find_if(box.begin(), box.end(), [&](const auto& range) { return range.joint == joint; });
      scene::JointRange& range = found == box.end() ? box.emplace_back(scene::JointRange{joint, kNaN, kNaN}) : *found;
      range.*end = block(0, static_cast<Eigen::Index>(i));
    }
  };
  setEnds(lower, "lower", &scene::JointRange::lower);
  setEnds(upper, "upper", &scene::JointRange::upper);
  return box;
}

/// [m] In each state of the block the smallest guaranteed distance is that of a pair that is not farther apart.
double reachOfGuarantees(const std::vector<scene::PairProximity>& closest, const JointPositions::Block& block,
                         Scratch& scratch) {
  constexpr double kSlack = 1e-6;  // [m] more than the tolerance of a distance and all rounding
  double reach = 0.0;
  for (Eigen::Index i = 0; i < block.rows(); ++i) {
    const narrowphase::SignedDistance& result = closest[static_cast<std::size_t>(i)].result;
    if (result.status == narrowphase::Status::Unknown) continue;
    scratch.guaranteed->forget();  // no state depends on the states before it
    const double loss = scratch.guaranteed->largestLoss(place(block, i, scratch));
    reach = std::max(reach, result.upper_bound + loss + kSlack);
  }
  return reach;
}

/// The free motion from a state of the block, of whose pairs all up to the influence distance are given.
scene::FreeMotion& placeFreeMotion(const JointPositions::Block& block, Eigen::Index state, const AnsweredPairs& near,
                                   const scene::FreeMotionQuestion& question, Scratch& scratch) {
  if (!scratch.free_motion) scratch.free_motion.emplace(scratch.loaded->model);
  scratch.free_motion->find(place(block, state, scratch), near.first, near.first + near.count, question);
  return *scratch.free_motion;
}

/// Writes the derivative of a pair's distance with respect to each column of q. It is 0 for floating and planar joints,
/// and for mimic joints, whose part is in the column of the leader.
void writeGradient(const scene::State& state, const scene::PairProximity& pair, Scratch& scratch, double* gradient) {
  const std::vector<scene::Joint>& joints = state.robot().joints;
  const scene::DegreesOfFreedom& degrees = state.degreesOfFreedom();
  scratch.by_degrees.resize(degrees.size());
  const bool is_known = scene::gradient(state, pair, scratch.by_degrees);
  std::fill_n(gradient, joints.size(), is_known ? 0.0 : kNaN);
  for (int i = 0; is_known && i < degrees.size(); ++i) {
    const auto joint = static_cast<std::size_t>(degrees[i].joint);
    if (scene::hasOnePosition(joints[joint])) gradient[joint] = scratch.by_degrees[i];
  }
}

/// Writes the gradients of k pairs in one state. If there are fewer pairs, the other gradients are NaN.
void writeGradients(const JointPositions::Block& block, Eigen::Index state, const AnsweredPairs& pairs, Eigen::Index k,
                    Scratch& scratch, double* gradients) {
  const Eigen::Index known = std::min(k, pairs.count);
  if (known > 0) place(block, state, scratch);
  for (Eigen::Index i = 0; i < known; ++i)
    writeGradient(scratch.posed(), pairs.first[i], scratch, gradients + i * block.cols());
  std::fill(gradients + known * block.cols(), gradients + k * block.cols(), kNaN);
}

}  // namespace

Robot::Robot(RobotText text, LoadOptions options, int threads, const std::atomic<bool>* stop)
    : loaded_(std::make_shared<const LoadedRobot>(std::move(text), std::move(options), stop)), threads_(1) {
  scene::ObjectRules rules;
  rules.base = scene::ObjectRules::Base::StandsStill;  // because all poses are in the frame of the root link
  objects_ = std::make_shared<const scene::Objects>(scene::Objects(loaded_->model).withRules(rules));
  setThreads(threads);
}

Robot::Robot(std::shared_ptr<const LoadedRobot> loaded, std::shared_ptr<const scene::Objects> objects,
             std::vector<scene::WrittenRule> rules, int threads)
    : loaded_(std::move(loaded)), objects_(std::move(objects)), rules_(std::move(rules)), threads_(threads) {}

Robot::~Robot() = default;

const scene::SceneModel& Robot::model() const { return *loaded_->model; }
const RobotText& Robot::text() const { return loaded_->text; }
const LoadOptions& Robot::options() const { return loaded_->options; }
const scene::LevelThresholds* Robot::thresholds() const {
  return loaded_->thresholds ? &*loaded_->thresholds : nullptr;
}

const PairNumbers& Robot::pairs() const {
  std::call_once(pairs_made_,
                 [this] { pairs_ = std::make_unique<PairNumbers>(loaded_->batch.candidates(), *objects_); });
  return *pairs_;
}

const scene::SceneBatch& Robot::freshBatch() const {
  std::call_once(batch_made_, [this] {
    batch_.emplace(loaded_->batch.forAnotherThread());
    if (!objects_->empty()) batch_->use(objects_);
  });
  return *batch_;
}

void Robot::setThreads(int threads) {
  if (threads < 1 || threads > kMaxThreads)
    throw std::invalid_argument("threads is " + std::to_string(threads) + ", but must be from 1 to " +
                                std::to_string(kMaxThreads));
  threads_ = threads;
}

// --- objects

std::unique_ptr<Robot> Robot::with(std::vector<scene::ObjectEdit> objects, const std::vector<scene::WrittenRule>& rules,
                                   const std::atomic<bool>* stop, std::vector<std::string>& warnings) const {
  const scene::ObjectOptions options = objectOptions(loaded_->text, loaded_->options, stop);
  scene::LinkFrames frames(model().robot);
  scene::ObjectEditor editor(*objects_, frames, options);
  for (scene::ObjectEdit& object : objects) {
    const std::string id = object.id, source = object.source;
    object.operation = editor.find(id) ? Operation::Replace : Operation::Add;
    try {
      editor.apply(std::move(object));
    } catch (const std::invalid_argument& error) {  // the message gets the place in the file, if there is one
      throw std::invalid_argument(source + (source.empty() ? "" : ": ") + error.what());
    }
    const std::vector<std::string>& object_warnings = scene::warningsOf(*editor.find(id));
    warnings.insert(warnings.end(), object_warnings.begin(), object_warnings.end());
  }
  std::unique_ptr<Robot> next = withEdits(editor);
  if (rules.empty()) return next;
  next->rules_.insert(next->rules_.end(), rules.begin(), rules.end());
  scene::ObjectRules applied = next->objects().rules();
  for (const scene::WrittenRule& rule : rules) applied.allowed.set(rule.a, rule.b, rule.rule);
  next->objects_ = std::make_shared<const scene::Objects>(next->objects().withRules(std::move(applied)));
  return next;
}

std::unique_ptr<Robot> Robot::edited(scene::ObjectEdit edit, const py::object& q) const {
  const scene::RobotModel& robot = model().robot;
  scene::BodyPoses poses;
  if (!q.is_none()) {
    const JointPositions state(q, robot);
    if (objects_->find(edit.id) < 0) throw std::invalid_argument("there is no object " + scene::quoted(edit.id));
    const std::string& frame = edit.place.link.empty() ? edit.place.frame : edit.place.link;
    if (!frame.empty() && robot.findLink(frame) < 0)
      throw std::invalid_argument("there is no link " + scene::unknownName(frame, scene::namesOf(robot.links)));
    if (!state.shape().empty() || !state.block(0, 1).allFinite())
      throw std::invalid_argument("q has to be one state, and finite, for the place of an object");
    std::vector<double> positions;
    positionsOf(state.block(0, 1), 0, positions);
    poses = scene::forwardKinematics(robot, positions);
    edit.pose = scene::ObjectEdit::Pose::Kept;
  }
  const scene::ObjectOptions options;  // they are not used, because no geometry is made
  scene::LinkFrames frames(robot, poses);
  scene::ObjectEditor editor(*objects_, frames, options);
  editor.require(edit.id);
  editor.apply(std::move(edit));
  return withEdits(editor);
}

std::unique_ptr<Robot> Robot::withEdits(const scene::ObjectEditor& editor) const {
  return std::unique_ptr<Robot>(new Robot(
      loaded_, std::make_shared<const scene::Objects>(objects_->changed(editor.difference())), rules_, threads_));
}

std::unique_ptr<Robot> Robot::allowing(const std::string& a, const std::string& b) const {
  std::vector<std::string> known = scene::namesOf(model().robot.links);
  for (const int number : objects_->numbers()) known.push_back(objects_->object(number)->id);
  for (const std::string& name : {a, b})
    if (name != "*" && std::find(known.begin(), known.end(), name) == known.end())
      throw std::invalid_argument("there is no link or object " + scene::unknownName(name, known));
  std::vector<std::string> warnings;
  return with({}, {{a, b, scene::AllowedPairs::Rule::Allowed}}, nullptr, warnings);
}

// --- questions

std::shared_ptr<Scratch> Robot::borrow() {
  std::unique_ptr<Scratch> scratch;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (free_scratches_.empty()) {
      free_scratches_.reserve(++scratch_count_);  // so that returning a scratch never allocates memory
      scratch = std::make_unique<Scratch>(loaded_, objects_);
    } else {
      scratch = std::move(free_scratches_.back());
      free_scratches_.pop_back();
    }
  }
  return {scratch.release(), [this](Scratch* used) {
            const std::lock_guard<std::mutex> lock(mutex_);
            free_scratches_.emplace_back(used);
          }};
}

template <typename Answer>
void Robot::answerBlocks(Eigen::Index count, Eigen::Index block, SignalWatch& watch, const Answer& answer) {
  const auto thread_count = static_cast<int>(std::min<Eigen::Index>(threads_, (count + block - 1) / block));
  watch.run([&] {
    std::vector<std::shared_ptr<Scratch>> scratch(static_cast<std::size_t>(std::max(1, thread_count)));
    Eigen::Index next = 0;
    const auto read = [&](Eigen::Index& first) {
      first = next;
      next += block;
      return !watch.isInterrupted() && first < count;
    };
    const auto work = [&](Eigen::Index first, int thread) {
      std::shared_ptr<Scratch>& own = scratch[thread];
      if (!own) own = borrow();
      answer(*own, first, std::min(block, count - first));
    };
    system::runPipeline<Eigen::Index>({read, work},
                                      {static_cast<int>(scratch.size()), system::PipelineThreads::TooFew::Enough});
  });
}

scene::SceneBatch& Robot::batchOf(Scratch& scratch) const {
  if (!scratch.batch) scratch.batch.emplace(freshBatch().forAnotherThread());
  return *scratch.batch;
}

template <typename Answer>
void Robot::answerStates(const JointPositions& positions, SignalWatch& watch, const Answer& answer) {
  const auto answerBlock = [&](Scratch& scratch, Eigen::Index first, Eigen::Index count) {
    answer(batchOf(scratch), scratch, positions.block(first, count), first);
  };
  // The distances of one state take about as long as to start a thread.
  if (positions.count() != 1) return answerBlocks(positions.count(), kBlock, watch, answerBlock);
  const py::gil_scoped_release released;
  answerBlock(*borrow(), 0, 1);
}

template <typename Ask>
void Robot::answerRows(const JointPositions& positions, Eigen::Index k, const Ask& ask, TimeBudget time_budget,
                       RowTable& rows, double* gradients) {
  SignalWatch watch(time_budget);
  answerStates(positions, watch,
               [&](scene::SceneBatch& batch, Scratch& scratch, const JointPositions::Block& block, Eigen::Index first) {
                 const auto& answers = ask(batch, block, watch.deadline());
                 for (Eigen::Index i = 0; i < block.rows(); ++i) {
                   const AnsweredPairs of_state = pairsOf(answers, i);
                   const Eigen::Index begin = (first + i) * k;
                   for (Eigen::Index j = 0; j < k; ++j)
                     rows.write(begin + j, rowOf(first + i, pairOf(of_state, j), pairs(), thresholds()));
                   if (gradients) writeGradients(block, i, of_state, k, scratch, gradients + begin * block.cols());
                 }
               });
}

py::object Robot::minimum(const py::object& q, std::optional<double> accuracy, TimeBudget time_budget) {
  if (accuracy && !(*accuracy > 0.0)) throw std::invalid_argument("accuracy must be positive");
  const JointPositions positions(q, model().robot);
  RowTable rows(newArray(rowType(thresholds()), positions, {}));
  if (accuracy)
    answerRows(positions, 1, MinimumWithin{*accuracy}, time_budget, rows, nullptr);
  else
    answerRows(positions, 1, Minimum(), time_budget, rows, nullptr);
  return scalarIfSingle(rows.array());
}

py::object Robot::level(const py::object& q, TimeBudget time_budget) {
  if (!thresholds()) throw std::invalid_argument("the robot was made without thresholds=, and has no levels");
  const JointPositions positions(q, model().robot);
  RowTable rows(newArray(rowType(thresholds()), positions, {}));
  answerRows(positions, 1, Deciding{*thresholds()}, time_budget, rows, nullptr);
  return scalarIfSingle(rows.array());
}

py::object Robot::closest(const py::object& q, long k, TimeBudget time_budget) {
  const JointPositions positions(q, model().robot);
  const Closest ask{checkedCount(k)};
  RowTable rows(newArray(rowType(thresholds()), positions, {k}));
  answerRows(positions, k, ask, time_budget, rows, nullptr);
  return rows.array();
}

py::tuple Robot::gradient(const py::object& q, std::optional<long> k, TimeBudget time_budget) {
  const JointPositions positions(q, model().robot);
  std::vector<py::ssize_t> shape;
  if (k) shape.push_back(checkedCount(*k));
  RowTable rows(newArray(rowType(thresholds()), positions, shape));
  shape.push_back(static_cast<py::ssize_t>(model().robot.joints.size()));
  py::array_t<double> gradients = newArray<double>(positions, shape);
  if (k) {
    answerRows(positions, *k, Closest{checkedCount(*k)}, time_budget, rows, gradients.mutable_data());
  } else {
    answerRows(positions, 1, Minimum(), time_budget, rows, gradients.mutable_data());
  }
  return py::make_tuple(scalarIfSingle(rows.array()), gradients);
}

py::tuple Robot::guaranteed(const py::object& q, const std::string& uncertainty, TimeBudget time_budget) {
  const scene::Uncertainty within = scene::uncertaintyFrom(uncertainty, "uncertainty", model().robot);
  const JointPositions positions(q, model().robot);
  RowTable rows(newArray(rowType(thresholds()), positions, {}));
  py::array_t<double> guaranteed = newArray<double>(positions, {});
  double* const out = guaranteed.mutable_data();
  SignalWatch watch(time_budget);
  const scene::Deadline& deadline = watch.deadline();
  scene::GuaranteeLimits limits;
  limits.deadline = deadline;
  answerBlocks(positions.count(), kBlock, watch, [&](Scratch& scratch, Eigen::Index first, Eigen::Index count) {
    const JointPositions::Block block = positions.block(first, count);
    scene::SceneBatch& batch = batchOf(scratch);
    if (!scratch.guaranteed) scratch.guaranteed.emplace(scratch.loaded->model);
    scratch.guaranteed->assume(within);
    scratch.guaranteed->limit(limits);
    const double reach = reachOfGuarantees(batch.minimum(block, deadline), block, scratch);
    const scene::StatePairs& near = batch.below(block, reach, deadline);
    for (Eigen::Index i = 0; i < block.rows(); ++i) {
      scene::GuaranteedMinimum found;
      const AnsweredPairs listed = pairsOf(near, i);
      const bool is_known = near.unknown[static_cast<std::size_t>(i)] == 0 && !deadline.hasPassed();
      scratch.guaranteed->forget();
      if (is_known)
        found = scratch.guaranteed->find(place(block, i, scratch), {listed.first, listed.first + listed.count, reach});
      rows.write(first + i, rowOf(first + i, found.pair, pairs(), thresholds()));
      out[first + i] = is_known && found.unknown == 0 ? found.guaranteed : kNaN;
    }
  });
  return py::make_tuple(scalarIfSingle(rows.array()), scalarIfSingle(guaranteed));
}

py::object Robot::below(const py::object& q, double distance, TimeBudget time_budget) {
  const JointPositions positions(q, model().robot);
  py::array_t<VerdictRow> rows = newArray<VerdictRow>(positions, {});
  VerdictRow* const out = rows.mutable_data();
  SignalWatch watch(time_budget);
  answerStates(positions, watch,
               [&](scene::SceneBatch& batch, Scratch&, const JointPositions::Block& block, Eigen::Index first) {
                 const std::vector<scene::StateVerdict>& verdicts = batch.anyBelow(block, distance, watch.deadline());
                 std::transform(verdicts.begin(), verdicts.end(), out + first,
                                [](const scene::StateVerdict& verdict) { return rowOf(verdict); });
               });
  return scalarIfSingle(rows);
}

py::object Robot::pairsBelow(const py::object& q, double distance, TimeBudget time_budget) {
  const JointPositions positions(q, model().robot);
  std::mutex mutex;
  std::map<Eigen::Index, std::vector<LevelRow>> found;  // by the first state of the block
  SignalWatch watch(time_budget);
  answerStates(positions, watch,
               [&](scene::SceneBatch& batch, Scratch&, const JointPositions::Block& block, Eigen::Index first) {
                 const scene::StatePairs& below = batch.below(block, distance, watch.deadline());
                 std::vector<LevelRow> rows = listedRows(below, first, pairs(), thresholds());
                 const std::lock_guard<std::mutex> lock(mutex);
                 found.emplace(first, std::move(rows));
               });
  return joined(found, rowType(thresholds()));
}

template <typename Write>
void Robot::answerFreeMotions(const JointPositions& positions, double distance, double influence_distance,
                              TimeBudget time_budget, const Write& write) {
  if (!std::isfinite(distance)) throw std::invalid_argument("the distance must be finite");
  if (!(influence_distance >= 0.0) || std::isinf(influence_distance))
    throw std::invalid_argument("influence_distance must be finite and not negative");
  scene::FreeMotionQuestion question;
  question.thresholds = scene::PairDistances(distance, distance);
  question.influence_distance = distance + influence_distance;
  SignalWatch watch(time_budget);
  answerStates(positions, watch,
               [&](scene::SceneBatch& batch, Scratch& scratch, const JointPositions::Block& block, Eigen::Index first) {
                 const scene::StatePairs& near = batch.below(block, question.influence_distance, watch.deadline());
                 for (Eigen::Index i = 0; i < block.rows(); ++i) {
                   const bool is_unknown =
                       near.unknown[static_cast<std::size_t>(i)] != 0 || watch.deadline().hasPassed();
                   scene::FreeMotion* const free =
                       is_unknown ? nullptr : &placeFreeMotion(block, i, pairsOf(near, i), question, scratch);
                   write(first + i, free, scratch);
                 }
               });
}

py::object Robot::freeMotion(const py::object& q, double distance, double influence_distance, TimeBudget time_budget) {
  const JointPositions positions(q, model().robot);
  const std::vector<scene::Joint>& joints = model().robot.joints;
  const auto columns = static_cast<Eigen::Index>(joints.size());
  py::array_t<double> free_of_joints = newArray<double>(positions, {columns});
  double* const out = free_of_joints.mutable_data();
  answerFreeMotions(positions, distance, influence_distance, time_budget,
                    [&](Eigen::Index state, const scene::FreeMotion* free, Scratch& scratch) {
                      double* const row = out + state * columns;
                      std::fill_n(row, columns, free ? 0.0 : kNaN);
                      if (!free) return;
                      const scene::DegreesOfFreedom& degrees = scratch.posed().degreesOfFreedom();
                      for (int i = 0; i < degrees.size(); ++i)
                        if (scene::hasOnePosition(joints[degrees[i].joint])) row[degrees[i].joint] = free->alone(i);
                    });
  return free_of_joints;
}

py::object Robot::freeScale(const py::object& q, const py::object& motion, double distance, double influence_distance,
                            TimeBudget time_budget) {
  const std::vector<scene::Joint>& joints = model().robot.joints;
  const JointPositions::Edges given = JointPositions::edges(q, motion, model().robot, "q", "motion");
  py::array_t<double> scales = newArray<double>(given.start, {});
  double* const out = scales.mutable_data();
  answerFreeMotions(given.start, distance, influence_distance, time_budget,
                    [&](Eigen::Index state, const scene::FreeMotion* free, Scratch& scratch) {
                      out[state] = kNaN;
                      const JointPositions::Block moved = given.goal.block(state, 1);
                      if (!free || !moved.allFinite()) return;
                      const scene::DegreesOfFreedom& degrees = scratch.posed().degreesOfFreedom();
                      scratch.by_degrees.setZero(degrees.size());
                      for (int i = 0; i < degrees.size(); ++i)
                        if (scene::hasOnePosition(joints[degrees[i].joint]))
                          scratch.by_degrees[i] = moved(0, degrees[i].joint);
                      out[state] = free->scale(scratch.by_degrees);
                    });
  return scalarIfSingle(scales);
}

py::tuple Robot::prove(const py::object& lower, const py::object& upper, double distance, long boxes,
                       TimeBudget time_budget) {
  const scene::JointBox box = boxBetween(lower, upper, model().robot);
  SignalWatch watch(time_budget);
  scene::ProofQuestion question;
  question.contact_distance = distance;
  question.most_boxes = boxes;
  question.deadline = watch.deadline();
  question.objects = objects_;
  question.threads = threads_;
  const std::vector<scene::ShapeRefPair>& asked = pairs().list();
  std::vector<scene::PairProof> proofs;
  watch.run([&] { proofs = scene::proveApart(loaded_->model, asked, box, question); });
  py::array_t<ProofRow> rows(static_cast<py::ssize_t>(proofs.size()));
  const auto joints = static_cast<py::ssize_t>(model().robot.joints.size());
  py::array_t<double> closest({static_cast<py::ssize_t>(proofs.size()), joints});
  std::fill_n(closest.mutable_data(), closest.size(), kNaN);
  for (std::size_t i = 0; i < proofs.size(); ++i) {
    rows.mutable_data()[i] = rowOf(static_cast<std::int32_t>(i), proofs[i]);
    std::copy(proofs[i].closest.begin(), proofs[i].closest.end(),
              closest.mutable_data() + static_cast<py::ssize_t>(i) * joints);
  }
  return py::make_tuple(rows, closest);
}

py::object Robot::linkPoses(const py::object& q) {
  const scene::RobotModel& robot = model().robot;
  const JointPositions positions(q, robot);
  py::array_t<double> poses = newArray<double>(positions, {static_cast<py::ssize_t>(robot.links.size()), 4, 4});
  double* const out = poses.mutable_data();
  SignalWatch watch;
  answerBlocks(positions.count(), kBlock, watch, [&](Scratch& scratch, Eigen::Index first, Eigen::Index count) {
    const JointPositions::Block block = positions.block(first, count);
    for (Eigen::Index state = 0; state < count; ++state) {
      positionsOf(block, state, scratch.positions);
      writePoses(robot, scratch.positions, out + (first + state) * 16 * static_cast<Eigen::Index>(robot.links.size()));
    }
  });
  return poses;
}

template <typename Ask>
py::object Robot::answerEdges(const DrivenEdges& edges, scene::MotionQuestion question, TimeBudget time_budget,
                              const py::dtype& type, const Ask& ask) {
  SignalWatch watch(time_budget);
  question.deadline = watch.deadline();
  RowTable rows(newArray(type, edges.start(), {}));
  constexpr Eigen::Index kEdgesInBlock = 16;  // fewer than states, because an edge takes much longer
  const scene::RobotModel& robot = model().robot;
  const scene::RobotMotion::ObjectFrames frames = scene::framesOnLinks(*objects_);
  const scene::SplineQuestion spline_question{question, edges.trackingError(), frames};
  const Eigen::Index edge_count = edges.start().count();
  answerBlocks(edge_count, kEdgesInBlock, watch, [&](Scratch& scratch, Eigen::Index first, Eigen::Index count) {
    for (Eigen::Index i = first; i < first + count; ++i) {
      const DrivenEdges::Edge edge = edges.at(i);
      // No edge depends on the edges before it.
      scene::MovingScene fresh(scratch.posed());
      if (!edge.is_finite || watch.deadline().hasPassed()) {
        rows.write(i, rowOf(i, decltype(ask(fresh, std::declval<scene::RobotMotion>(), question))(), pairs()));
      } else if (edges.areSplines()) {
        scene::SplineScene splines(scratch.posed());
        rows.write(
            i, rowOf(i, ask(splines, scene::SplineSegment(robot, edge.start, edge.goal), spline_question), pairs()));
      } else {
        auto motion = scene::RobotMotion::between(robot, edge.start.positions, edge.goal.positions);
        motion.carryObjects(frames);
        rows.write(i, rowOf(i, ask(fresh, motion, question), pairs()));
      }
    }
  });
  return scalarIfSingle(rows.array());
}

py::object Robot::firstContact(const py::object& start, const py::object& goal, double distance, double tolerance,
                               const EdgeMotion& motion, TimeBudget time_budget) {
  scene::MotionQuestion question;
  question.contact_distance = requireNumber(distance, "distance");
  question.tolerance = requireNumber(tolerance, "tolerance");
  const DrivenEdges edges(start, goal, motion, model().robot);
  return answerEdges(edges, question, time_budget, py::dtype::of<ContactRow>(),
                     [&](auto& scene, const auto& along, const auto& asked) {
                       return scene.timeOfContact(loaded_->batch.candidates(), along, asked);
                     });
}

py::object Robot::minimumBetween(const py::object& start, const py::object& goal, double tolerance,
                                 const EdgeMotion& motion, TimeBudget time_budget) {
  scene::MotionQuestion question;
  question.tolerance = requireNumber(tolerance, "tolerance");
  const DrivenEdges edges(start, goal, motion, model().robot);
  return answerEdges(edges, question, time_budget, minimumType(),
                     [&](auto& scene, const auto& along, const auto& asked) {
                       return scene.minimum(loaded_->batch.candidates(), along, asked);
                     });
}

}  // namespace proximity_server::python
