#include "tools/model_check/model_checks.h"

#include "proximity_server/narrowphase/shape/support.h"
#include "proximity_server/scene/files/xml_declarations.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/objects/object.h"
#include "proximity_server/scene/query/scene.h"
#include "tools/pair_audit/audit_report.h"
#include "tools/pair_audit/level_report.h"
#include "tools/pair_audit/srdf_writer.h"
#include "tools/robot/robot_text.h"

#include <tinyxml2.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace proximity_server::tools {
namespace {

using Eigen::Vector3d;

constexpr double kTouch = 1e-4;  // [m] parts that are made to meet, as fingers, overlap by less

std::string millimetres(double length) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.3g mm", 1e3 * length);
  return text.data();
}

bool isXacro(const char* text) {
  return text && (std::strstr(text, "${") != nullptr || std::strstr(text, "$(") != nullptr);
}

void addXacroOf(const tinyxml2::XMLElement& element, const std::string& file, std::vector<Finding>& findings) {
  std::string leftover;
  if (std::strncmp(element.Name(), "xacro:", 6) == 0) leftover = "<" + std::string(element.Name()) + ">";
  for (const auto* attribute = element.FirstAttribute(); attribute; attribute = attribute->Next())
    if (isXacro(attribute->Value())) leftover = attribute->Value();
  if (isXacro(element.GetText())) leftover = element.GetText();
  if (!leftover.empty())
    findings.push_back({Severity::Error, "xacro", file + ", line " + std::to_string(element.GetLineNum()),
                        "\"" + leftover + "\" was not expanded.", "Run xacro on the file first."});
  for (const auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement())
    addXacroOf(*child, file, findings);
}

Finding ofJoint(Severity severity, const char* check, const scene::Joint& joint, const std::string& what,
                const std::string& advice) {
  return {severity, check, joint.name, what, advice};
}

void findMimic(const scene::RobotModel& robot, const scene::Joint& joint, std::vector<Finding>& findings) {
  const scene::Joint::Mimic leader = robot.leaderOf(scene::findNamed(robot.joints, joint.name));
  const scene::Joint& led_by = robot.joints[leader.joint];
  double lower = leader.offset + leader.multiplier * led_by.lower;
  double upper = leader.offset + leader.multiplier * led_by.upper;
  if (lower > upper) std::swap(lower, upper);
  constexpr double kWritten = 1e-3;  // [rad] or [m]: limits are often written with three digits
  if (!(lower < joint.lower - kWritten || upper > joint.upper + kWritten)) return;
  std::ostringstream what;
  what << "it follows joint \"" << led_by.name << "\" from " << lower << " to " << upper << ", beyond its limits "
       << joint.lower << " to " << joint.upper << ".";
  findings.push_back(ofJoint(Severity::Warning, "mimic", joint, what.str(),
                             "It is checked where its leader takes it; the limits of one of the two are wrong."));
}

/// The points at which a piece is looked for outside of another geometry, in the frame of its body.
std::vector<Vector3d> pointsOf(const scene::Piece& piece) {
  std::vector<Vector3d> points;
  if (piece.shape.kind() == narrowphase::Shape::Kind::Hull) {
    for (const Vector3d& vertex : piece.shape.hull().vertices()) points.push_back(piece.body_T_piece * vertex);
    return points;
  }
  for (int x = -2; x <= 2; ++x)
    for (int y = -2; y <= 2; ++y)
      for (int z = -2; z <= 2; ++z) {
        const Vector3d direction(x, y, z);
        if (direction.isZero()) continue;
        int vertex = 0;
        points.push_back(piece.body_T_piece * (narrowphase::supportPoint(piece.shape, direction, vertex) +
                                               piece.shape.margin() * direction.normalized()));
      }
  return points;
}

/// [m] The diagonal of the box around the geometry of a link.
double sizeOf(const scene::RobotModel& robot, int link) {
  Eigen::AlignedBox3d box;
  for (const int piece : robot.piecesOf(link))
    for (const Vector3d& point : pointsOf(robot.pieces[piece])) box.extend(point);
  return box.diagonal().norm();
}

