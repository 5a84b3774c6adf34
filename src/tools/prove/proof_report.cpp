#include "tools/prove/proof_report.h"

#include "tools/prove/proof_json.h"
#include "tools/robot/robot_text.h"
#include "tools/text/csv.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace proximity_server::tools {
namespace {

using Json = nlohmann::ordered_json;
using scene::PairProof;
using scene::ProofOutcome;

constexpr ProofOutcome kOutcomes[] = {ProofOutcome::Proven, ProofOutcome::Refuted, ProofOutcome::Undecided};

std::string digits(const char* format, double number) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), format, number);
  return text.data();
}
std::string metres(double length) { return digits("%.3g m", length); }
std::string percent(double share) { return digits("%.4g %%", 100.0 * share); }

/// How far the pieces of all meshes lie outside of them, and the meshes outside of the pieces [m].
struct Deviations {
  int meshes = 0;
  double outside = 0.0, uncovered = 0.0;
};

Deviations deviationsOf(const scene::RobotModel& robot) {
  Deviations deviations;
  for (const scene::Collision& collision : robot.collisions) {
    if (collision.representation == scene::Representation::Exact) continue;
    ++deviations.meshes;
    deviations.outside = std::max(deviations.outside, collision.deviation);
    deviations.uncovered = std::max(deviations.uncovered, collision.uncovered);
  }
  return deviations;
}

/// The joints of a state that was found; none if no distance was measured.
scene::JointBox closestBox(const PairProof& proof) { return proof.closest.empty() ? scene::JointBox() : proof.box; }

class Text {
 public:
  explicit Text(const ProofReport& report) : report_(report), robot_(report.model->robot) {}

  std::string whole() {
    addSubject();
    for (const ProofOutcome outcome : kOutcomes) addList(outcome);
    addVerdict();
    if (report_.reach) addReach();
    return text_;
  }

 private:
  void addSubject() {
    text_ += "Robot " + scene::quoted(robot_.name) + ": " + std::to_string(report_.proofs.size()) +
             " pairs, in contact up to " + metres(report_.question.contact_distance) + ".\n";
    for (const scene::JointRange& interval : report_.box)
      if (matters(interval.joint))
        text_ += "  " + robot_.joints[interval.joint].name + " from " + shortest(interval.lower) + " to " +
                 shortest(interval.upper) + "\n";
    const Deviations deviations = deviationsOf(robot_);
    if (deviations.meshes == 0) {
      text_ += "The model is the geometry of the URDF.\n";
    } else {
      text_ += "The model has convex pieces in place of " + std::to_string(deviations.meshes) +
               " meshes: they reach up to " + metres(deviations.outside) + " out of a mesh, and a mesh up to " +
               metres(deviations.uncovered) + " out of them.\n";
    }
    const auto padded = std::count_if(report_.model->pairs.pairs.begin(), report_.model->pairs.pairs.end(),
                                      [](const scene::LinkPair& pair) { return pair.padding != 0.0; });
    if (padded > 0) text_ += std::to_string(padded) + " pairs have a padding, which is subtracted.\n";
  }

  /// True if the joint moves a pair.
  bool matters(int joint) const {
    return std::any_of(report_.proofs.begin(), report_.proofs.end(),
                       [&](const PairProof& proof) { return scene::intervalOf(proof.box, joint) != nullptr; });
  }

  void addList(ProofOutcome outcome) {
    text_ += std::string("\n") + toString(outcome) + " (" + std::to_string(report_.count(outcome)) + ")\n";
    for (const PairProof& proof : report_.proofs) {
      if (proof.outcome != outcome) continue;
      text_ += "  " + lineOf(proof) + "\n";
    }
  }

  std::string nameOf(const scene::ShapeRef& ref) const {
    return scene::nameOf(ref, robot_, report_.question.objects.get());
  }

  std::string lineOf(const PairProof& proof) const {
    return nameOf(proof.pair.a) + " - " + nameOf(proof.pair.b) + ": " + evidenceOf(proof) + sharesOf(proof);
  }

  std::string evidenceOf(const PairProof& proof) const {
    if (proof.boxes == 0) return "not examined before the time was over";
    const std::string closest =
        (proof.closest_upper_bound > kContactDistance ? metres(proof.closest_upper_bound) + " apart"
                                                      : std::string("in contact")) +
        stateOf(proof);
    switch (proof.outcome) {
      case ProofOutcome::Proven:
        return "at least " + metres(proof.lower_bound);
      case ProofOutcome::Refuted:
        return closest;
      case ProofOutcome::Undecided:
        break;
    }
    std::string worst;
    for (const scene::JointRange& interval : proof.worst)
      worst += " " + robot_.joints[interval.joint].name + "=" + digits("%.5g", interval.lower) + ".." +
               digits("%.5g", interval.upper);
    return percent(proof.undecided) + " of the box is left, no nearer than " + metres(proof.lower_bound) +
           "; closest seen " + closest + "; worst part" + worst;
  }

