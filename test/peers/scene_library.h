#pragma once

#include "proximity_server/scene/model/kinematics.h"
#include "scene/posed_scene.h"

#include <string>
#include <utility>
#include <vector>

namespace proximity_server::peers {

using namespace scene;

/// The questions of the benchmarks about the candidate pairs of a robot in each state.
enum class SceneQuestion {
  AnyBelow,  ///< whether a pair is within kBelow
  Contact,   ///< whether a pair overlaps, and which one; the search ends at the first
  Minimum,   ///< the smallest distance
  Closest,   ///< the kClosest closest pairs
  Below,     ///< all pairs within kBelow
  All        ///< every pair
};
constexpr double kBelow = 0.05;  ///< [m]
constexpr int kClosest = 5;
std::string nameOf(SceneQuestion question);

/// The distance of one candidate pair.
struct PairDistance {
  int pair;         ///< see numberOf()
  double distance;  ///< [m]; in overlap zero or negative, and only ours is the depth, except in answers of Contact
};

inline bool isNearer(const PairDistance& a, const PairDistance& b) { return a.distance < b.distance; }

/// The answer about one state.
struct SceneAnswer {
  bool is_below = false;  ///< of AnyBelow
  /// The pairs of the other questions, sorted by distance except for All: at most one of Contact, one of Minimum, all of
  /// All that could be answered.
  std::vector<PairDistance> pairs = {};
};

/// Returns the number of a pair: of two links its index in Scene::candidates(), of a link and a fixed object the number
/// of candidates plus link times Objects::numberLimit() plus the number of the object.
int numberOf(const ShapeRefPair& pair, const Candidates& candidates, const Objects* objects);

/// Returns the links of each candidate pair, by its number.
std::vector<std::pair<int, int>> linksOfCandidates(const PairTable& table);

/// A library that answers questions about a robot, state by state. It keeps from one state to the next what helps it.
class SceneLibrary {
 public:
  virtual ~SceneLibrary() = default;

  /// Takes the poses and answers: this is what is timed.
  virtual void ask(const BodyPoses& poses, SceneQuestion question) = 0;

  /// Replaces `answer` by the last one.
  virtual void giveAnswer(SceneAnswer& answer) const = 0;

  std::vector<PairDistance> pairs() const {
    SceneAnswer answer;
    giveAnswer(answer);
    return answer.pairs;
  }

  /// Returns how the pairs of the last question were settled, if the library tells.
  virtual PairCounts counts() const { return {}; }

  /// Returns the number of queries of two parts that ended with an exception or an abort so far.
  virtual int failures() const { return 0; }
};

/// Our Scene. The depth of an overlap is part of its answers.
class OurScene : public SceneLibrary {
 public:
  /// `objects` are fixed; nullptr: none.
  OurScene(std::shared_ptr<const SceneModel> model, Skipping skipping,
           std::shared_ptr<const Objects> objects = nullptr);

  void ask(const BodyPoses& poses, SceneQuestion question) override;
  void giveAnswer(SceneAnswer& answer) const override;
  PairCounts counts() const override { return scene_.counts(); }

 private:
  void take(const PairProximity* found);
  void take(const std::vector<PairProximity>& found);

  PosedScene scene_;
  SceneQuestion question_ = SceneQuestion::All;
  const PairProximity* first_ = nullptr;  // of the last answer
  std::size_t size_ = 0;
};

}  // namespace proximity_server::peers
