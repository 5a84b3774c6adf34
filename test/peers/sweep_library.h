#pragma once

#include <memory>
#include <vector>

#include "peers/fcl_scene.h"
#include "peers/scene_library.h"
#include "peers/sphere_scene.h"
#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::peers {

/// What ./dev bench sweep asks of each state.
enum class SweepQuestion { AnyBelow, Minimum, Closest, Below };
constexpr int kClosest = 5;  ///< pairs of Closest

/// The answer about one state.
struct SweepAnswer {
  bool is_below = false;                 ///< of AnyBelow: something is within kBelow
  std::vector<PairDistance> pairs = {};  ///< of the others, sorted by distance; see numberOf()
};

/// A library that answers a question about many states, forward kinematics included.
class SweepLibrary {
 public:
  virtual ~SweepLibrary() = default;

  /// This is what is timed.
  virtual void ask(const States& states, SweepQuestion question) = 0;

  /// The answers of the last ask().
  virtual std::vector<SweepAnswer> answers() const = 0;
};

/// Ours for batches.
class SweepBatch : public SweepLibrary {
 public:
  explicit SweepBatch(std::shared_ptr<const SceneModel> model) : batch_(std::move(model)) {}
  explicit SweepBatch(SceneBatch batch) : batch_(std::move(batch)) {}

  void ask(const States& states, SweepQuestion question) override;
  std::vector<SweepAnswer> answers() const override;

 private:
  SceneBatch batch_;
  const std::vector<StateVerdict>* verdicts_ = nullptr;  // exactly one of these is the last answer
  const std::vector<PairProximity>* minima_ = nullptr;
  const StatePairs* lists_ = nullptr;
};

/// A library that answers state after state, each in the place that it had for the same state of the last batch.
class SweepStates : public SweepLibrary {
 public:
  void ask(const States& states, SweepQuestion question) override;
  std::vector<SweepAnswer> answers() const override { return {answers_.begin(), answers_.begin() + count_}; }

 protected:
  virtual void answer(const std::vector<double>& positions, SweepQuestion question, SweepAnswer& answer) = 0;

 private:
  std::vector<SweepAnswer> answers_;
  std::ptrdiff_t count_ = 0;
  std::vector<double> positions_;
};

/// Our Scene, which is warm from the state before.
class SweepScene : public SweepStates {
 public:
  explicit SweepScene(std::shared_ptr<const SceneModel> model) : scene_(std::move(model)) {}

 protected:
  void answer(const std::vector<double>& positions, SweepQuestion question, SweepAnswer& answer) override;

 private:
  Scene scene_;
};

class SweepFcl : public SweepStates {
 public:
  SweepFcl(std::shared_ptr<const SceneModel> model, FclScene::Method method)
      : model_(std::move(model)), fcl_(*model_, method) {}

 protected:
  void answer(const std::vector<double>& positions, SweepQuestion question, SweepAnswer& answer) override;

 private:
  std::shared_ptr<const SceneModel> model_;
  FclScene fcl_;
};

class SweepSpheres : public SweepStates {
 public:
  explicit SweepSpheres(const SceneModel& model) : spheres_(model) {}
  int sphereCount() const { return spheres_.sphereCount(); }

 protected:
  void answer(const std::vector<double>& positions, SweepQuestion question, SweepAnswer& answer) override;

 private:
  SphereScene spheres_;
};

}  // namespace proximity_server::peers
