// ./dev stress motions: motions of pairs of shapes, each answer of which is held against an independent search.
#include "stress/campaign.h"
#include "stress/motion_checks.h"
#include "stress/recorded.h"

namespace proximity_server::stress {

using namespace narrowphase;
namespace {

void askMotion(const Part& part, Tally& tally) {
  const StressMotion motion = stressMotion(part.family, part.seed, part.number);
  const bool with_oracle = part.number % part.per_reference == 0;
  const MotionObservation seen = with_oracle ? observeMotionWithOracle(motion) : observeMotion(motion);
  tally.add("motions");
  tally.add("with_oracle", with_oracle);
  tally.add("contacts", seen.contact.contact);
  tally.add("undecided", seen.contact.status != Status::Converged);
  tally.add("open_minima", seen.minimum.status != Status::Converged);
  tally.add("contact_queries", seen.contact.queries);
  tally.add("minimum_queries", seen.minimum.queries);
  tally.raise("most_contact_queries", seen.contact.queries);
  tally.raise("worst_gap", seen.gap);
  tally.add("contact_microseconds", seen.contact_microseconds);
  tally.add("minimum_microseconds", seen.minimum_microseconds);
  if (!seen.failure) return;
  tally.fail({part.number, *seen.failure, [motion](const std::string& name) {
                return toJsonLine(RecordedMotion{name, motion});
              }});
}

}  // namespace

Campaign motionCampaign() {
  Campaign campaign{"motion_stress", "Looks for motions whose time of contact or smallest distance is wrong.",
                    "motions", "motion"};
  campaign.option = "--pairs";
  campaign.usual = 100000;
  campaign.record_file = "recorded_motions.jsonl";
  campaign.reference_option = "--motions-per-oracle";
  campaign.reference_help = "one in so many of a family is compared with the slow oracle";
  campaign.per_reference = 500;
  campaign.families = namesOf(motionFamilies());
  campaign.ask = askMotion;
  campaign.name_width = 22;
  campaign.columns = {count("motions", 9, "motions"),
                      count("oracle", 7, "with_oracle"),
                      count("contacts", 9, "contacts"),
                      count("undecided", 9, "undecided"),
                      count("open min", 9, "open_minima"),
                      ratio("q toc", 7, "%*.1f", "contact_queries", "motions"),
                      count("most", 6, "most_contact_queries"),
                      ratio("q min", 7, "%*.1f", "minimum_queries", "motions"),
                      ratio("us toc", 8, "%*.1f", "contact_microseconds", "motions"),
                      ratio("us min", 8, "%*.1f", "minimum_microseconds", "motions"),
                      number("gap", 8, "%*.1e", "worst_gap"),
                      failures(8)};
  campaign.legend =
      "toc: first contact, min: smallest distance; q: queries of the distance, us: time, both in the mean.\n"
      "undecided, open min: not converged. gap: the largest distance at t_free above the contact distance, where in "
      "contact.";
  return campaign;
}

}  // namespace proximity_server::stress
