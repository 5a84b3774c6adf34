#pragma once

// The laws of all questions about a robot in a state, each written once: see question.h.

#include "allocations.h"
#include "laws/question.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace proximity_server::scene::laws {

using testing::AssertionFailure;
using testing::AssertionResult;
using testing::AssertionSuccess;

template <class Q>
std::vector<Answer> answersOf(Asked<Q> asked, const Cell& cell) {
  std::vector<Answer> answers;
  for (const RobotState& state : cell.states) answers.push_back(asked.ask(state));
  return answers;
}

inline AssertionResult haveTheSameBits(const std::vector<Answer>& found, const std::vector<Answer>& expected) {
  for (std::size_t i = 0; i < expected.size(); ++i)
    if (i >= found.size() || !found[i].hasTheBitsOf(expected[i]))
      return AssertionFailure() << "other bits in state " << i;
  return AssertionSuccess();
}

/// Two answers enclose the same number, but for `apart`.
inline AssertionResult encloseTheSame(const Answer& x, const Answer& y, double apart = 0.0) {
  const double excess = std::max(x.lower - y.upper, y.lower - x.upper) - apart;
  if (excess <= 0.0) return AssertionSuccess();
  return AssertionFailure() << "[" << x.lower << ", " << x.upper << "] excludes [" << y.lower << ", " << y.upper
                            << "] by " << excess;
}

/// Four threads at once, with questions that share all data which never change.
template <class Q>
AssertionResult isTheSameInOtherThreads(const Cell& cell) {
  const Asked<Q> shared(cell);
  const std::vector<Answer> alone = answersOf(shared.forAnotherThread(), cell);
  std::vector<std::vector<Answer>> together(4);
  std::vector<std::thread> threads;
  for (auto& own : together) threads.emplace_back([&] { own = answersOf(shared.forAnotherThread(), cell); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& own : together)
    if (const AssertionResult same = haveTheSameBits(own, alone); !same) return same;
  return haveTheSameBits(answersOf(Asked<Q>(cell), cell), alone);
}

template <class Q>
AssertionResult isTheSameAskedAgain(const Cell& cell) {
  Asked<Q> asked(cell);
  for (const RobotState& state : cell.states) {
    const Answer first = asked.ask(state);
    if (!asked.ask(state).hasTheBitsOf(first)) return AssertionFailure() << "other bits at rest";
  }
  return AssertionSuccess();
}

/// After it has been asked about the first `states`, `rounds` times.
template <class Q>
AssertionResult allocatesNothingAfter(const Cell& cell, std::size_t states, int rounds) {
  const long before_first = allocations();
  Asked<Q> asked(cell);
  for (int round = 0; round < rounds; ++round)
    for (std::size_t i = 0; i < states; ++i) asked.ask(cell.states[i]);
  if (allocations() == before_first) return AssertionFailure() << "allocations are not counted";
  for (const RobotState& state : cell.states) {
    const long before = allocations();
    asked.ask(state);
    if (allocations() != before) return AssertionFailure() << allocations() - before << " allocations";
  }
  return AssertionSuccess();
}

/// In a state that stays what it is.
template <class Q>
AssertionResult allocatesNothingAtRest(const Cell& cell) {
  State state(cell.model);
  state.set(cell.objects);
  state.set(cell.states.front().poses, cell.states.front().frames);
  Asked<Q> asked(cell);
  asked.ask(state, cell.states.front());
  const long before = allocations();
  asked.ask(state, cell.states.front());
  if (allocations() == before) return AssertionSuccess();
  return AssertionFailure() << allocations() - before << " allocations";
}

/// Values that are no pose.
inline std::vector<std::pair<const char*, std::optional<Eigen::Isometry3d>>> noPoses(const Eigen::Isometry3d& pose) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::pair<const char*, std::optional<Eigen::Isometry3d>>> all{{"NaN as translation", pose},
                                                                            {"infinite", pose},
                                                                            {"NaN as rotation", pose},
                                                                            {"scaled", pose},
                                                                            {"mirrored", pose}};
  all[0].second->translation().x() = kNaN;
  all[1].second->translation().x() = std::numeric_limits<double>::infinity();
  all[2].second->linear()(1, 1) = kNaN;
  all[3].second->linear() *= 1.01;
  all[4].second->linear().col(2) *= -1.0;
  all.emplace_back("missing", std::nullopt);
  return all;
}