/// Measures how far points lie outside of the collision geometry of links: a small ball that can be anywhere.
class Probe {
 public:
  explicit Probe(const std::shared_ptr<const scene::SceneModel>& model)
      : scene_(model),
        state_(model),
        poses_(scene::forwardKinematics(model->robot, scene::Positions(model->robot.joints.size(), 0.0))) {
    const scene::Object ball =
        scene::makeObject("", {{narrowphase::Shape(narrowphase::Sphere{kRadius})}}, scene::Moving{"probe"});
    scene::Object named = ball;
    named.id = freeName(model->robot);
    state_.set(std::make_shared<const scene::Objects>(scene::Objects(model).changed({scene::AddObject{named}})));
  }

  /// [m] The signed distance of a point in the frame of the link's body.
  double distance(int link, const Vector3d& point) {
    const int body = scene_.model().robot.links[link].body;
    const Eigen::Isometry3d frame = *poses_[body] * Eigen::Translation3d(point);
    state_.set(poses_, {frame});
    const scene::ShapeRefPair pair{link, scene::ShapeRef::ofObject(state_.objects()->numbers().front())};
    return scene_.proximity(state_, pair).result.distance + kRadius;
  }

 private:
  static constexpr double kRadius = 1e-6;  // [m]

  static std::string freeName(const scene::RobotModel& robot) {
    std::string name = "probe";
    while (robot.findLink(name) >= 0) name += "_";
    return name;
  }

  scene::Scene scene_;
  scene::State state_;
  const scene::BodyPoses poses_;
};

const scene::LinkPair& entryOf(const scene::SceneModel& model, const PairEvidence& evidence) {
  return model.pairs.pairs[model.pairs.find(evidence.pair.a.link(), evidence.pair.b.link())];
}

Finding ofPair(Severity severity, const char* check, const scene::SceneModel& model, const PairEvidence& evidence,
               const std::string& what, const std::string& advice) {
  return {severity, check, nameOf(evidence.pair.a, model.robot) + " - " + nameOf(evidence.pair.b, model.robot), what,
          advice};
}

std::string contactOf(const scene::SceneModel& model, const PairEvidence& evidence) {
  return "they overlap by " + millimetres(evidence.contact_depth) + " at " +
         stateText(model.robot, evidence.pair, *evidence.contact) + ".";
}

void findNeighbour(const scene::SceneModel& model, const PairEvidence& evidence, std::vector<Finding>& findings) {
  if (evidence.alwaysInContact()) {
    findings.push_back(ofPair(Severity::Note, "neighbour", model, evidence,
                              "neighbours that are in contact in every state: their collisions are not checked.", ""));
  } else if (evidence.canCollide() && evidence.contact_depth >= kTouch && !isInDoubt(model, evidence)) {
    findings.push_back(
        ofPair(Severity::Warning, "neighbour", model, evidence,
               "neighbours are not checked, but are apart in some states, and in others " + contactOf(model, evidence),
               "Tighten the limits of the joint, or have the pair checked (enable_collisions)."));
  }
}

}  // namespace

std::vector<Finding> findXacro(const std::string& file, const std::string& urdf_xml) {
  tinyxml2::XMLDocument document;
  if (document.Parse(scene::withoutLateDeclarations(urdf_xml).c_str()) != tinyxml2::XML_SUCCESS ||
      !document.RootElement())
    return {};  // loading names the fault
  std::vector<Finding> findings;
  addXacroOf(*document.RootElement(), file, findings);
  return findings;
}

std::vector<Finding> findWarnings(const scene::SceneModel& model) {
  std::vector<Finding> findings;
  for (const std::string& warning : model.robot.warnings)
    if (warning.rfind(scene::kSeenOnly, 0) != 0)  // findVisuals() has a finding for each of these links
      findings.push_back({Severity::Warning, "loading", "URDF", warning, ""});
  for (const std::string& warning : model.pairs.warnings)
    findings.push_back({Severity::Warning, "srdf", "SRDF", warning, ""});
  return findings;
}

