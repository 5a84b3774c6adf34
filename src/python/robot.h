#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "proximity_server/scene/batch/scene_batch.h"
#include "python/joint_positions.h"
#include "python/rows.h"

namespace proximity_server::python {

/// What one thread needs for its questions.
struct Scratch;

/// An array of rows about pairs.
class RowTable;

/// The dtype of LevelRow, with the fields of PairRow beside the level.
pybind11::dtype leveledPairType();

/// A robot with its candidate pairs: the class `Robot` of the module.
///
/// Each question releases the GIL while it computes, and may be asked by many Python threads at once: each thread of a
/// question borrows a scratch. Ctrl-C ends a question.
class Robot {
 public:
  /// Without thresholds there are no levels.
  Robot(std::shared_ptr<const scene::SceneModel> model, std::optional<scene::LevelThresholds> thresholds, int threads);
  ~Robot();

  const scene::SceneModel& model() const { return *model_; }
  const scene::Candidates& candidates() const { return prototype_.candidates(); }

  /// How many threads a question has, from 1 to 1024.
  int threads() const { return threads_; }
  /// Throws std::invalid_argument for another number.
  void setThreads(int threads);

  // The questions. What they return and throw is documented where Python reads it, in module.cpp.

  pybind11::object minimum(const pybind11::object& q);
  pybind11::object level(const pybind11::object& q);
  pybind11::object closest(const pybind11::object& q, long k);
  /// The rows and gradients of minimum(), or of closest() if there is a k.
  pybind11::tuple gradient(const pybind11::object& q, std::optional<long> k);
  pybind11::object below(const pybind11::object& q, double distance);
  pybind11::object pairsBelow(const pybind11::object& q, double distance);

 private:
  std::shared_ptr<Scratch> borrow();

  /// Calls `answer(scratch, block, first)` for all blocks of states, without the GIL.
  template <typename Answer>
  void answerBlocks(const JointPositions& positions, const Answer& answer);

  /// Writes k rows for each state, and k gradients unless that is nullptr, about what `ask(batch, block)` returns.
  template <typename Ask>
  void answerRows(const JointPositions& positions, Eigen::Index k, const Ask& ask, RowTable& rows, double* gradients);

  const scene::LevelThresholds* thresholds() const { return thresholds_ ? &*thresholds_ : nullptr; }

  std::shared_ptr<const scene::SceneModel> model_;
  std::optional<scene::LevelThresholds> thresholds_;
  pybind11::dtype row_type_;     ///< PAIR, or with thresholds LEVELED_PAIR
  scene::SceneBatch prototype_;  ///< answers no question: its twins do
  int threads_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Scratch>> free_;  ///< scratches that nobody has borrowed
  std::size_t made_ = 0;                        ///< all scratches
};

}  // namespace proximity_server::python