/// What depends on a pose or position that is missing is not known, and its bounds hold whatever the pose is; with the
/// next poses it is as if nothing had been.
template <class Q>
AssertionResult isUnknownWithoutAPose(const Cell& cell, int body) {
  Asked<Q> asked(cell);
  for (const RobotState& state : cell.states) {
    const Answer expected = Asked<Q>(cell).ask(state);
    for (const auto& [kind, no_pose] : noPoses(*state.poses[body])) {
      RobotState spoiled = state;
      spoiled.poses[body] = no_pose;
      spoiled.positions[cell.model->robot.bodies[body].joint] = std::numeric_limits<double>::quiet_NaN();
      const Answer& answer = asked.ask(spoiled);
      if (answer.is_known) return AssertionFailure() << "it is known with a pose that is " << kind;
      if (const AssertionResult same = encloseTheSame(answer, expected); !same) return same;
    }
    const Answer& answer = asked.ask(state);
    if (!answer.is_known) return AssertionFailure() << "it is not known when the pose has come back";
    if (const AssertionResult same = encloseTheSame(answer, expected); !same) return same;
  }
  return AssertionSuccess();
}

template <class Q>
AssertionResult refusesAnotherRobot(const Cell& cell) {
  const auto other = std::make_shared<const SceneModel>(*cell.model);
  State state(other);
  state.set(cell.states.front().poses);
  Asked<Q> asked(cell);
  const Answer before = asked.ask(cell.states.front());
  try {
    asked.ask(state, cell.states.front());
    return AssertionFailure() << "it has answered about another robot";
  } catch (const std::invalid_argument&) {
  }
  return asked.ask(cell.states.front()).hasTheBitsOf(before) ? AssertionSuccess()
                                                             : AssertionFailure() << "other bits after a refusal";
}

/// A deadline that has passed, or its flag, leaves bounds that hold, and harms no later answer.
template <class Q>
AssertionResult endsAtItsDeadline(const Cell& cell) {
  const std::atomic<bool> stop{true};
  for (const Deadline& late : {Deadline(stop), Deadline(Deadline::Clock::now() - std::chrono::seconds(1))})
    for (const RobotState& state : cell.states) {
      Asked<Q> asked(cell);
      const Answer open = asked.ask(state, late), expected = Asked<Q>(cell).ask(state);
      if (open.is_known) return AssertionFailure() << "it is known after the deadline";
      if (const AssertionResult same = encloseTheSame(open, expected); !same) return same;
      if (const AssertionResult same = encloseTheSame(asked.ask(state), expected); !same) return same;
    }
  return AssertionSuccess();
}

inline RobotState moved(const RobotState& state, const Eigen::Isometry3d& motion) {
  RobotState result = state;
  for (auto* poses : {&result.poses, &result.frames})
    for (auto& pose : *poses)
      if (pose) pose = motion * *pose;
  return result;
}

/// Robot and objects move as one; no object of the cell may be fixed. `apart`: what poses of that reach round away.
template <class Q>
AssertionResult movesWithItsRobot(const Cell& cell, const Eigen::Isometry3d& motion, double apart) {
  Asked<Q> here(cell), there(cell);
  for (const RobotState& state : cell.states) {
    const Answer& expected = here.ask(state);
    const Answer& found = there.ask(moved(state, motion));
    if (found.is_known != expected.is_known) return AssertionFailure() << "it is known in one place only";
    if (const AssertionResult same = encloseTheSame(found, expected, apart); !same) return same;
  }
  return AssertionSuccess();
}

/// The pairs of a question that is about some pairs, the other way round: the same bounds, and the opposite normal where
/// they have the same bits. Those of a motion are rounded in another order, so that there may be none.
template <class Q>
AssertionResult isTheSameSwapped(const Cell& cell, bool has_the_same_bits = true) {
  Asked<Q> here(cell), there(cell);
  std::vector<ShapeRefPair> pairs;
  cell.objects->forEachCheckedPair([&](const ShapeRef& a, const ShapeRef& b) { pairs.push_back({a, b}); });
  const Candidates candidates(cell.model->pairs);
  pairs.insert(pairs.end(), candidates.list().begin(), candidates.list().end());
  here.question().pairs = pairs;
  for (ShapeRefPair& pair : pairs) std::swap(pair.a, pair.b);
  there.question().pairs = pairs;
  int opposite = 0;
  for (const RobotState& state : cell.states) {
    const Answer &expected = here.ask(state), &found = there.ask(state);
    if (const AssertionResult same = encloseTheSame(found, expected); !same) return same;
    if (found.lower != expected.lower || found.upper != expected.upper) continue;
    if (found.normal != -expected.normal) return AssertionFailure() << "the normal is not the opposite one";
    ++opposite;
  }
  return opposite > 0 || !has_the_same_bits ? AssertionSuccess() : AssertionFailure() << "no normals were compared";
}

}  // namespace proximity_server::scene::laws
