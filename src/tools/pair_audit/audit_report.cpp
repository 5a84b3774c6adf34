#include "tools/pair_audit/audit_report.h"

#include "proximity_server/scene/filter/srdf_reason.h"
#include "tools/robot/robot_text.h"

#include <algorithm>
#include <sstream>

namespace proximity_server::tools {
namespace {

/// "in contact", or "within 0.02 m".
std::string nearText(double near) { return near > kContactDistance ? "within " + lengthText(near) : "in contact"; }

std::string toText(NearClass near_class, double near) {
  switch (near_class) {
    case NearClass::Always:
      return "always " + nearText(near);
    case NearClass::Never:
      return "never " + nearText(near);
    case NearClass::Sometimes:
      return nearText(near) + " in some states";
    case NearClass::Undecided:
      return "not decided";
  }
  return "unknown";
}

std::string smallestText(const PairEvidence& evidence) {
  return evidence.contact ? "contact" : lengthText(evidence.smallest);
}

/// The evidence for the class of a pair.
std::string evidenceText(const PairEvidence& evidence) {
  const std::string seen_in = " in " + std::to_string(evidence.samples) + " samples and a search";
  const bool is_proven = evidence.proven && *evidence.proven > evidence.near;
  switch (evidence.nearClass()) {
    case NearClass::Always:
      return evidence.alwaysInContact()
                 ? "not seen apart" + seen_in
                 : "from " + smallestText(evidence) + " to " + lengthText(evidence.largest) + seen_in;
    case NearClass::Never:
      return "closest seen " + lengthText(evidence.smallest) + "; " +
             (is_proven ? "proven: at least " + lengthText(*evidence.proven)
                        : (evidence.near > kContactDistance ? "nothing nearer" : "contact not seen") + seen_in);
    case NearClass::Undecided:
      return std::string(evidence.within ? "always " : "never ") + nearText(evidence.near) + " so far, but " +
             (evidence.has_known_ranges ? "the time was over before a search"
                                        : "a joint between them can do more than was tried");
    case NearClass::Sometimes:
      if (evidence.near > kContactDistance)
        return evidence.contact ? "down to contact" : "down to " + lengthText(evidence.smallest);
      break;
  }
  return "";
}

/// [m] How far the convex pieces of two links lie from their meshes, together.
double deviationOf(const scene::RobotModel& robot, const scene::ShapeRefPair& pair) {
  double sum = 0.0;
  for (const int link : {pair.a.link(), pair.b.link()}) {
    double largest = 0.0;
    for (const int i : robot.links[link].collisions) largest = std::max(largest, robot.collisions[i].deviation);
    sum += largest;
  }
  return sum;
}

class Report {
 public:
  Report(const scene::SceneModel& model, const PairStudy& study) : model_(model), study_(study) {}

  void addSummary() {
    text_ << "Robot \"" << model_.robot.name << "\": " << study_.pairs.size() << " pairs of links, " << study_.samples
          << " random states, " << endText() << ".\n"
          << beyondText();
    if (study_.is_out_of_time) text_ << cutText();
    for (const scene::JointRange& range : scene::jointRanges(model_.robot)) {
      if (scene::hasKnownRange(model_.robot, range.joint)) continue;
      text_ << "Joint \"" << model_.robot.joints[range.joint].name << "\" has no limits; tried from "
            << lengthText(range.lower) << " to " << lengthText(range.upper) << ".\n";
    }
    for (const scene::Joint& joint : model_.robot.joints) {
      if (joint.type != scene::Joint::Type::Floating && joint.type != scene::Joint::Type::Planar) continue;
      text_ << "Joint \"" << joint.name << "\" is floating or planar; it stood still.\n";
    }
  }

  void addClass(NearClass near_class) {
    std::vector<std::string> lines;
    for (const PairEvidence& evidence : study_.pairs) {
      if (evidence.are_neighbours || evidence.nearClass() != near_class) continue;
      const std::string proof = evidenceText(evidence);
      lines.push_back(names(evidence) + (proof.empty() ? "" : ": " + proof));
    }
    addList(toText(near_class, study_.near), lines);
  }

