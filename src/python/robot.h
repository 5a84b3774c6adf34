#pragma once

#include <pybind11/numpy.h>

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proximity_server/scene/motion/moving_scene.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "python/joint_positions.h"
#include "python/loading.h"
#include "python/pair_numbers.h"
#include "python/rows.h"

namespace proximity_server::python {

/// What one thread needs for its questions.
struct Scratch;

/// The part that robots share whose objects differ: the model, and the scenes from which twins are made.
struct LoadedRobot;

/// An array of rows about pairs.
class RowTable;

/// The dtype of LevelRow, with the fields of PairRow beside the level; and that of MinimumRow.
pybind11::dtype leveledPairType();
pybind11::dtype minimumType();

/// A robot with its objects and candidate pairs: the class `Robot` of the module. All but its number of threads never changes: a change of the
/// objects makes another robot, which shares all that is the same.
///
/// Each question releases the GIL while it computes, and may be asked by many Python threads at once: each thread of a
/// question borrows a scratch. Ctrl-C ends a question.
class Robot {
 public:
  /// Without objects.
  /// Failure: throws as load() and thresholdsOf() do, and as setThreads() does.
  Robot(RobotText text, LoadOptions options, int threads);
  ~Robot();

  const scene::SceneModel& model() const;
  const RobotText& text() const;
  const LoadOptions& options() const;
  const PairNumbers& pairs() const;

  /// How many threads a question has, from 1 to 1024.
  int threads() const { return threads_; }
  /// Throws std::invalid_argument for another number.
  void setThreads(int threads);

  // --- objects, see object_file.h. What is wrong is an std::invalid_argument that names the object.

  const scene::Objects& objects() const { return *objects_; }
  const std::vector<scene::WrittenRule>& rules() const { return rules_; }

  /// Objects that have the name of one that is there replace it; the rules come behind those that are there. Adds what is odd about
  /// the objects to `warnings`.
  std::unique_ptr<Robot> with(std::vector<scene::ObjectEdit> objects, const std::vector<scene::WrittenRule>& rules,
                              std::vector<std::string>& warnings) const;

  /// Another operation on one object, which stays where it is in the state q if that is not None.
  std::unique_ptr<Robot> edited(scene::ObjectEdit edit, const pybind11::object& q) const;

  std::unique_ptr<Robot> allowing(const std::string& a, const std::string& b) const;

  // --- The questions. What they return and throw is documented where Python reads it, in module.cpp.

  pybind11::object minimum(const pybind11::object& q);
  pybind11::object level(const pybind11::object& q);
  pybind11::object closest(const pybind11::object& q, long k);
  /// The rows and gradients of minimum(), or of closest() if there is a k.
  pybind11::tuple gradient(const pybind11::object& q, std::optional<long> k);
  pybind11::object below(const pybind11::object& q, double distance);
  pybind11::object pairsBelow(const pybind11::object& q, double distance);
  pybind11::object linkPoses(const pybind11::object& q);
  pybind11::object firstContact(const pybind11::object& start, const pybind11::object& goal, double distance,
                                double tolerance);
  pybind11::object minimumBetween(const pybind11::object& start, const pybind11::object& goal, double tolerance);

 private:
  Robot(std::shared_ptr<const LoadedRobot> loaded, std::shared_ptr<const scene::Objects> objects,
        std::vector<scene::WrittenRule> rules, int threads);
  std::unique_ptr<Robot> after(const scene::ObjectEditor& editor) const;

  std::shared_ptr<Scratch> borrow();

  /// Calls `answer(scratch, first, count)` for all blocks of so many items, without the GIL.
  template <typename Answer>
  void answerBlocks(Eigen::Index count, Eigen::Index block, const Answer& answer);

  /// Calls `answer(batch, scratch, block, first)` for all blocks of states; `batch` is a SceneBatch, or ObjectStates if there are objects.
  template <typename Answer>
  void answerStates(const JointPositions& positions, const Answer& answer);

  /// Writes k rows for each state, and k gradients unless that is nullptr, about what `ask(batch, block)` returns.
  template <typename Ask>
  void answerRows(const JointPositions& positions, Eigen::Index k, const Ask& ask, RowTable& rows, double* gradients);

  /// The row of each edge about what `ask(scene, pairs, motion)` returns.
  template <typename Ask>
  pybind11::object answerEdges(const pybind11::object& start, const pybind11::object& goal, const pybind11::dtype& type,
                               const Ask& ask);

  const scene::LevelThresholds* thresholds() const;

  std::shared_ptr<const LoadedRobot> loaded_;
  std::shared_ptr<const scene::Objects> objects_;
  std::vector<scene::WrittenRule> rules_;
  int threads_;
  mutable std::once_flag numbered_;
  mutable std::unique_ptr<PairNumbers> pairs_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Scratch>> free_;  ///< scratches that nobody has borrowed
  std::size_t made_ = 0;                        ///< all scratches
};

}  // namespace proximity_server::python
