#include "python/robot.h"

#include <algorithm>
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

#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/model/kinematics.h"
#include "python/parallel_blocks.h"
#include "python/signal_watch.h"

namespace proximity_server::python {

namespace py = pybind11;

struct Scratch {
  Scratch(std::shared_ptr<const scene::SceneModel> shared, scene::SceneBatch questions)
      : model(std::move(shared)), batch(std::move(questions)) {}

  std::shared_ptr<const scene::SceneModel> model;
  scene::SceneBatch batch;
  std::optional<scene::Derivatives> derivatives;  ///< made for the first gradient
  std::vector<double> positions;                  ///< of one state
  Eigen::VectorXd by_degrees;                     ///< a gradient by the degrees of freedom
};

/// Its rows have the fields of PairRow, or all of LevelRow, in the order of the dtype.
class RowTable {
 public:
  explicit RowTable(py::array array)
      : array_(std::move(array)), data_(static_cast<char*>(array_.mutable_data())), row_size_(array_.itemsize()) {}

  const py::array& array() const { return array_; }

  /// The pair is the beginning of the row. Without the GIL.
  void write(Eigen::Index index, const LevelRow& row) {
    std::memcpy(data_ + index * row_size_, &row, static_cast<std::size_t>(row_size_));
  }

 private:
  py::array array_;
  char* data_;
  py::ssize_t row_size_;
};

py::dtype leveledPairType() {
  const py::dtype pair = py::dtype::of<PairRow>();
  const py::dict fields = pair.attr("fields");
  py::list names, formats, offsets;
  for (const py::handle& name : pair.attr("names")) {
    names.append(name);
    formats.append(fields[name][py::int_(0)]);
    offsets.append(fields[name][py::int_(1)]);
  }
  names.append("level");
  formats.append(py::dtype::of<std::int64_t>());
  offsets.append(offsetof(LevelRow, level));
  return {names, formats, offsets, sizeof(LevelRow)};
}

namespace {

constexpr int kMaxThreads = 1024;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A new array; of one item for a single state, where `shape` goes on behind the states.
py::array newArray(const py::dtype& type, const JointPositions& positions, std::vector<py::ssize_t> shape) {
  if (!positions.isSingleState()) shape.insert(shape.begin(), positions.count());
  py::ssize_t bytes = type.itemsize();
  for (const py::ssize_t length : shape)
    if (__builtin_mul_overflow(bytes, std::max<py::ssize_t>(1, length), &bytes)) throw std::bad_alloc();
  return {type, shape};
}

template <typename Item>
py::array_t<Item> newArray(const JointPositions& positions, const std::vector<py::ssize_t>& shape) {
  return newArray(py::dtype::of<Item>(), positions, shape);
}

/// An array without dimensions as what it holds: a numpy.void, whose fields are found by their names too.
py::object scalarIfSingle(const py::array& array) {
  return array.ndim() == 0 ? py::object(array[py::tuple()]) : py::object(array);
}

int checkedCount(long k) {
  if (k < 1 || k > std::numeric_limits<int>::max())
    throw std::invalid_argument("k is " + std::to_string(k) + ", but must be from 1 to " +
                                std::to_string(std::numeric_limits<int>::max()));
  return static_cast<int>(k);
}

/// The closest pairs of one state, sorted.
struct StatePairs {
  const scene::PairProximity* first;
  Eigen::Index count;
};

StatePairs pairsOf(const scene::StatePairs& lists, Eigen::Index state) {
  const auto i = static_cast<std::size_t>(state);
  return {lists.pairs.data() + lists.begins[i], static_cast<Eigen::Index>(lists.begins[i + 1] - lists.begins[i])};
}

StatePairs pairsOf(const std::vector<scene::PairProximity>& minima, Eigen::Index state) {
  const scene::PairProximity& minimum = minima[static_cast<std::size_t>(state)];
  return {&minimum, minimum.result.status == narrowphase::Status::Unknown ? 0 : 1};
}

// The questions that have the same number of pairs for each state.
struct Closest {
  int k;
  const scene::StatePairs& operator()(scene::SceneBatch& batch, const JointPositions::Block& states) const {
    return batch.closest(states, k);
  }
};
constexpr auto kMinimum = [](scene::SceneBatch & batch, const JointPositions::Block& states) -> const auto& {
  return batch.minimum(states);
};
struct Deciding {
  const scene::LevelThresholds& thresholds;
  const auto& operator()(scene::SceneBatch& batch, const JointPositions::Block& states) const {
    return batch.deciding(states, thresholds);
  }
};

/// The i-th pair of a state; one that there is none for is Unknown.
scene::PairProximity pairOf(const StatePairs& pairs, Eigen::Index i) {
  return i < pairs.count ? pairs.first[i] : scene::PairProximity{};
}

/// The rows of all pairs of a block; a state without an answer has one row, which is Unknown.
std::vector<LevelRow> listedRows(const scene::StatePairs& lists, Eigen::Index first,
                                 const scene::Candidates& candidates, const scene::LevelThresholds* thresholds) {
  std::vector<LevelRow> rows;
  rows.reserve(lists.pairs.size());
  for (Eigen::Index state = 0; state < static_cast<Eigen::Index>(lists.unknown.size()); ++state) {
    const bool is_unknown = lists.unknown[static_cast<std::size_t>(state)] != 0;
    const StatePairs pairs = pairsOf(lists, state);
    for (Eigen::Index i = 0; i < (is_unknown ? 1 : pairs.count); ++i)
      rows.push_back(rowOf(first + state, pairOf(pairs, i), candidates, thresholds));
  }
  return rows;
}

/// With the GIL: the rows of all blocks in one array.
py::array joined(const std::map<Eigen::Index, std::vector<LevelRow>>& blocks, const py::dtype& type) {
  py::ssize_t count = 0;
  for (const auto& [first, rows] : blocks) count += static_cast<py::ssize_t>(rows.size());
  RowTable all(py::array(type, std::vector<py::ssize_t>{count}));
  Eigen::Index next = 0;
  for (const auto& [first, rows] : blocks)
    for (const LevelRow& row : rows) all.write(next++, row);
  return all.array();
}

/// Whether kinematics looks at the column of the joint.
bool countsPosition(const scene::Joint& joint) {
  return joint.type != scene::Joint::Type::Floating && joint.type != scene::Joint::Type::Planar;
}

/// Places the robot of the derivatives in a state of the block.
void place(const JointPositions::Block& block, Eigen::Index state, Scratch& scratch) {
  if (!scratch.derivatives) scratch.derivatives.emplace(scratch.model);
  scratch.positions.resize(static_cast<std::size_t>(block.cols()));
  for (Eigen::Index j = 0; j < block.cols(); ++j) scratch.positions[static_cast<std::size_t>(j)] = block(state, j);
  scratch.derivatives->update(scene::forwardKinematics(scratch.model->robot, scratch.positions));
}

/// Writes the derivative of a pair's distance by each column of q. A column that moves nothing has 0: that of a mimic joint,
/// whose part is in the column of its leader, and that of a floating or planar joint.
void writeGradient(const scene::PairProximity& pair, Scratch& scratch, double* gradient) {
  const std::vector<scene::Joint>& joints = scratch.model->robot.joints;
  const scene::DegreesOfFreedom& degrees = scratch.derivatives->degreesOfFreedom();
  scratch.by_degrees.resize(degrees.size());
  const bool is_known = scratch.derivatives->gradient(pair, scratch.by_degrees);
  std::fill_n(gradient, joints.size(), is_known ? 0.0 : kNaN);
  for (int i = 0; is_known && i < degrees.size(); ++i) {
    const auto joint = static_cast<std::size_t>(degrees[i].joint);
    if (countsPosition(joints[joint])) gradient[joint] = scratch.by_degrees[i];
  }
}

/// Writes k gradients about one state; those that there are no pairs for are NaN.
void writeGradients(const JointPositions::Block& block, Eigen::Index state, const StatePairs& pairs, Eigen::Index k,
                    Scratch& scratch, double* gradients) {
  const Eigen::Index known = std::min(k, pairs.count);
  if (known > 0) place(block, state, scratch);
  for (Eigen::Index i = 0; i < known; ++i) writeGradient(pairs.first[i], scratch, gradients + i * block.cols());
  std::fill(gradients + known * block.cols(), gradients + k * block.cols(), kNaN);
}

}  // namespace

Robot::Robot(std::shared_ptr<const scene::SceneModel> model, std::optional<scene::LevelThresholds> thresholds,
             int threads)
    : model_(std::move(model)),
      thresholds_(std::move(thresholds)),
      row_type_(thresholds_ ? leveledPairType() : py::dtype::of<PairRow>()),
      prototype_(model_),
      threads_(1) {
  setThreads(threads);
}

Robot::~Robot() = default;

void Robot::setThreads(int threads) {
  if (threads < 1 || threads > kMaxThreads)
    throw std::invalid_argument("threads is " + std::to_string(threads) + ", but must be from 1 to " +
                                std::to_string(kMaxThreads));
  threads_ = threads;
}

std::shared_ptr<Scratch> Robot::borrow() {
  std::unique_ptr<Scratch> scratch;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (free_.empty()) {
      free_.reserve(++made_);  // so that what is given back always has room
      scratch = std::make_unique<Scratch>(model_, prototype_.twin());
    } else {
      scratch = std::move(free_.back());
      free_.pop_back();
    }
  }
  return {scratch.release(), [this](Scratch* used) {
            const std::lock_guard<std::mutex> lock(mutex_);
            free_.emplace_back(used);
          }};
}