  /// Comes before the other lists, because neighbours are not checked at all.
  void addNeighboursThatCollide() {
    std::vector<std::string> lines;
    for (const PairEvidence& evidence : study_.pairs) {
      if (!evidence.are_neighbours || evidence.nearClass() != NearClass::Sometimes) continue;
      lines.push_back(names(evidence) + ": " + reasonText(evidence) + contactText(evidence));
    }
    addList("adjacent, but apart in some states and in contact in others", lines);
  }

  void addNeighbours() {
    std::vector<std::string> lines;
    for (const PairEvidence& evidence : study_.pairs) {
      if (evidence.are_neighbours)
        lines.push_back(names(evidence) + ": " + toText(evidence.nearClass(), evidence.near));
    }
    addList("adjacent (joined by one joint)", lines);
  }

  void addSrdfFaults() {
    const SrdfFaults faults = findSrdfFaults(model_, study_);
    const auto contactOf = [&](const PairEvidence& evidence) { return reasonText(evidence) + contactText(evidence); };
    if (!faults.disabled_by_decision.empty())
      addList("disabled by decision, although they can collide", linesOf(faults.disabled_by_decision, contactOf));
    text_ << "\nWhat the SRDF gets wrong:\n";
    addList("disabled, but they can collide", linesOf(faults.disabled_but_touch, contactOf));
    if (study_.near > kContactDistance) {
      addList("disabled, but they come " + nearText(study_.near),
              linesOf(faults.disabled_but_near, [&](const PairEvidence& evidence) {
                return reasonText(evidence) + lengthText(evidence.smallest) + " apart at " +
                       stateText(model_.robot, evidence.pair, evidence.closest);
              }));
    }
    addList("checked, but never " + nearText(study_.measured), linesOf(faults.checked_but_never, evidenceText));
    addList("checked, but always in contact", linesOf(faults.checked_but_always, evidenceText));
    std::vector<std::string> idle;
    for (const scene::IdleEntry& entry : model_.pairs.idle) {
      idle.push_back(entry.list + " " + entry.link_a + " - " + entry.link_b + ": " + causeText(entry));
    }
    addList("remarks", model_.pairs.warnings);
    addList("entries without effect", idle);  // last, as there may be hundreds
  }

  std::string text() const { return text_.str(); }

 private:
  /// The contact of a pair, with a remark if only the convex pieces may be in contact and not the meshes.
  std::string contactText(const PairEvidence& evidence) const {
    const std::string doubt = isInDoubt(model_, evidence)
                                  ? " (in doubt: what is checked lies up to " +
                                        lengthText(deviationOf(model_.robot, evidence.pair)) + " from the meshes)"
                                  : "";
    return "in contact, " + lengthText(evidence.contact_depth) + " deep" + doubt + ", at " +
           stateText(model_.robot, evidence.pair, *evidence.contact);
  }

  std::string endText() const {
    switch (study_.end) {
      case SamplingEnd::MaxSamples:
        return "after which pairs may still change their class (more: --samples)";
      case SamplingEnd::Quiet:
        return "of which the last " + std::to_string(kQuietSamples) + " changed the class of no pair";
      case SamplingEnd::AllKnown:
        return "after which every pair had been seen in contact and " +
               (study_.near > kContactDistance ? "not " + nearText(study_.near) : "apart");
      case SamplingEnd::OutOfTime:
        return "after which the time was over";
    }
    return "";
  }

  /// How many pairs an SRDF may disable as "Never", and what that stands on.
  std::string beyondText() const {
    int beyond = 0, unproven = 0;
    const PairEvidence* closest = nullptr;
    for (const PairEvidence& evidence : study_.pairs) {
      if (evidence.are_neighbours || !evidence.isBeyond()) continue;
      ++beyond;
      if (evidence.isProvenBeyond()) continue;
      ++unproven;
      if (!closest || evidence.smallest < closest->smallest) closest = &evidence;
    }
    return "Never " + nearText(study_.measured) + ": " + std::to_string(beyond) + " pairs, " +
           std::to_string(beyond - unproven) + " of them proven" +
           (closest ? "; of the other " + std::to_string(unproven) + " the closest seen is " + names(*closest) + ", " +
                          lengthText(closest->smallest)
                    : "") +
           ".\n";
  }

