#pragma once

#include <limits>
#include <vector>

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::peers {

using namespace scene;

/// What the benchmark asks of the candidate pairs of a robot in each state.
enum class SceneQuestion {
  Minimum,  ///< the smallest distance
  Below,    ///< all pairs within kBelow
  All       ///< every pair
};
constexpr double kBelow = 0.05;  ///< [m]

/// A question for what is within a distance [m].
Question within(double distance);

/// The distance of one candidate pair.
struct PairDistance {
  int pair;         ///< see numberOf()
  double distance;  ///< [m]; in overlap zero or negative, and only ours is the depth
};

/// The number of a pair: of two links its index in Scene::candidates(), of a link and a fixed object the number of
/// candidates plus link times Objects::numberLimit() plus the number of the object.
int numberOf(const ShapeRefPair& pair, const Candidates& candidates, const Objects* objects);

/// A library that answers questions about a robot, state by state. It keeps from one state to the next what helps it.
class SceneLibrary {
 public:
  virtual ~SceneLibrary() = default;

  /// Takes the poses and answers: this is what is timed.
  virtual void ask(const BodyPoses& poses, SceneQuestion question) = 0;

  /// The last answer: of Minimum one pair, of Below those within, of All every pair that could be answered.
  virtual std::vector<PairDistance> answer() const = 0;

  /// How the pairs of the last question were settled, where the library tells.
  virtual PairCounts counts() const { return {}; }

  /// Queries of two parts that ended with an exception or an abort, so far.
  virtual int failures() const { return 0; }
};

/// Our Scene. The depth of an overlap is part of its answers.
class OurScene : public SceneLibrary {
 public:
  /// With objects that are fixed, if there are any.
  OurScene(std::shared_ptr<const SceneModel> model, Skipping skipping,
           std::shared_ptr<const Objects> objects = nullptr);

  void ask(const BodyPoses& poses, SceneQuestion question) override;
  std::vector<PairDistance> answer() const override;
  PairCounts counts() const override { return scene_.counts(); }

 private:
  Scene scene_;
  const PairProximity* first_ = nullptr;  // of the last answer
  std::size_t size_ = 0;
};

}  // namespace proximity_server::peers
