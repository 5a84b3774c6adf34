#pragma once

#include "from_environment.h"
#include "sanitized.h"
#include "stress/campaign.h"

#include <gtest/gtest.h>

// The part of a campaign that every test run makes.

namespace proximity_server::stress {

/// Asks `usual` cases, or as many as an environment variable says, and expects that no promise is broken.
inline std::vector<Tally> expectNoFailure(const Campaign& campaign, const char* variable, std::int64_t usual) {
  std::vector<Tally> tallies = observe(campaign, Run{fromEnvironment(variable, usual)});
  for (const Tally& tally : tallies) {
    EXPECT_GT(tally[campaign.cases], 0) << tally.family;
    for (const Failure& failure : tally.failures())
      ADD_FAILURE() << tally.family << ", " << campaign.one << " " << failure.number << ": " << failure.sentence
                    << "\n./dev stress records it";
  }
  return tallies;
}

/// Returns the result of all families together.
inline Tally sumOf(const std::vector<Tally>& tallies) {
  Tally all;
  for (const Tally& tally : tallies) all.merge(tally);
  return all;
}

/// Expects the same numbers of some names with one thread and with three.
inline void expectIndependenceOfThreads(const Campaign& campaign, std::int64_t cases,
                                        const std::vector<const char*>& names) {
  Run run{cases};
  run.threads = 1;
  const std::vector<Tally> one = observe(campaign, run);
  run.threads = 3;
  const std::vector<Tally> three = observe(campaign, run);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_GT(one[i][campaign.cases], 0) << one[i].family;
    for (const char* name : names) EXPECT_EQ(one[i][name], three[i][name]) << one[i].family << ", " << name;
  }
  const std::map<std::string, double> all = sumOf(one).numbers();
  for (const char* name : names) EXPECT_EQ(all.count(name), 1u) << "no family has counted " << name;
}

}  // namespace proximity_server::stress
