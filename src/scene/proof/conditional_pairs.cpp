#include "proximity_server/scene/proof/conditional_pairs.h"

#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/mesh/readable_file.h"
#include "proximity_server/scene/model/names.h"
#include "scene/files/field.h"
#include "scene/model/model_hash.h"
#include "scene/proof/pair_box.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

std::string intervalsText(const JointBox& box, const RobotModel& robot) {
  std::string text;
  for (const JointRange& interval : box)
    text += (text.empty() ? "" : ", ") + yamlName(robot.joints[interval.joint].name) + ": [" +
            shortest(interval.lower) + ", " + shortest(interval.upper) + "]";
  return text;
}

/// The pair of the table that a list of two links names.
LinkPair& pairIn(const Field& names, SceneModel& model) {
  const std::vector<std::string> links = names.texts();
  if (links.size() != 2) names.refuse("must name two links");
  for (const std::string& name : links)
    if (model.robot.findLink(name) < 0)
      names.refuse("there is no link " + unknownName(name, namesOf(model.robot.links)));
  const int found = model.pairs.find(model.robot.findLink(links[0]), model.robot.findLink(links[1]));
  if (found < 0) names.refuse("one of the two has no collision geometry");
  LinkPair& pair = model.pairs.pairs[found];
  if (!pair.proven.ranges.empty()) names.refuse("the pair is there twice");
  return pair;
}

PairBox boxOf(const LinkPair& pair, const RobotModel& robot, const JointBox& box, const Field& field) {
  try {
    return pairBox(robot, nullptr, {pair.link_a, pair.link_b}, box);
  } catch (const std::invalid_argument& error) {
    field.refuse(error.what());
  }
}

void addPair(const Field& entry, const std::string& source, SceneModel& model) {
  entry.requireMembers({"links", "distance", "ranges"});
  LinkPair& pair = pairIn(entry.member("links"), model);
  const Field distance = entry.member("distance");
  if (!(distance.number() > 0.0)) distance.refuse("must be above 0");
  pair.proven.distance = distance.number();
  const JointBox limits = knownRanges(model.robot);
  std::string detail;
  double lost = 0.0;
  for (const Field& range : entry.member("ranges").entries()) {
    const PairBox box = boxOf(pair, model.robot, jointBoxFrom(range.value(), source, model.robot, limits), range);
    pair.proven.ranges.push_back(box.joints);
    detail +=
        (detail.empty() ? "" : "; ") + intervalsText(jointBoxFrom(range.value(), source, model.robot, {}), model.robot);
    // A pose that agrees differs from the kinematics by kJointAgreement in translation and rotation of each joint. Twice
    // that is more than the rounding by which it is measured.
    lost = std::max(lost, 2.0 * kJointAgreement * (box.lever + static_cast<double>(model.robot.joints.size())));
  }
  pair.proven.distance -= lost;
  if (pair.reason == PairReason::Checked) pair.detail = "proven apart in this range: " + detail;
}

}  // namespace

std::string conditionalPairsYaml(const RobotModel& robot, const std::vector<ConditionalPair>& pairs) {
  std::string text = "model: \"" + modelHash(robot) + "\"\npairs:" + (pairs.empty() ? " []\n" : "\n");
  for (const ConditionalPair& conditional : pairs) {
    text += "- links: [" + yamlName(nameOf(conditional.pair.a, robot)) + ", " +
            yamlName(nameOf(conditional.pair.b, robot)) + "]\n  distance: " + shortest(conditional.distance) +
            "\n  ranges:\n";
    for (const JointBox& range : conditional.ranges) text += "  - {" + intervalsText(range, robot) + "}\n";
  }
  return text;
}

void addConditionalPairs(const std::string& yaml, const std::string& source, SceneModel& model) {
  const FileValue value = readYaml(yaml, source);
  const Field file(value, source);
  file.requireMembers({"model", "pairs"});
  const Field hash = file.member("model");
  if (const std::string own = modelHash(model.robot); hash.text() != own)
    hash.refuse("the proofs are those of the model " + hash.text() + ", and this robot is " + own +
                ": another geometry, padding, mesh tolerance or joint limit; make the file again by pair_audit");
  const Field pairs = file.member("pairs");
  for (const Field& entry : pairs.entries()) addPair(entry, source, model);
}

void readConditionalPairs(const std::string& path, SceneModel& model) {
  requireReadable(path);
  std::ifstream stream(path, std::ios::binary);
  const std::string yaml{std::istreambuf_iterator<char>(stream), {}};
  if (stream.bad()) throw std::invalid_argument(path + ": reading failed");
  addConditionalPairs(yaml, path, model);
}

}  // namespace proximity_server::scene