std::vector<Finding> findLimits(const scene::RobotModel& robot) {
  std::vector<Finding> findings;
  for (const scene::Joint& joint : robot.joints) {
    using Type = scene::Joint::Type;
    const bool should_have_limits = joint.type == Type::Revolute || joint.type == Type::Prismatic;
    const bool has_limits = std::isfinite(joint.lower) && std::isfinite(joint.upper);
    if (joint.mimic) {
      findMimic(robot, joint, findings);
    } else if (should_have_limits && !has_limits) {
      findings.push_back(ofJoint(Severity::Warning, "limits", joint, "it has no limits.",
                                 "Nothing can be proven over its whole range, and no motion stops at its end."));
    } else if (should_have_limits && joint.lower == joint.upper) {
      findings.push_back(ofJoint(Severity::Warning, "limits", joint, "its limits are the same number: it cannot move.",
                                 "Make it a fixed joint, or give it its range."));
    }
    if (scene::hasOnePosition(joint) && !(std::isfinite(joint.max_velocity) && joint.max_velocity > 0.0))
      findings.push_back(ofJoint(Severity::Note, "limits", joint, "it has no largest velocity.",
                                 "pose_latency \"limit\" and times of contact need one."));
  }
  return findings;
}

std::vector<Finding> findInflation(const scene::RobotModel& robot, double tolerance) {
  std::vector<Finding> findings;
  for (const scene::Collision& collision : robot.collisions)
    if (collision.deviation > tolerance)
      findings.push_back(
          {Severity::Warning, "pieces", robot.links[collision.link].name,
           collision.description + ": its convex pieces reach " + millimetres(collision.deviation) + " out of it.",
           "A smaller mesh_tolerance, more time for its pieces, or a simpler mesh."});
  return findings;
}

std::vector<Finding> findVisuals(const std::shared_ptr<const scene::SceneModel>& model, const scene::RobotModel& visual,
                                 double tolerance) {
  std::vector<Finding> findings;
  Probe probe(model);
  for (int link = 0; link < static_cast<int>(visual.links.size()); ++link) {
    if (!visual.hasGeometry(link)) continue;
    const std::string& name = visual.links[link].name;
    if (!model->robot.hasGeometry(link)) {
      // A small visual often shows where a frame is.
      findings.push_back({sizeOf(visual, link) > 2.0 * tolerance ? Severity::Warning : Severity::Note, "geometry", name,
                          "it has visual, but no collision geometry.",
                          "Nothing is checked against it, unless the parameter collision_from_visual names it."});
      continue;
    }
    if (model->robot.collisions[model->robot.links[link].collisions.front()].is_visual) {
      findings.push_back({Severity::Note, "geometry", name, "it has no collision geometry: its visual geometry counts.",
                          "The parameter collision_from_visual names it."});
      continue;
    }
    double farthest = -1.0;
    Vector3d at = Vector3d::Zero();
    for (const int piece : visual.piecesOf(link)) {
      for (const Vector3d& point : pointsOf(visual.pieces[piece])) {
        const double distance = probe.distance(link, point);
        if (distance <= farthest) continue;
        farthest = distance;
        at = visual.links[link].body_T_link.inverse() * point;
      }
    }
    if (farthest <= tolerance) continue;
    std::ostringstream where;
    where.precision(3);
    where << "(" << at.x() << ", " << at.y() << ", " << at.z() << ")";
    findings.push_back({Severity::Warning, "visual", name,
                        "its visual geometry reaches " + millimetres(farthest) + " out of its collision geometry, at " +
                            where.str() + " m in the frame of the link.",
                        "What is seen there is not checked: add collision geometry, or a padding."});
  }
  return findings;
}

