#pragma once

#include "peers/scene_library.h"
#include "peers/sphere_scene.h"
#include "proximity_server/scene/batch/scene_batch.h"

#include <memory>
#include <vector>

namespace proximity_server::peers {

/// A library that answers a question about many states, forward kinematics included.
class SweepLibrary {
 public:
  virtual ~SweepLibrary() = default;

  /// This is what is timed.
  virtual void ask(const States& states, SceneQuestion question) = 0;

  /// Returns the answers of the last ask().
  virtual std::vector<SceneAnswer> answers() const = 0;
};

/// Ours for batches. It has no answer to All.
class SweepBatch : public SweepLibrary {
 public:
  /// With an accuracy [m], the minimum is minimumWithin().
  explicit SweepBatch(std::shared_ptr<const SceneModel> model, double accuracy = 0.0)
      : batch_(std::move(model)), accuracy_(accuracy) {}
  explicit SweepBatch(SceneBatch batch) : batch_(std::move(batch)) {}

  void ask(const States& states, SceneQuestion question) override;
  std::vector<SceneAnswer> answers() const override;

 private:
  SceneBatch batch_;
  double accuracy_ = 0.0;
  const std::vector<StateVerdict>* verdicts_ = nullptr;  // exactly one of these is the last answer
  const std::vector<PairProximity>* minima_ = nullptr;
  const StatePairs* lists_ = nullptr;
};

/// A library that answers state after state, each in the place that it had for the same state of the last batch.
class SweepStates : public SweepLibrary {
 public:
  void ask(const States& states, SceneQuestion question) override;
  std::vector<SceneAnswer> answers() const override { return {answers_.begin(), answers_.begin() + count_}; }

 protected:
  virtual void answer(const std::vector<double>& positions, SceneQuestion question, SceneAnswer& answer) = 0;

 private:
  std::vector<SceneAnswer> answers_;
  std::ptrdiff_t count_ = 0;
  std::vector<double> positions_;
};

/// A library of scenes, which may be warm from the state before.
class SweepScene : public SweepStates {
 public:
  SweepScene(std::shared_ptr<const SceneModel> model, std::unique_ptr<SceneLibrary> library)
      : model_(std::move(model)), library_(std::move(library)) {}

 protected:
  void answer(const std::vector<double>& positions, SceneQuestion question, SceneAnswer& answer) override;

 private:
  std::shared_ptr<const SceneModel> model_;
  std::unique_ptr<SceneLibrary> library_;
};

/// Spheres have their own forward kinematics. They have no answer to All.
class SweepSpheres : public SweepStates {
 public:
  explicit SweepSpheres(const SceneModel& model) : spheres_(model) {}

 protected:
  void answer(const std::vector<double>& positions, SceneQuestion question, SceneAnswer& answer) override;

 private:
  SphereScene spheres_;
};

}  // namespace proximity_server::peers