  /// The pairs that the time budget left out.
  std::string cutText() const {
    const auto is_open = [](const PairEvidence& evidence) { return !evidence.is_searched; };
    return "The time was over: " + std::to_string(std::count_if(study_.pairs.begin(), study_.pairs.end(), is_open)) +
           " pairs were not searched, and proofs were cut short. Another run may have looked at more.\n";
  }

  std::string names(const PairEvidence& evidence) const {
    return nameOf(evidence.pair.a, model_.robot) + " - " + nameOf(evidence.pair.b, model_.robot);
  }

  void addList(const std::string& title, const std::vector<std::string>& lines) {
    text_ << '\n' << title << " (" << lines.size() << ")\n";
    for (const std::string& line : lines) text_ << "  " << line << '\n';
  }

  template <typename Describe>
  std::vector<std::string> linesOf(const std::vector<int>& indices, const Describe& describe) const {
    std::vector<std::string> lines;
    for (const int i : indices) lines.push_back(names(study_.pairs[i]) + ": " + describe(study_.pairs[i]));
    return lines;
  }

  /// The reason that the SRDF gives.
  std::string reasonText(const PairEvidence& evidence) const {
    const scene::PairTable& table = model_.pairs;
    const scene::LinkPair& pair = table.pairs[table.find(evidence.pair.a.link(), evidence.pair.b.link())];
    return pair.detail.empty() ? "" : "said to be \"" + pair.detail + "\", ";
  }

  static std::string causeText(const scene::IdleEntry& entry) {
    switch (entry.cause) {
      case scene::IdleEntry::Cause::UnknownLink:
        return "there is no such link";
      case scene::IdleEntry::Cause::NoGeometry:
        return "no collision geometry";
      case scene::IdleEntry::Cause::SameBody:
        return "one rigid body";
      case scene::IdleEntry::Cause::Repeated:
        return "said before";
    }
    return "unknown";
  }

  const scene::SceneModel& model_;
  const PairStudy& study_;
  std::ostringstream text_;
};

}  // namespace

bool isInDoubt(const scene::SceneModel& model, const PairEvidence& evidence) {
  const double deviation = deviationOf(model.robot, evidence.pair);
  return deviation > kContactDistance && evidence.contact_depth <= deviation;
}

SrdfFaults findSrdfFaults(const scene::SceneModel& model, const PairStudy& study) {
  SrdfFaults faults;
  for (int i = 0; i < static_cast<int>(study.pairs.size()); ++i) {
    const PairEvidence& evidence = study.pairs[i];
    const scene::LinkPair& pair = model.pairs.pairs[model.pairs.find(evidence.pair.a.link(), evidence.pair.b.link())];
    const scene::PairReason reason = pair.reason;
    if (reason == scene::PairReason::SrdfDisabled && !evidence.are_neighbours) {  // neighbours have a list of their own
      if (evidence.canCollide()) {
        (scene::isDecision(pair.detail) ? faults.disabled_by_decision : faults.disabled_but_touch).push_back(i);
      } else if (!scene::isDecision(pair.detail) && evidence.within && !evidence.alwaysInContact()) {
        faults.disabled_but_near.push_back(i);
      }
    }
    if (reason != scene::PairReason::Checked) continue;
    if (evidence.isBeyond()) faults.checked_but_never.push_back(i);
    if (evidence.alwaysInContact()) faults.checked_but_always.push_back(i);
  }
  return faults;
}

std::string auditReport(const scene::SceneModel& model, const PairStudy& study, SrdfGiven srdf) {
  Report report(model, study);
  report.addSummary();
  report.addNeighboursThatCollide();
  for (const NearClass near_class : {NearClass::Always, NearClass::Never, NearClass::Sometimes, NearClass::Undecided}) {
    report.addClass(near_class);
  }
  report.addNeighbours();
  if (srdf == SrdfGiven::Yes) report.addSrdfFaults();
  return report.text();
}

}  // namespace proximity_server::tools
