#include "node/soak/soak_record.h"

#include <algorithm>
#include <chrono>
#include <iostream>

namespace proximity_server::node {
namespace {

using Lock = std::lock_guard<std::mutex>;

/// [s] around a misleading fault: messages are under way, and tf interpolates.
const ros::Duration kAround(0.3);

constexpr double kMaxDescribed = 20;  // wrong answers of a service

}  // namespace

void SoakRecord::count(const std::string& service, Outcome outcome) {
  constexpr const char* kNames[] = {"right", "refused", "misled", "lost"};
  const Lock lock(mutex_);
  answers_[service].add(kNames[static_cast<int>(outcome)]);
}

void SoakRecord::countWrong(const std::string& service, const std::string& why) {
  const Lock lock(mutex_);
  stress::Tally& tally = answers_[service];
  tally.add("wrong");
  if (tally["wrong"] <= kMaxDescribed) std::cerr << "soak: " << service << ": " << why << std::endl;
}

void SoakRecord::countFault(const std::string& kind, bool survived, double recovery) {
  const Lock lock(mutex_);
  stress::Tally& tally = faults_[kind];
  tally.add("happened");
  tally.add("survived", survived);
  tally.raise("recovery", recovery);
}

SoakRecord::Tallies SoakRecord::answers() const {
  const Lock lock(mutex_);
  return answers_;
}

SoakRecord::Tallies SoakRecord::faults() const {
  const Lock lock(mutex_);
  return faults_;
}

void SoakRecord::startMisleading() {
  const Lock lock(mutex_);
  misleading_.push_back({ros::Time::now() - kAround, ros::TIME_MAX});
}

void SoakRecord::stopMisleading() {
  const Lock lock(mutex_);
  misleading_.back().end = ros::Time::now() + kAround;
}

bool SoakRecord::isMisled(const ros::Time& stamp) const {
  const Lock lock(mutex_);
  return std::any_of(misleading_.rbegin(), misleading_.rend(),
                     [&](const Interval& interval) { return interval.begin <= stamp && stamp <= interval.end; });
}

std::string SoakCalls::service() const {
  const Lock lock(mutex_);
  return service_;
}

double SoakCalls::waiting() const {
  const Lock lock(mutex_);
  return std::max(0.0, std::chrono::duration<double>(Clock::now() - begin_).count());
}

void SoakCalls::begin(const std::string& service) {
  const Lock lock(mutex_);
  begin_ = Clock::now();
  service_ = service;
}

void SoakCalls::end() {
  const Lock lock(mutex_);
  begin_ = Clock::time_point::max();
}

void SoakCalls::countLost(const std::string& service, bool was_up, int starts) {
  const bool excused = !was_up || !record_.nodeIsUp() || record_.starts() != starts || starts_seen_ != starts;
  starts_seen_ = starts;  // once: every connection of before is broken
  if (excused || record_.isStopped()) {
    record_.count(service, SoakRecord::Outcome::Lost);
    disconnect();
  } else {
    record_.countWrong(service, "the call was lost while the node was there");
    clients_.erase(service);
  }
}

}  // namespace proximity_server::node
