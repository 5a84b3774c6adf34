#include "python/robot.h"

#include <algorithm>
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

namespace {

constexpr int kMaxThreads = 1024;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A new array; of one item for a single state, where `shape` goes on behind the states.
template <typename Item>
py::array_t<Item> newArray(const JointPositions& positions, std::vector<py::ssize_t> shape) {
  if (!positions.isSingleState()) shape.insert(shape.begin(), positions.count());
  py::ssize_t bytes = sizeof(Item);
  for (const py::ssize_t length : shape)
    if (__builtin_mul_overflow(bytes, std::max<py::ssize_t>(1, length), &bytes)) throw std::bad_alloc();
  return py::array_t<Item>(shape);
}

/// An array without dimensions as what it holds: a numpy.void, whose fields are found by their names too.
template <typename Item>
py::object scalarIfSingle(const py::array_t<Item>& array) {
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

/// Writes k rows about one state; those that there are no pairs for are Unknown.
void writeRows(Eigen::Index state, const StatePairs& pairs, Eigen::Index k, const scene::Candidates& candidates,
               PairRow* rows) {
  for (Eigen::Index i = 0; i < k; ++i)
    rows[i] = rowOf(state, i < pairs.count ? pairs.first[i] : scene::PairProximity{}, candidates);
}

/// The rows of all pairs of a block; a state without an answer has one row, which is Unknown.
std::vector<PairRow> listedRows(const scene::StatePairs& lists, Eigen::Index first,
                                const scene::Candidates& candidates) {
  std::vector<PairRow> rows;
  rows.reserve(lists.pairs.size());
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(lists.unknown.size()); ++i) {
    const bool is_unknown = lists.unknown[static_cast<std::size_t>(i)] != 0;
    const StatePairs pairs = pairsOf(lists, i);
    const auto count = static_cast<std::size_t>(is_unknown ? 1 : pairs.count);
    rows.resize(rows.size() + count);
    writeRows(first + i, pairs, static_cast<Eigen::Index>(count), candidates, rows.data() + rows.size() - count);
  }
  return rows;
}

/// With the GIL: the rows of all blocks in one array.
py::array_t<PairRow> joined(const std::map<Eigen::Index, std::vector<PairRow>>& blocks) {
  py::ssize_t count = 0;
  for (const auto& [first, rows] : blocks) count += static_cast<py::ssize_t>(rows.size());
  py::array_t<PairRow> all(count);
  PairRow* out = all.mutable_data();
  for (const auto& [first, rows] : blocks) out = std::copy(rows.begin(), rows.end(), out);
  return all;
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

Robot::Robot(std::shared_ptr<const scene::SceneModel> model, int threads)
    : model_(std::move(model)), prototype_(model_), threads_(1) {
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
void Robot::answerRows(const JointPositions& positions, Eigen::Index k, const Ask& ask, PairRow* rows,
                       double* gradients) {
  answerBlocks(positions, [&](Scratch& scratch, const JointPositions::Block& block, Eigen::Index first) {
    const auto& answers = ask(scratch.batch, block);
    for (Eigen::Index i = 0; i < block.rows(); ++i) {
      const StatePairs pairs = pairsOf(answers, i);
      const Eigen::Index begin = (first + i) * k;
      writeRows(first + i, pairs, k, scratch.batch.candidates(), rows + begin);
      if (gradients) writeGradients(block, i, pairs, k, scratch, gradients + begin * block.cols());
    }
  });
}

py::object Robot::minimum(const py::object& q) {
  const JointPositions positions(q, model_->robot);
  py::array_t<PairRow> rows = newArray<PairRow>(positions, {});
  answerRows(positions, 1, kMinimum, rows.mutable_data(), nullptr);
  return scalarIfSingle(rows);
}

py::object Robot::closest(const py::object& q, long k) {
  const JointPositions positions(q, model_->robot);
  const Closest ask{checkedCount(k)};
  py::array_t<PairRow> rows = newArray<PairRow>(positions, {k});
  answerRows(positions, k, ask, rows.mutable_data(), nullptr);
  return std::move(rows);
}

py::tuple Robot::gradient(const py::object& q, std::optional<long> k) {
  const JointPositions positions(q, model_->robot);
  std::vector<py::ssize_t> shape;
  if (k) shape.push_back(checkedCount(*k));
  py::array_t<PairRow> rows = newArray<PairRow>(positions, shape);
  shape.push_back(static_cast<py::ssize_t>(model_->robot.joints.size()));
  py::array_t<double> gradients = newArray<double>(positions, shape);
  if (k) {
    answerRows(positions, *k, Closest{checkedCount(*k)}, rows.mutable_data(), gradients.mutable_data());
  } else {
    answerRows(positions, 1, kMinimum, rows.mutable_data(), gradients.mutable_data());
  }
  return py::make_tuple(scalarIfSingle(rows), gradients);
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
  std::map<Eigen::Index, std::vector<PairRow>> found;  // by the first state of the block
  answerBlocks(positions, [&](Scratch& scratch, const JointPositions::Block& block, Eigen::Index first) {
    std::vector<PairRow> rows = listedRows(scratch.batch.below(block, distance), first, scratch.batch.candidates());
    const std::lock_guard<std::mutex> lock(mutex);
    found.emplace(first, std::move(rows));
  });
  return joined(found);
}

}  // namespace proximity_server::python
