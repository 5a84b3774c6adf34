// ./dev stress: pairs of shapes, each of which is held against every promise of the narrowphase.
#include "laws/pair_laws.h"
#include "stress/campaign.h"
#include "stress/recorded.h"

namespace proximity_server::stress {

using namespace narrowphase;
namespace {

void add(const Observation& seen, std::int64_t number, Tally& tally) {
  const SignedDistance& result = seen.result;
  const bool converged = result.status == Status::Converged;
  tally.add("pairs");
  tally.add("with_oracle", seen.error.has_value());
  tally.add("not_converged", !converged);
  tally.raise("worst_error", seen.error && converged ? *seen.error / seen.size : 0.0);
  tally.raise("worst_gap", converged ? (result.upper_bound - result.lower_bound) / seen.size : 0.0);
  tally.raise("most_iterations", result.iterations);
  tally.raise("worst_microseconds", seen.microseconds);
  if (!seen.failure) return;
  const StressPair pair = seen.failure->pair;
  tally.fail({number, seen.failure->sentence, [pair](const std::string& name) {
                return toJsonLine(RecordedPair{name, pair, {}, {}});
              }});
}

void askBlock(const Part& part, Tally& tally) {
  std::int64_t number = kPairsPerBlock * part.number;
  for (const StressPair& pair : stressBlock(part.family, part.seed, part.number)) {
    add(number % part.per_reference == 0 ? observeWithOracle(pair) : observe(pair), number, tally);
    ++number;
  }
}

}  // namespace

Campaign pairCampaign() {
  Campaign campaign{"stress", "Looks for pairs of shapes that the narrowphase gets wrong.", "pairs", "pair"};
  campaign.option = "--pairs";
  campaign.usual = 1000000;
  campaign.cases_of_part = kPairsPerBlock;
  campaign.record_file = "recorded_pairs.jsonl";
  campaign.reference_option = "--pairs-per-oracle";
  campaign.reference_help = "one in so many pairs of each family is compared with the slow oracle";
  campaign.per_reference = 192;
  campaign.families = namesOf(stressFamilies());
  campaign.ask = askBlock;
  campaign.name_width = 34;
  campaign.columns = {count("pairs", 11, "pairs"),
                      count("oracle", 9, "with_oracle"),
                      number("error", 9, "%*.1e", "worst_error"),
                      number("gap", 9, "%*.1e", "worst_gap"),
                      count("iter", 6, "most_iterations"),
                      number("us", 9, "%*.1f", "worst_microseconds"),
                      count("unconverged", 11, "not_converged"),
                      failures(9)};
  campaign.legend = "Worst of each family. error and gap as part of the size, where converged; us: time of one query.";
  return campaign;
}

}  // namespace proximity_server::stress
