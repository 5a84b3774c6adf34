#include "node/soak/soak_record.h"

#include <algorithm>
#include <iostream>

namespace proximity_server::node {
namespace {

using Lock = std::lock_guard<std::mutex>;

/// [s] around a misleading fault: messages are under way, and tf interpolates.
const ros::Duration kAround(0.3);

constexpr std::uint64_t kMaxDescribed = 20;  // wrong answers of a service

}  // namespace

void SoakRecord::count(const std::string& service, Outcome outcome) {
  const Lock lock(mutex_);
  ServiceTally& tally = services_[service];
  switch (outcome) {
    case Outcome::Right:
      ++tally.right;
      return;
    case Outcome::Refused:
      ++tally.refused;
      return;
    case Outcome::Misled:
      ++tally.misled;
      return;
    case Outcome::Lost:
      ++tally.lost;
      return;
  }
}

void SoakRecord::countWrong(const std::string& service, const std::string& why) {
  const Lock lock(mutex_);
  ServiceTally& tally = services_[service];
  if (++tally.wrong <= kMaxDescribed) std::cerr << "soak: " << service << ": " << why << std::endl;
}

void SoakRecord::countFault(const std::string& kind, bool survived, double recovery) {
  const Lock lock(mutex_);
  FaultTally& tally = faults_[kind];
  ++tally.count;
  if (survived) ++tally.survived;
  tally.slowest_recovery = std::max(tally.slowest_recovery, recovery);
}

std::map<std::string, ServiceTally> SoakRecord::services() const {
  const Lock lock(mutex_);
  return services_;
}

std::map<std::string, FaultTally> SoakRecord::faults() const {
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

}  // namespace proximity_server::node