  std::string stateOf(const PairProof& proof) const {
    std::string text;
    for (const scene::JointRange& interval : closestBox(proof))
      text += " " + robot_.joints[interval.joint].name + "=" + shortest(proof.closest.at(interval.joint));
    return text.empty() ? "" : ", at" + text;
  }

  std::string sharesOf(const PairProof& proof) const {
    if (report_.question.goal != scene::ProofQuestion::Goal::Shares) return "";
    return "; in contact in " + percent(proof.in_contact) + " to " + percent(proof.in_contact + proof.undecided) +
           " of the box";
  }

  void addVerdict() {
    const int refuted = report_.count(ProofOutcome::Refuted), undecided = report_.count(ProofOutcome::Undecided);
    const std::string of = " of " + std::to_string(report_.proofs.size()) + " pairs";
    text_ += "\n";
    if (report_.isProven()) text_ += "proven: no pair comes into contact in the box\n";
    if (refuted > 0) text_ += "refuted: " + std::to_string(refuted) + of + " come into contact\n";
    if (undecided > 0) text_ += "undecided: " + std::to_string(undecided) + of + "; more: --boxes, --time-budget\n";
  }

  void addReach() {
    text_ += "The box reaches " + digits("%.4g", *report_.reach) + " rad or m from the state.";
    for (const PairProof& proof : report_.beyond)
      text_ += std::string("\n  beyond, ") + toString(proof.outcome) + ": " + lineOf(proof);
    text_ += "\n";
  }

  const ProofReport& report_;
  const scene::RobotModel& robot_;
  std::string text_;
};

Json numberOf(double number) { return std::isfinite(number) ? Json(number) : Json(); }

Json pairOf(const PairProof& proof, const ProofReport& report) {
  const scene::RobotModel& robot = report.model->robot;
  const scene::Objects* objects = report.question.objects.get();
  Json pair{{"a", nameOf(proof.pair.a, robot, objects)}, {"b", nameOf(proof.pair.b, robot, objects)}};
  pair["outcome"] = toString(proof.outcome);
  pair["lower_bound"] = numberOf(proof.lower_bound);
  pair["closest_upper_bound"] = numberOf(proof.closest_upper_bound);
  Json state = Json::object();
  for (const scene::JointRange& interval : closestBox(proof))
    state[robot.joints[interval.joint].name] = proof.closest.at(interval.joint);
  pair["closest"] = state;
  pair["undecided"] = proof.undecided;
  pair["in_contact"] = proof.in_contact;
  pair["worst"] = boxJson(proof.worst, robot);
  pair["boxes"] = proof.boxes;
  return pair;
}

}  // namespace

int ProofReport::count(ProofOutcome outcome) const {
  return static_cast<int>(
      std::count_if(proofs.begin(), proofs.end(), [&](const PairProof& proof) { return proof.outcome == outcome; }));
}

std::string proofText(const ProofReport& report) { return Text(report).whole(); }

std::string proofJson(const ProofReport& report) {
  const Deviations deviations = deviationsOf(report.model->robot);
  Json json{{"robot", report.model->robot.name}, {"contact_distance", report.question.contact_distance}};
  json["box"] = boxJson(report.box, report.model->robot);
  json["model"] = {{"meshes_as_pieces", deviations.meshes},
                   {"pieces_outside_of_meshes", deviations.outside},
                   {"meshes_outside_of_pieces", deviations.uncovered}};
  for (const ProofOutcome outcome : kOutcomes) json[toString(outcome)] = report.count(outcome);
  json["pairs"] = Json::array();
  for (const PairProof& proof : report.proofs) json["pairs"].push_back(pairOf(proof, report));
  if (report.reach) {
    json["reach"] = *report.reach;
    json["beyond"] = Json::array();
    for (const PairProof& proof : report.beyond) json["beyond"].push_back(pairOf(proof, report));
  }
  return jsonText(json);
}

std::string refutingStates(const ProofReport& report) {
  const scene::RobotModel& robot = report.model->robot;
  std::string text;
  for (const scene::JointRange& interval : report.box)
    text += (text.empty() ? "" : ",") + csvField(robot.joints[interval.joint].name);
  text += "\n";
  for (const PairProof& proof : report.proofs) {
    if (proof.outcome != ProofOutcome::Refuted) continue;
    std::string row;
    for (const scene::JointRange& interval : report.box)
      row += (row.empty() ? "" : ",") + shortest(proof.closest.at(interval.joint));
    text += row + "\n";
  }
  return text;
}

}  // namespace proximity_server::tools
