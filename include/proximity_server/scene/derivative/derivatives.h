#pragma once

#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/state/state.h"

#include <Eigen/Core>

#include <memory>
#include <vector>

namespace proximity_server::scene {

class ContactFeatures;

/// The derivative of a pair's signed distance by each degree of freedom. `pair` is the answer of a Scene about this
/// state.
///
/// Units:   [m/rad] and [m/m], one entry for each of State::degreesOfFreedom(); 0 for joints that are not between the
///          two.
/// Sign:    positive if the distance grows, or if the depth of an overlap shrinks.
/// Formula: n . (v_b - v_a), where v is the velocity of each body at its own witness point. The distance is the
///          smallest one of two points, so it does not matter how these two move on the surfaces (Danskin, The Theory
///          of Max-Min, with Applications, 1966).
/// Error:   the error of the normal and the points, and the rounding of the poses. The normal of two convex pieces that
///          are apart is off by no more than acos(lower_bound / upper_bound) [rad]; test/README.md has results for
///          random states. If PairProximity::result.unique is false, the distance has a kink, and this is the
///          derivative for one choice of points; Derivatives::rate() computes the derivative along a direction. If two
///          pairs of pieces are equally close, the distance has a kink, too, but this is not detected.
/// Failure: returns false, with NaN, if the pair is Unknown or has no points, or if a pose between the two is
///          missing.
///          Throws std::invalid_argument for a wrong size of `gradient`, and for an object that does not exist.
bool gradient(const State& state, const PairProximity& pair, Eigen::Ref<Eigen::VectorXd> gradient);

/// Writes the same gradient into a vector of any size. It is empty on failure, and if a number is not finite.
void gradient(const State& state, const PairProximity& pair, std::vector<double>& gradient);

/// The rates of change of the distances of one robot, and the working memory of one caller. Not thread-safe. After the
/// first question about a set of objects nothing is allocated.
class Derivatives {
 public:
  /// Throws std::invalid_argument without a model.
  explicit Derivatives(std::shared_ptr<const SceneModel> model);
  ~Derivatives();
  Derivatives(Derivatives&&) noexcept;
  Derivatives& operator=(Derivatives&&) noexcept;

  /// The rate of change of a pair's signed distance at a velocity, towards the future: if the distance has a kink, this
  /// is its one-sided derivative.
  ///
  /// Units:   [m/s] for a velocity in [rad/s] and [m/s], one entry for each of State::degreesOfFreedom().
  /// Sign:    as for gradient().
  /// Formula: gradient() . velocity if the result is unique. Otherwise the smallest value of n . (v_b - v_a) over all
  ///          pairs of witness points of the contact feature, for example of two parallel faces (Danskin, as above; in
  ///          overlap the depth is the height of a face of the CSO, whose concave envelope moves like the highest of
  ///          these pairs).
  /// Error:   as gradient(). In two cases the result is on the safe side, never too large. First, if faces or
  ///          edges are parallel within the tolerance: points count that are as far as the accepted width of the
  ///          bounds. Second, if the normal is one of several (concentric shapes, equally short ways out of an
  ///          overlap): the distance is the largest one of these ways. If the result is not unique, pieces of the two
  ///          that meet in the same plane are part of the feature. Other pieces that are equally close, such as two
  ///          balls over a floor, are not detected.
  /// Failure: NaN if gradient() fails, or if the result is not unique and the pose of a moving object is not known.
  ///          Throws std::invalid_argument for a state of another robot, for a wrong size of `velocity`, and for an object
  ///          that does not exist.
  double rate(const State& state, const PairProximity& pair, const Eigen::Ref<const Eigen::VectorXd>& velocity);

 private:
  std::shared_ptr<const SceneModel> model_;
  std::unique_ptr<ContactFeatures> features_;
  Eigen::VectorXd row_;  ///< working memory
};

}  // namespace proximity_server::scene
