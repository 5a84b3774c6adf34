#include "proximity_server/scene/filter/pair_filter.h"

#include "scene/filter/link_table.h"
#include "scene/filter/srdf.h"
#include "scene/filter/srdf_group.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <tuple>

namespace proximity_server::scene {
namespace {

/// Reads the SRDF of one robot. The errors name the robot.
Srdf readSrdfOf(const Member& robot, const std::string& srdf_xml) {
  try {
    return readSrdf(srdf_xml);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(robot.sentence(error.what()));
  }
}

/// Reads all SRDFs into one, with the names of the model.
Srdf readSrdfs(const RobotModel& model, const std::vector<std::string>& srdf_xmls, PairTable& table) {
  if (srdf_xmls.size() != model.robots.size()) {
    throw std::invalid_argument("there are " + std::to_string(srdf_xmls.size()) + " SRDFs for " +
                                std::to_string(model.robots.size()) + " robots");
  }
  Srdf all;
  for (std::size_t i = 0; i < srdf_xmls.size(); ++i) {
    const Member& robot = model.robots[i];
    Srdf srdf = readSrdfOf(robot, srdf_xmls[i]);
    if (!srdf.robot.empty() && srdf.robot != robot.urdf_name) {
      table.warnings.push_back(robot.sentence("The SRDF is for the robot " + quoted(srdf.robot) + ", the URDF is of " +
                                              quoted(robot.urdf_name) + "."));
    }
    renameAll(srdf, [&](const std::string& own) { return robot.nameInModel(own); });
    append(srdf, all);
  }
  return all;
}

/// The rules of SRDF and configuration, by index of link and body.
struct Rules {
  bool only_listed = false;
  std::set<OrderedPair> only, excluded, enabled;
  std::map<OrderedPair, std::string> disabled;  // with the SRDF's reason
  std::set<int> disabled_by_default;            // indices of links
  std::vector<bool> moved;                      // index: the body; empty if no group was chosen
};

std::set<OrderedPair> readConfigPairs(const std::string& list, const std::vector<PairFilterOptions::Names>& entries,
                                      const LinkTable& links, PairTable& table) {
  std::set<OrderedPair> pairs;
  PairListReader reader(list, links);
  for (const auto& names : entries) pairs.insert(reader.require(names));
  reader.report(table);
  return pairs;
}

void readDisabled(const Srdf& srdf, const LinkTable& links, Rules& rules, PairTable& table) {
  PairListReader reader("disable_collisions", links);
  for (const Srdf::DisabledPair& entry : srdf.disable_collisions) {
    if (const auto pair = reader.find(entry.links)) rules.disabled.emplace(*pair, entry.reason);
  }
  reader.report(table);

  std::vector<std::string> unknown;
  for (const std::string& name : srdf.disable_default_collisions) {
    const int link = links.find(name);
    if (link < 0) unknown.push_back(unknown.size() < kMaxListed ? links.unknown(name) : name);
    rules.disabled_by_default.insert(link);
  }
  if (!unknown.empty()) table.warnings.push_back("disable_default_collisions: no link " + listed(unknown) + ".");
}

/// True only for two links of one robot, because an SRDF is about its own robot alone.
bool disabledByDefault(const OrderedPair& pair, const LinkTable& links, const Rules& rules) {
  if (!links.sameRobot(pair)) return false;
  return rules.disabled_by_default.count(pair.link_a) || rules.disabled_by_default.count(pair.link_b);
}

void readEnabled(const Srdf& srdf, const LinkTable& links, Rules& rules, PairTable& table) {
  std::vector<std::string> contradictory, needless;
  PairListReader reader("enable_collisions", links);
  for (const Srdf::Names& names : srdf.enable_collisions) {
    const auto pair = reader.find(names);
    if (!pair || !rules.enabled.insert(*pair).second) continue;
    if (rules.disabled.count(*pair)) {
      contradictory.push_back(links.names(*pair));
    } else if (!disabledByDefault(*pair, links, rules) && !links.adjacent(*pair) && !links.sameBody(*pair)) {
      needless.push_back(links.names(*pair));
    }
  }
  reader.report(table);
  if (!contradictory.empty()) {
    table.warnings.push_back("enable_collisions yields to disable_collisions for " + listed(contradictory) + ".");
  }
  if (!needless.empty()) {
    table.warnings.push_back("enable_collisions names pairs that are checked anyway: " + listed(needless) + ".");
  }
}

Rules readRules(const RobotModel& model, const LinkTable& links, const Srdf& srdf, const PairFilterOptions& options,
                PairTable& table) {
  Rules rules;
  rules.only_listed = !options.only_pairs.empty();
  rules.only = readConfigPairs("only_pairs", options.only_pairs, links, table);
  rules.excluded = readConfigPairs("exclude_pairs", options.exclude_pairs, links, table);
  readDisabled(srdf, links, rules, table);
  readEnabled(srdf, links, rules, table);
  if (!options.group.empty()) rules.moved = bodiesMovedByGroup(model, links, srdf, options.group, table.warnings);
  return rules;
}

PairReason reasonFor(const OrderedPair& pair, const LinkTable& links, const Rules& rules) {
  const bool enabled = rules.enabled.count(pair) > 0;
  if (links.sameBody(pair)) return PairReason::SameBody;
  if (rules.only_listed && !rules.only.count(pair)) return PairReason::NotInOnlyPairs;
  if (rules.excluded.count(pair)) return PairReason::ConfigExcluded;
  if (rules.disabled.count(pair)) return PairReason::SrdfDisabled;
  if (disabledByDefault(pair, links, rules) && !enabled) return PairReason::SrdfDisabled;
  if (links.adjacent(pair) && !rules.only.count(pair) && !enabled) return PairReason::Adjacent;
  if (!rules.moved.empty() && !rules.moved[links.body(pair.link_a)] && !rules.moved[links.body(pair.link_b)]) {
    return PairReason::NotInGroup;
  }
  return PairReason::Checked;
}

std::string detailFor(const OrderedPair& pair, const Rules& rules) {
  const auto disabled = rules.disabled.find(pair);
  return disabled == rules.disabled.end() ? "" : disabled->second;
}

void addPadding(const PairFilterOptions& options, const LinkTable& links, PairTable& table) {
  PairListReader reader("pair_padding", links);
  for (const auto& [names, padding] : options.pair_padding) {
    const OrderedPair pair = reader.require(names);
    if (!std::isfinite(padding)) {
      throw std::invalid_argument("pair_padding: the padding of " + links.names(pair) + " is not finite");
    }
    if (const int index = table.find(pair.link_a, pair.link_b); index >= 0) table.pairs[index].padding = padding;
  }
  reader.report(table);
}

/// Warnings about the result that a user should know.
void audit(const LinkTable& links, PairTable& table) {
  std::vector<std::string> silent, nearly_adjacent;  // all are named, so that nobody has to guess
  for (const LinkPair& entry : table.pairs) {
    const OrderedPair pair(entry.link_a, entry.link_b);
    if (entry.reason == PairReason::Adjacent) silent.push_back(links.names(pair));
    if (entry.reason == PairReason::Checked && links.adjacentButForEmptyLinks(pair)) {
      nearly_adjacent.push_back(links.names(pair));
    }
  }
  addPairsWarning("Not checked, as neighbours, although no disable_collisions names them", silent, table);
  addPairsWarning("Checked, but only links without geometry are between them, so they may always touch",
                  nearly_adjacent, table);
  if (table.checked.empty()) table.warnings.push_back("No pair of links is checked.");
}

}  // namespace

const char* toString(PairReason reason) {
  switch (reason) {
    case PairReason::Checked:
      return "checked";
    case PairReason::SameBody:
      return "same body";
    case PairReason::NotInOnlyPairs:
      return "not in only_pairs";
    case PairReason::ConfigExcluded:
      return "in exclude_pairs";
    case PairReason::SrdfDisabled:
      return "disabled in the SRDF";
    case PairReason::Adjacent:
      return "adjacent";
    case PairReason::NotInGroup:
      return "not in the group";
    case PairReason::NoGeometry:
      return "no collision geometry";
    case PairReason::BothStatic:
      return "both stand still";
    case PairReason::TouchLink:
      return "touch link of the attached object";
    case PairReason::Allowed:
      return "allowed";
    case PairReason::FreeObjects:
      return "objects that are not attached";
    case PairReason::BothHalfSpaces:
      return "two half-spaces";
  }
  return "unknown";
}

const char* toString(IdleEntry::Cause cause) {
  switch (cause) {
    case IdleEntry::Cause::UnknownLink:
      return "name a link that does not exist";
    case IdleEntry::Cause::NoGeometry:
      return "a link without collision geometry";
    case IdleEntry::Cause::SameBody:
      return "two links of one rigid body";
    case IdleEntry::Cause::Repeated:
      return "a pair for the second time";
  }
  return "unknown";
}

int PairTable::find(int link_a, int link_b) const {
  const OrderedPair wanted(link_a, link_b);
  const auto hit = std::lower_bound(
      pairs.begin(), pairs.end(), wanted,
      [](const LinkPair& pair, const OrderedPair& key) { return OrderedPair(pair.link_a, pair.link_b) < key; });
  const bool found = hit != pairs.end() && hit->link_a == wanted.link_a && hit->link_b == wanted.link_b;
  return found ? static_cast<int>(hit - pairs.begin()) : -1;
}

std::vector<bool> bodiesMovedBy(const RobotModel& model, const std::vector<std::string>& srdf_xmls,
                                const std::string& group, const std::string& named_by) try {
  PairTable ignored;  // filterPairs() gives the same warnings
  const Srdf srdf = readSrdfs(model, srdf_xmls, ignored);
  return bodiesMovedByGroup(model, LinkTable(model), srdf, group, ignored.warnings);
} catch (const std::invalid_argument& error) {
  throw std::invalid_argument(named_by + ": " + error.what());
}

PairTable filterPairs(const RobotModel& model, const std::string& srdf_xml, const PairFilterOptions& options) {
  return filterPairs(model, std::vector<std::string>{srdf_xml}, options);
}

PairTable filterPairs(const RobotModel& model, const std::vector<std::string>& srdf_xmls,
                      const PairFilterOptions& options) {
  const LinkTable links(model);
  PairTable table;
  const Srdf srdf = readSrdfs(model, srdf_xmls, table);
  const Rules rules = readRules(model, links, srdf, options, table);
  for (int a = 0; a < links.size(); ++a) {
    for (int b = a + 1; b < links.size(); ++b) {
      if (!links.hasGeometry(a) || !links.hasGeometry(b)) continue;
      const OrderedPair pair(a, b);
      const PairReason reason = reasonFor(pair, links, rules);
      if (reason == PairReason::Checked) table.checked.push_back(static_cast<int>(table.pairs.size()));
      table.pairs.push_back({a, b, reason, detailFor(pair, rules)});
    }
  }
  addPadding(options, links, table);
  audit(links, table);
  return table;
}

}  // namespace proximity_server::scene