template <typename Answer>
void Robot::answerBlocks(const JointPositions& positions, const Answer& answer) {
  SignalWatch signals;
  const int threads = threads_;
  {
    const py::gil_scoped_release released;
    const auto start = [&]() -> BlockWork {
      return [&, scratch = borrow()](Eigen::Index first, Eigen::Index count) {
        answer(*scratch, positions.block(first, count), first);
      };
    };
    workInBlocks(positions.count(), threads, start, [&] { return signals.goesOn(); });
  }
  signals.rethrow();
}

template <typename Ask>
void Robot::answerRows(const JointPositions& positions, Eigen::Index k, const Ask& ask, RowTable& rows,
                       double* gradients) {
  answerBlocks(positions, [&](Scratch& scratch, const JointPositions::Block& block, Eigen::Index first) {
    const auto& answers = ask(scratch.batch, block);
    for (Eigen::Index i = 0; i < block.rows(); ++i) {
      const StatePairs pairs = pairsOf(answers, i);
      const Eigen::Index begin = (first + i) * k;
      for (Eigen::Index j = 0; j < k; ++j)
        rows.write(begin + j, rowOf(first + i, pairOf(pairs, j), scratch.batch.candidates(), thresholds()));
      if (gradients) writeGradients(block, i, pairs, k, scratch, gradients + begin * block.cols());
    }
  });
}

