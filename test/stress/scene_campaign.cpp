// ./dev stress scenes: scenes of robots with objects, each answer of which is held against all pairs of convex parts.
#include "stress/campaign.h"
#include "stress/scene_checks.h"

namespace proximity_server::stress {
namespace {

constexpr int kStatesOfCell = 10;  // each of them is a scene

void askCell(const Part& part, Tally& tally) {
  const Stopwatch watch;
  scene::observeScenes(part, kStatesOfCell, tally);
  tally.add("seconds", watch.seconds());
}

}  // namespace

Campaign sceneCampaign() {
  Campaign campaign{"scene_stress", "Looks for scenes of a robot with objects whose answers are wrong.", "scenes",
                    "cell"};
  campaign.option = "--scenes";
  campaign.usual = 100000;
  campaign.cases_of_part = kStatesOfCell;
  campaign.record_file = "recorded_scenes.jsonl";
  campaign.reference_option = "--cells-per-oracle";
  campaign.reference_help = "in one of so many cells, of ten scenes each, the slow oracle is asked too";
  campaign.per_reference = 20;
  campaign.families = namesOf(scene::sceneFamilies());
  campaign.ask = askCell;
  campaign.name_width = 20;
  campaign.columns = {count("scenes", 8, "scenes"),
                      count("pairs", 10, "pairs"),
                      count("questions", 9, "questions"),
                      count("answers", 9, "answers"),
                      count("minima", 8, "minima"),
                      count("overlap", 8, "overlaps"),
                      count("object", 8, "with_object"),
                      count("unknown", 8, "unknown"),
                      count("oracle", 7, "with_oracle"),
                      count("others", 7, "others"),
                      count("off", 8, "others_off"),
                      count("motions", 8, "motions"),
                      count("contacts", 8, "contacts"),
                      count("open", 8, "motions_open"),
                      ratio("ms", 7, "%*.1f", "seconds", "scenes", 1e3),
                      failures(8)};
  campaign.legend =
      "answers: pairs that were held against the truth; minima: nearest pairs of a scene; overlap, object: those\n"
      "that overlap, or have an object; oracle, others: nearest parts that the slow oracle, FCL and Bullet were\n"
      "asked about; off: FCL or Bullet is off by more than 1e-4, and the slow oracle has decided; motions: that "
      "begin in\n"
      "some of the scenes; contacts, open: motions with a first contact, and motions with an answer that did not\n"
      "converge; ms: time of a scene. A failure ends its cell.";
  return campaign;
}

}  // namespace proximity_server::stress