std::string visualAsCollision(const std::string& urdf_xml) {
  tinyxml2::XMLDocument document;
  if (document.Parse(scene::withoutLateDeclarations(urdf_xml).c_str()) != tinyxml2::XML_SUCCESS)
    throw std::invalid_argument(std::string("URDF: ") + document.ErrorStr());
  tinyxml2::XMLElement* robot = document.FirstChildElement("robot");
  if (!robot) throw std::invalid_argument("URDF: no <robot> element");
  for (auto* link = robot->FirstChildElement("link"); link; link = link->NextSiblingElement("link")) {
    while (auto* collision = link->FirstChildElement("collision")) link->DeleteChild(collision);
    while (auto* visual = link->FirstChildElement("visual")) visual->SetName("collision");
  }
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

std::vector<Finding> findPairs(const scene::SceneModel& model, const PairStudy& study, const LevelShares& shares) {
  std::vector<Finding> findings;
  for (const PairEvidence& evidence : study.pairs)
    if (evidence.are_neighbours && entryOf(model, evidence).reason != scene::PairReason::Checked)
      findNeighbour(model, evidence, findings);
  const SrdfFaults faults = findSrdfFaults(model, study);
  for (const int i : faults.disabled_but_touch) {
    const PairEvidence& evidence = study.pairs[i];
    const bool touch = evidence.contact_depth < kTouch, in_doubt = touch || isInDoubt(model, evidence);
    const std::string& reason = entryOf(model, evidence).detail;
    findings.push_back(
        ofPair(in_doubt ? Severity::Note : Severity::Error, "srdf", model, evidence,
               "disabled" + (reason.empty() ? "" : " as \"" + reason + "\"") + ", but " + contactOf(model, evidence),
               touch      ? "They do no more than touch."
               : in_doubt ? "The pieces that stand for meshes may overlap where the meshes do not."
                          : "Nobody would report it: take the entry out, or say why in it: reason=\"User: ...\"."));
  }
  for (const int i : faults.disabled_by_decision)
    findings.push_back(ofPair(Severity::Note, "srdf", model, study.pairs[i],
                              "disabled by decision, as \"" + entryOf(model, study.pairs[i]).detail + "\", although " +
                                  contactOf(model, study.pairs[i]),
                              ""));
  for (const int i : faults.checked_but_always)
    findings.push_back(ofPair(Severity::Error, "srdf", model, study.pairs[i],
                              "checked, but in contact in every state that was tried: an alarm that never ends.",
                              "Disable the pair, or mend its geometry; `pair_audit --write` does the former."));
  for (const PairLevels& pair : shares.suspects()) {
    const PairEvidence& evidence = evidenceOf(pair.pair, study);
    if (!evidence.alwaysInContact())
      findings.push_back(ofPair(Severity::Warning, "srdf", model, evidence, "checked, but " + contactText(pair) + ".",
                                "Is it " + suspicionOf(pair) + "? Disabling it costs: " + costOfDisabling(pair, study) +
                                    ". " + disablingEntry(model.robot, pair)));
  }
  return findings;
}

std::vector<Finding> findPinchPoints(const scene::SceneModel& model, const PairStudy& study, double gap) {
  std::vector<Finding> findings;
  for (const PairEvidence& evidence : study.pairs) {
    if (evidence.are_neighbours || evidence.nearClass() != NearClass::Sometimes || evidence.closest.empty()) continue;
    const std::string closest = evidence.contact ? "they touch" : millimetres(evidence.smallest);
    findings.push_back(ofPair(Severity::Note, "pinch", model, evidence,
                              "their gap closes from more than " + millimetres(gap) + " until " + closest + ", at " +
                                  stateText(model.robot, evidence.pair, evidence.closest) + ".",
                              "A pair_stop_distance stops before; `pair_audit --safe-distance " + scene::shortest(gap) +
                                  "` looks for limits."));
  }
  return findings;
}

}  // namespace proximity_server::tools