py::object Robot::minimum(const py::object& q) {
  const JointPositions positions(q, model_->robot);
  RowTable rows(newArray(row_type_, positions, {}));
  answerRows(positions, 1, kMinimum, rows, nullptr);
  return scalarIfSingle(rows.array());
}

py::object Robot::level(const py::object& q) {
  if (!thresholds_) throw std::invalid_argument("the robot was made without thresholds=, and has no levels");
  const JointPositions positions(q, model_->robot);
  RowTable rows(newArray(row_type_, positions, {}));
  answerRows(positions, 1, Deciding{*thresholds_}, rows, nullptr);
  return scalarIfSingle(rows.array());
}

py::object Robot::closest(const py::object& q, long k) {
  const JointPositions positions(q, model_->robot);
  const Closest ask{checkedCount(k)};
  RowTable rows(newArray(row_type_, positions, {k}));
  answerRows(positions, k, ask, rows, nullptr);
  return rows.array();
}

py::tuple Robot::gradient(const py::object& q, std::optional<long> k) {
  const JointPositions positions(q, model_->robot);
  std::vector<py::ssize_t> shape;
  if (k) shape.push_back(checkedCount(*k));
  RowTable rows(newArray(row_type_, positions, shape));
  shape.push_back(static_cast<py::ssize_t>(model_->robot.joints.size()));
  py::array_t<double> gradients = newArray<double>(positions, shape);
  if (k) {
    answerRows(positions, *k, Closest{checkedCount(*k)}, rows, gradients.mutable_data());
  } else {
    answerRows(positions, 1, kMinimum, rows, gradients.mutable_data());
  }
  return py::make_tuple(scalarIfSingle(rows.array()), gradients);
}

py::object Robot::below(const py::object& q, double distance) {
  const JointPositions positions(q, model_->robot);
  py::array_t<VerdictRow> rows = newArray<VerdictRow>(positions, {});
  VerdictRow* const out = rows.mutable_data();
  answerBlocks(positions, [&](Scratch& scratch, const JointPositions::Block& block, Eigen::Index first) {
    const std::vector<scene::StateVerdict>& verdicts = scratch.batch.anyBelow(block, distance);
    std::transform(verdicts.begin(), verdicts.end(), out + first,
                   [](const scene::StateVerdict& verdict) { return rowOf(verdict); });
  });
  return scalarIfSingle(rows);
}

py::object Robot::pairsBelow(const py::object& q, double distance) {
  const JointPositions positions(q, model_->robot);
  std::mutex mutex;
  std::map<Eigen::Index, std::vector<LevelRow>> found;  // by the first state of the block
  answerBlocks(positions, [&](Scratch& scratch, const JointPositions::Block& block, Eigen::Index first) {
    std::vector<LevelRow> rows =
        listedRows(scratch.batch.below(block, distance), first, scratch.batch.candidates(), thresholds());
    const std::lock_guard<std::mutex> lock(mutex);
    found.emplace(first, std::move(rows));
  });
  return joined(found, row_type_);
}

}  // namespace proximity_server::python
