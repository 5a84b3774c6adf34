#include "tools/prove/certificate_check.h"

#include "proximity_server/scene/certificate/verify.h"
#include "proximity_server/scene/model/names.h"
#include "system/pipeline.h"
#include "tools/robot/robot_files.h"
#include "tools/text/csv.h"
#include "tools/text/naming.h"
#include "tools/text/output_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <iostream>
#include <optional>
#include <vector>

namespace proximity_server::tools {
namespace {

using Flaws = std::vector<std::optional<std::string>>;

/// By pair, what is wrong with it.
Flaws flawsIn(const ApartCertificate& certificate, const CertificateSubject& subject, int threads) {
  Flaws flaws(certificate.pairs.size());
  std::size_t next = 0;
  const auto read = [&](std::size_t& pair) { return (pair = next++) < flaws.size(); };
  const auto work = [&](std::size_t& pair, int /*thread*/) {
    flaws[pair] = scene::flawIn(certificate.pairs[pair], certificate.box, subject.model, subject.objects);
  };
  system::runPipeline<std::size_t>({read, work}, {threads});
  return flaws;
}

std::size_t wrongIn(const Flaws& flaws) {
  return static_cast<std::size_t>(
      std::count_if(flaws.begin(), flaws.end(), [](const auto& flaw) { return flaw.has_value(); }));
}

/// The number of pairs that the node checks and the certificate does not have.
std::size_t leftOut(const ApartCertificate& certificate, const CertificateSubject& subject) {
  std::size_t count = 0;
  const auto see = [&](const scene::ShapeRef& a, const scene::ShapeRef& b) {
    count += std::none_of(certificate.pairs.begin(), certificate.pairs.end(), [&](const scene::PairCertificate& pair) {
      return pair.pair.isSameAs({a, b});
    });
  };
  for (const int index : subject.model.pairs.checked)
    see(subject.model.pairs.pairs[index].link_a, subject.model.pairs.pairs[index].link_b);
  if (subject.objects) subject.objects->forEachCheckedPair(see);
  return count;
}

/// The number of boxes of a tree, whose inner nodes have two children each.
std::size_t boxesOf(const scene::PairCertificate& pair) { return pair.tree.size() / 2 + 1; }

std::string textOf(const ApartCertificate& certificate, const Flaws& flaws, const CertificateSubject& subject) {
  const scene::RobotModel& robot = subject.model.robot;
  std::string text = "Robot " + scene::quoted(robot.name) + ": " + std::to_string(flaws.size()) +
                     " pairs with a certificate, in contact up to " + shortest(certificate.contact_distance) + " m.\n";
  for (const scene::JointRange& interval : certificate.box)
    text += "  " + robot.joints[interval.joint].name + " from " + shortest(interval.lower) + " to " +
            shortest(interval.upper) + "\n";
  std::string verified, wrong;
  for (std::size_t i = 0; i < flaws.size(); ++i) {
    const scene::PairCertificate& pair = certificate.pairs[i];
    const std::string name = "  " + nameOf(pair.pair, subject) + ": ";
    if (flaws[i])
      wrong += name + *flaws[i] + "\n";
    else
      verified += name + "at least " + shortest(pair.bound) + " m; boxes: " + std::to_string(boxesOf(pair)) + "\n";
  }
  const std::size_t count_wrong = wrongIn(flaws), left_out = leftOut(certificate, subject);
  text += "\nverified (" + std::to_string(flaws.size() - count_wrong) + ")\n" + verified;
  text += "\nnot verified (" + std::to_string(count_wrong) + ")\n" + wrong + "\n";
  if (left_out > 0) text += std::to_string(left_out) + " pairs that are checked have no certificate\n";
  if (flaws.empty()) return text + "nothing is verified: the certificate has no pair\n";
  return text + (count_wrong > 0 ? "the certificate is wrong\n"
                                 : "verified: no pair of the certificate comes into contact in the box\n");
}

std::string jsonOf(const ApartCertificate& certificate, const Flaws& flaws, const CertificateSubject& subject) {
  const scene::RobotModel& robot = subject.model.robot;
  nlohmann::ordered_json json{{"robot", robot.name}, {"contact_distance", certificate.contact_distance}};
  json["box"] = boxJson(certificate.box, robot);
  json["verified"] = flaws.size() - wrongIn(flaws);
  json["wrong"] = wrongIn(flaws);
  json["without_certificate"] = leftOut(certificate, subject);
  json["pairs"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < flaws.size(); ++i) {
    const scene::PairCertificate& pair = certificate.pairs[i];
    nlohmann::ordered_json row{{"a", nameOf(pair.pair.a, robot, subject.objects)},
                               {"b", nameOf(pair.pair.b, robot, subject.objects)}};
    row["bound"] = pair.bound;
    row["boxes"] = boxesOf(pair);
    row["flaw"] = flaws[i] ? nlohmann::ordered_json(*flaws[i]) : nlohmann::ordered_json();
    json["pairs"].push_back(std::move(row));
  }
  return jsonText(json);
}

}  // namespace

ExitCode checkCertificate(const std::string& path, const CertificateSubject& subject, ProofFormat format, int threads) {
  const ApartCertificate certificate = naming(path, [&] { return readCertificate(readTextFile(path), subject); });
  const Flaws flaws = flawsIn(certificate, subject, threads);
  const auto report = format == ProofFormat::Text ? textOf : jsonOf;
  writeTo(std::cout, "standard output", report(certificate, flaws, subject));
  flushTo(std::cout, "standard output");
  return flaws.empty() || wrongIn(flaws) > 0 ? ExitCode::AssertionFails : ExitCode::Done;
}

}  // namespace proximity_server::tools
