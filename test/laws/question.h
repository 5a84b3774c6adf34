#pragma once

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/deadline.h"
#include "proximity_server/scene/query/pairs.h"
#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/state/state.h"

#include <Eigen/Geometry>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

// What the laws know of a question about a robot in a state. Each question is a type Q, with the working memory of one caller:
//
//   static constexpr const char* kName;
//   explicit Q(const State& state);     // about its robot and its objects
//   void ask(const State& state, const RobotState& now, const Deadline& deadline, Answer& answer);
//
// A Q that shares data with others has forAnotherThread() as well, which returns what another Q is made of.

namespace proximity_server::scene::laws {

/// A state of a robot by its positions, and by its poses. A question is about one of them.
struct RobotState {
  std::vector<double> positions;
  BodyPoses poses;
  FramePoses frames;
};

/// A robot with objects in several states.
struct Cell {
  std::shared_ptr<const SceneModel> model;
  std::shared_ptr<const Objects> objects;
  std::vector<RobotState> states;
};

/// An answer, as the laws compare it.
class Answer {
 public:
  bool is_known = true;  ///< false if a part of it is Unknown, or not decided
  /// The bounds of the number that is asked for, if there is one.
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< of the closest pair; 0 if there is none

  Answer() { numbers_.reserve(1 << 16); }  // so that no comparison of answers allocates
  void clear() {
    numbers_.clear();
    is_known = true;
    lower = -std::numeric_limits<double>::infinity();
    upper = std::numeric_limits<double>::infinity();
    normal.setZero();
  }

  void add(double number) {
    numbers_.push_back(std::isnan(number) ? std::numeric_limits<double>::quiet_NaN() : number);
  }
  template <class Derived>
  void add(const Eigen::MatrixBase<Derived>& matrix) {
    for (Eigen::Index i = 0; i < matrix.rows(); ++i)
      for (Eigen::Index j = 0; j < matrix.cols(); ++j) add(matrix(i, j));
  }
  void add(const ShapeRef& ref) {
    for (const int number : {static_cast<int>(ref.kind()), ref.link(), ref.object(), ref.point(), ref.collision()})
      add(number);
  }
  /// All but the iterations: a warm start changes them.
  void add(const PairProximity& pair) {
    add(pair.asked.a);
    add(pair.asked.b);
    const narrowphase::SignedDistance& result = pair.result;
    for (const int number : {pair.collision_a, pair.collision_b, static_cast<int>(pair.representation),
                             static_cast<int>(pair.depth_is_lower_bound), static_cast<int>(result.status),
                             static_cast<int>(result.has_points), static_cast<int>(result.unique)})
      add(number);
    for (const double number : {result.distance, result.lower_bound, result.upper_bound}) add(number);
    add(result.point_a);
    add(result.point_b);
    add(result.normal);
  }
  template <class Pairs>
  void addAll(const Pairs& pairs) {
    for (const auto& pair : pairs) add(pair);
  }
  /// Adds the closest pair, to which the bounds belong.
  void addClosest(const PairProximity& pair) {
    add(pair);
    lower = is_known ? pair.result.lower_bound : lower;
    upper = pair.result.upper_bound;
    if (pair.result.has_points) normal = pair.result.normal;
  }

  /// Equal to the last bit, where -0 does not equal 0, and any NaN equals any other.
  bool hasTheBitsOf(const Answer& other) const {
    return numbers_.size() == other.numbers_.size() && is_known == other.is_known &&
           std::memcmp(numbers_.data(), other.numbers_.data(), numbers_.size() * sizeof(double)) == 0;
  }

 private:
  std::vector<double> numbers_;
};

template <class Q, class = void>
struct IsShared : std::false_type {};
template <class Q>
struct IsShared<Q, std::void_t<decltype(std::declval<const Q&>().forAnotherThread())>> : std::true_type {};

/// A question with a state of its own.
template <class Q>
class Asked {
 public:
  explicit Asked(const Cell& cell) : state_(cell.model) {
    state_.set(cell.objects);
    question_.emplace(state_);
  }
  Asked forAnotherThread() const {
    if constexpr (IsShared<Q>::value)
      return {state_.forAnotherThread(), Q(question_->forAnotherThread())};
    else
      return {state_.forAnotherThread(), Q(state_)};
  }
  const Answer& ask(const RobotState& now, const Deadline& deadline = {}) {
    state_.set(now.poses, now.frames);
    return ask(state_, now, deadline);
  }
  const Answer& ask(const State& state, const RobotState& now, const Deadline& deadline = {}) {
    answer_.clear();
    question_->ask(state, now, deadline, answer_);
    return answer_;
  }
  Q& question() { return *question_; }

 private:
  Asked(State state, Q question) : state_(std::move(state)), question_(std::move(question)) {}

  State state_;
  std::optional<Q> question_;
  Answer answer_;
};

}  // namespace proximity_server::scene::laws
