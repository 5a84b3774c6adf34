// Which pairs of a robot's links and objects cannot come into contact, whatever its joints do within their intervals.
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/proof/certify.h"
#include "proximity_server/scene/proof/free_box.h"
#include "proximity_server/scene/proof/prove_apart.h"
#include "system/whole_file.h"
#include "tools/program/options.h"
#include "tools/program/progress.h"
#include "tools/program/time_budget.h"
#include "tools/program/tool_main.h"
#include "tools/prove/certificate_check.h"
#include "tools/prove/certificate_file.h"
#include "tools/prove/proof_report.h"
#include "tools/robot/object_schedule.h"
#include "tools/robot/robot_files.h"
#include "tools/robot/robot_text.h"
#include "tools/states/csv_states.h"
#include "tools/text/naming.h"
#include "tools/text/output_file.h"

#include <algorithm>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::tools {
namespace {

enum class BoxSize : unsigned char { Given, Largest };
enum class ProofPairs : unsigned char { Checked, Disabled, All };

struct ProveArguments {
  RobotFiles robot;
  std::string objects, box, about, refuting, certificate, check;
  double radius = 0.0;
  BoxSize size = BoxSize::Given;
  ProofPairs pairs = ProofPairs::Checked;
  std::vector<std::string> only;
  TimeBudget budget;
  ProofFormat format = ProofFormat::Text;
  scene::ProofQuestion question;
};

void declareBox(ProgramOptions& program, ProveArguments& arguments) {
  program.addText(
      "--box", "FILE", arguments.box,
      "intervals of joints: YAML with JOINT: [lower, upper] or JOINT: position; all others have their limits "
      "(default: the limits of the URDF)");
  program.addText("--about", "\"JOINT=POSITION ...\"", arguments.about,
                  "all states that differ from this one by at most --radius in each joint, within the limits; the "
                  "joints that are not named are at 0");
  program
      .addRead(
          "--radius", "NUMBER", arguments.radius, [](const std::string& text) { return readLength(text, 0.0); },
          "in radians or metres")
      .needs = "--about";
  program["--about"].needs = "--radius";
  program
      .addFlag("--largest", arguments.size, BoxSize::Largest,
               "the largest box about the state, within --radius and to 1 %, in which all pairs are proven apart")
      .needs = "--about";
  program.atMostOneOf({"--box", "--about"});
}

void declare(ProgramOptions& program, ProveArguments& arguments) {
  scene::ProofQuestion& question = arguments.question;
  question.most_boxes = 100000;
  question.contact_distance = kContactDistance;
  program.addText("robot", "FILE", arguments.robot.urdf, "the URDF").is_required = true;
  program.addText("--srdf", "FILE", arguments.robot.srdf, "which pairs not to check");
  program.addText("--objects", "FILE", arguments.objects,
                  "what the robot holds and what stands around it: YAML, or a .scene of MoveIt");
  declareBox(program, arguments);
  addLength(
      program, "--clearance", question.contact_distance, 0.0,
      "how far apart the pairs have to stay (default: 1e-6: no contact, and faces that are flush are in contact)");
  program.addRead(
      "--pairs", "NAME", arguments.pairs,
      oneOf<ProofPairs>(
          {{"checked", ProofPairs::Checked}, {"disabled", ProofPairs::Disabled}, {"all", ProofPairs::All}}),
      "checked: those that the node checks; disabled: those that the SRDF disables; all: every pair of links "
      "with geometry that are not one body, and checked ones with objects (default: checked)");
  program
      .add("--only", "NAME", "only pairs with this link or object; if several are given, only pairs of these",
           [&](const std::string& text) { arguments.only.push_back(text); })
      .is_repeatable = true;
  program.addFlag("--shares", question.goal, scene::ProofQuestion::Goal::Shares,
                  "go on where contact was found, and tell in which share of the box the pairs are in contact");
  program.atMostOneOf({"--largest", "--shares"});
  addPositive(program, "--boxes", question.most_boxes, "most parts of the box that are examined for each pair");
  program.addRead(
      "--tightness", "NUMBER", question.tightness, [](const std::string& text) { return readLength(text, 0.0); },
      "from 0 to below 1: improve each bound until it has come this share of the way to the smallest distance that was "
      "found (default: 0: what is proven is enough)");
  addTimeBudget(program, arguments.budget,
                "end after this time with what is proven then, which depends on the computer");
  program.addRead("--format", "NAME", arguments.format,
                  oneOf<ProofFormat>({{"text", ProofFormat::Text}, {"json", ProofFormat::Json}}),
                  "text or json (default: text)");
  program.addOutput("--refuting", "FILE", arguments.refuting,
                    "write the states in which refuted pairs are in contact: CSV, for clearance --states");
  program.addOutput("--certificate", "FILE", arguments.certificate,
                    "write the evidence of all proven pairs, which --check verifies");
  program
      .addText("--check", "FILE", arguments.check,
               "prove nothing, and verify such evidence; the robot, the SRDF and the objects must be the same")
      .excludes = {"--box",   "--about",     "--clearance",   "--pairs",    "--only",       "--shares",
                   "--boxes", "--tightness", "--time-budget", "--refuting", "--certificate"};
  addRobotOptions(program, arguments.robot);
  addQuiet(program, arguments.robot.warnings);
  addThreads(program, question.threads);
  program.setFooter(
      "Exit codes: 0: all pairs are proven to stay apart, or the certificate is verified; 1: bad input, or memory,\n"
      "threads or disk did not suffice; 2: a pair is refuted or undecided, has no certificate, or one that is wrong;\n"
      "or the certificate has no pair.");
}

std::vector<double> radiiOf(const ProveArguments& arguments, const scene::RobotModel& robot) {
  return std::vector<double>(robot.joints.size(), arguments.radius);
}

scene::Positions stateOf(const ProveArguments& arguments, const scene::RobotModel& robot) {
  return readState("--about", arguments.about, robot, arguments.robot.warnings);
}

scene::JointBox boxOf(const ProveArguments& arguments, const scene::RobotModel& robot) {
  if (!arguments.about.empty())
    return naming("--about",
                  [&] { return scene::boxAbout(robot, stateOf(arguments, robot), radiiOf(arguments, robot)); });
  if (arguments.box.empty()) return scene::knownRanges(robot);
  return scene::jointBoxFrom(readTextFile(arguments.box), arguments.box, robot, scene::knownRanges(robot));
}

std::shared_ptr<const scene::Objects> objectsOf(const ProveArguments& arguments,
                                                const std::shared_ptr<const scene::SceneModel>& model) {
  const std::shared_ptr<ObjectSchedule> schedule = loadObjects(arguments.objects, arguments.robot, model);
  if (!schedule) return nullptr;
  if (!schedule->leftOver().empty())
    throw std::invalid_argument(arguments.objects + ": there are changes of objects, and a proof is about one set");
  return schedule->now();
}

bool isWanted(scene::PairReason reason, ProofPairs pairs) {
  switch (pairs) {
    case ProofPairs::Checked:
      return reason == scene::PairReason::Checked;
    case ProofPairs::Disabled:
      return reason == scene::PairReason::SrdfDisabled;
    case ProofPairs::All:
      break;
  }
  return reason != scene::PairReason::SameBody;
}

/// Throws std::invalid_argument for a name that is neither a link nor an object.
void requireNames(const std::vector<std::string>& names, const scene::RobotModel& robot,
                  const scene::Objects* objects) {
  for (const std::string& name : names)
    if (robot.findLink(name) < 0 && !(objects && objects->find(name) >= 0))
      throw std::invalid_argument("--only: there is no link or object " +
                                  scene::unknownName(name, scene::namesOf(robot.links)));
}

std::vector<scene::ShapeRefPair> pairsOf(const ProveArguments& arguments, const scene::SceneModel& model,
                                         const scene::Objects* objects) {
  requireNames(arguments.only, model.robot, objects);
  std::vector<scene::ShapeRefPair> pairs;
  const auto offer = [&](const scene::ShapeRef& a, const scene::ShapeRef& b) {
    const auto isNamed = [&](const scene::ShapeRef& ref) {
      return std::count(arguments.only.begin(), arguments.only.end(), nameOf(ref, model.robot, objects)) > 0;
    };
    const bool is_named = arguments.only.size() > 1 ? isNamed(a) && isNamed(b) : isNamed(a) || isNamed(b);
    if (arguments.only.empty() || is_named) pairs.push_back({a, b});
  };
  for (const scene::LinkPair& pair : model.pairs.pairs)
    if (isWanted(pair.reason, arguments.pairs)) offer(pair.link_a, pair.link_b);
  if (objects && arguments.pairs != ProofPairs::Disabled) objects->forEachCheckedPair(offer);
  return pairs;
}

/// Takes the largest free box in place of the given one.
void shrinkToFree(const ProveArguments& arguments, const std::vector<scene::ShapeRefPair>& pairs, ProofReport& report) {
  scene::FreeBoxQuestion question;
  question.proof = report.question;
  ProveArguments quiet = arguments;  // the warnings about the state were printed before
  quiet.robot.warnings = Warnings::Hidden;
  const scene::RobotModel& robot = report.model->robot;
  const scene::Positions state = stateOf(quiet, robot);
  scene::FreeBox free = scene::freeBox(report.model, pairs, state, radiiOf(arguments, robot), question);
  report.box =
      free.scale < 0.0 ? scene::boxAbout(robot, state, std::vector<double>(robot.joints.size(), 0.0)) : free.box;
  report.reach = std::max(0.0, free.scale) * arguments.radius;
  report.beyond = std::move(free.obstacles);
  report.question.deadline = {};
}

/// Writes the certificate of all proven pairs. Returns false if one of them has none.
bool certify(const ProofReport& report, const CertificateSubject& subject, const std::string& file) {
  ApartCertificate certificate{report.question.contact_distance, {}, {}};
  const auto certificates = scene::certify(report.model, report.proofs, report.question);
  bool is_complete = true;
  std::set<int> joints;
  for (std::size_t i = 0; i < certificates.size(); ++i) {
    if (certificates[i]) {
      certificate.pairs.push_back(*certificates[i]);
      for (const scene::JointRange& interval : report.proofs[i].box) joints.insert(interval.joint);
    } else if (report.proofs[i].outcome == scene::ProofOutcome::Proven) {
      std::cerr << "prove: " << file << ": there is no certificate of " << nameOf(report.proofs[i].pair, subject)
                << " within --boxes " << report.question.most_boxes << "\n";
      is_complete = false;
    }
  }
  for (const scene::JointRange& interval : report.box)
    if (joints.count(interval.joint) > 0) certificate.box.push_back(interval);
  system::replaceFile(file, certificateText(certificate, subject));
  return is_complete;
}

ExitCode run(const ProveArguments& arguments) {
  ProofReport report{loadSceneModel(arguments.robot), {}, arguments.question, {}};
  printWarningsOf(*report.model, arguments.robot.warnings);
  report.question.objects = objectsOf(arguments, report.model);
  const CertificateSubject subject{*report.model, report.question.objects.get(),
                                   arguments.objects.empty() ? "" : readTextFile(arguments.objects)};
  if (!arguments.check.empty())
    return checkCertificate(arguments.check, subject, arguments.format, report.question.threads);
  report.box = boxOf(arguments, report.model->robot);
  const std::vector<scene::ShapeRefPair> pairs = pairsOf(arguments, *report.model, report.question.objects.get());
  if (pairs.empty()) throw std::invalid_argument(arguments.robot.urdf + ": there is no pair to prove apart");
  TimeBudget budget = arguments.budget;
  budget.begin();
  report.question.deadline = budget.deadline;
  bool is_certified = true;
  {
    ProgressBar bar;
    report.question.progress = [&](double settled) { bar.show("volume settled", settled); };
    if (arguments.size == BoxSize::Largest) shrinkToFree(arguments, pairs, report);
    report.proofs = scene::proveApart(report.model, pairs, report.box, report.question);
    report.question.progress = [&](double share) { bar.show("certificates", share); };
    if (!arguments.certificate.empty()) is_certified = certify(report, subject, arguments.certificate);
  }
  const bool is_text = arguments.format == ProofFormat::Text;
  writeTo(std::cout, "standard output", is_text ? proofText(report) : proofJson(report));
  flushTo(std::cout, "standard output");
  if (!arguments.refuting.empty()) system::replaceFile(arguments.refuting, refutingStates(report));
  return report.isProven() && is_certified ? ExitCode::Done : ExitCode::AssertionFails;
}

}  // namespace
}  // namespace proximity_server::tools

int main(int argc, char** argv) {
  proximity_server::tools::ProgramOptions program(
      "prove", "Which pairs of links and objects stay apart in all states of a box of joint positions, with proof");
  proximity_server::tools::ProveArguments arguments;
  proximity_server::tools::declare(program, arguments);
  return proximity_server::tools::runTool(program, argc, argv, [&] { return proximity_server::tools::run(arguments); });
}
