#include "tools/pair_audit/level_report.h"

#include "proximity_server/scene/model/names.h"
#include "tools/pair_audit/srdf_writer.h"

#include <algorithm>

namespace proximity_server::tools {
namespace {

using Level = scene::ClearanceLevel;

constexpr std::size_t kListed = 10;  // pairs, and all suspects

/// "COLLISION at rest and in 92.4 % of the states"; "" if there is no such state.
std::string statesText(Level level, const PairLevels& pair) {
  const bool at_rest = pair.at_rest == level;
  const int states = level == Level::Collision ? pair.collisions : pair.stops;
  if (!at_rest && states == 0) return "";
  return toString(level) + std::string(at_rest ? " at rest" : "") + (at_rest && states > 0 ? " and" : "") +
         (states > 0 ? " in " + shareText(states) + " of the states" : "");
}

/// The line that ends the alarms of a pair, and what it costs.
std::string lineText(const scene::RobotModel& robot, const PairLevels& pair, const PairStudy& study,
                     const scene::StopAndWarn& usual) {
  const PairEvidence& evidence = evidenceOf(pair.pair, study);
  if (evidence.contact || pair.collisions > 0 || pair.at_rest == Level::Collision)
    return "    " + disablingEntry(robot, pair) + "\n    costs: " + costOfDisabling(pair, study) + "\n";
  const double stop = scene::fittingThresholds({pair.pair, evidence.smallest, evidence.smallest}, usual).stop;
  return "    pair_stop_distance: [" + scene::thresholdEntry(robot, pair.pair, stop) + "]\n    costs: STOP from " +
         scene::shortest(stop) + " m on, not from " + scene::shortest(usual.stop) + " m\n";
}

}  // namespace

std::string suspicionOf(const PairLevels& pair) {
  return 2 * pair.collisions > LevelShares::kStates ? "an overlap of the model"
                                                    : "an overlap of the model, or the robot never rests so";
}

std::string costOfDisabling(const PairLevels& pair, const PairStudy& study) {
  return evidenceOf(pair.pair, study).alwaysInContact()
             ? "nothing, the two were never seen apart"
             : "nobody reports that the two meet; they were apart in " +
                   shareText(LevelShares::kStates - pair.collisions) + " of the states";
}

std::string levelReport(const scene::RobotModel& robot, const PairStudy& study, const LevelShares& shares,
                        const scene::StopAndWarn& usual) {
  const std::size_t suspects = shares.suspects().size();
  const std::size_t listed = std::min(shares.of_pairs.size(), std::max(kListed, suspects));
  std::string text = "\nThe pairs that set COLLISION and STOP most often (" + std::to_string(listed) + " of " +
                     std::to_string(shares.of_pairs.size()) + ")\n";
  for (std::size_t i = 0; i < listed; ++i) {
    const PairLevels& pair = shares.of_pairs[i];
    const std::string collision = statesText(Level::Collision, pair), stop = statesText(Level::Stop, pair);
    text += "  " + nameOf(pair.pair.a, robot) + " - " + nameOf(pair.pair.b, robot) + ": " + collision +
            (collision.empty() || stop.empty() ? "" : ", ") + stop +
            (pair.isSuspect() ? ": " + suspicionOf(pair) : "") + "\n" + lineText(robot, pair, study, usual);
  }
  const int collisions = shares.counts()[static_cast<std::size_t>(Level::Collision)];
  if (suspects == 0 && 2 * collisions > LevelShares::kStates)
    text += "COLLISION in " + shareText(collisions) +
            " of the random states, but no pair in more than half of them: the limits of the joints let legs, arms or "
            "fingers meet, which they do in random states, and the robot avoids.\n";
  return text;
}

}  // namespace proximity_server::tools
