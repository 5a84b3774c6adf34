#include "tools/model_check/findings.h"

#include "proximity_server/scene/model/names.h"

#include <tinyxml2.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

int countOf(const std::vector<Finding>& findings, Severity severity) {
  return static_cast<int>(std::count_if(findings.begin(), findings.end(),
                                        [&](const Finding& finding) { return finding.severity == severity; }));
}

bool isNamed(const std::string& entry, const Finding& finding) {
  return entry == finding.check || entry == finding.check + ":" + finding.where;
}

std::string sentenceOf(const Finding& finding) {
  return finding.what + (finding.advice.empty() ? "" : " " + finding.advice);
}

}  // namespace

const char* toString(Severity severity) {
  switch (severity) {
    case Severity::Note:
      return "note";
    case Severity::Warning:
      return "warning";
    case Severity::Error:
      break;
  }
  return "error";
}

const std::vector<std::string>& checkNames() {
  static const std::vector<std::string> names{"xacro",  "loading", "limits",    "mimic", "geometry",
                                              "visual", "pieces",  "neighbour", "srdf",  "pinch"};
  return names;
}

void Accepted::add(const std::string& text) {
  const std::string check = text.substr(0, text.find(':'));
  if (std::count(checkNames().begin(), checkNames().end(), check) == 0)
    throw std::invalid_argument("there is no check " + scene::unknownName(check, checkNames()));
  entries_.push_back(text);
}

bool Accepted::contains(const Finding& finding) const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [&](const std::string& entry) { return isNamed(entry, finding); });
}

std::vector<std::string> Accepted::unused(const std::vector<Finding>& findings) const {
  std::vector<std::string> unused;
  for (const std::string& entry : entries_)
    if (std::none_of(findings.begin(), findings.end(), [&](const Finding& finding) { return isNamed(entry, finding); }))
      unused.push_back(entry);
  return unused;
}

std::string findingsText(const std::string& subject, const std::vector<Finding>& findings) {
  std::string text = subject + "\n";
  for (const std::string& check : checkNames())
    for (const Finding& finding : findings)
      if (finding.check == check)
        text += std::string(toString(finding.severity)) + ": " + check + ": " + finding.where + ": " +
                sentenceOf(finding) + "\n";
  const auto count = [&](Severity severity) { return std::to_string(countOf(findings, severity)); };
  return text + "errors: " + count(Severity::Error) + ", warnings: " + count(Severity::Warning) +
         ", notes: " + count(Severity::Note) + "\n";
}

std::string findingsJson(const std::string& subject, const std::vector<Finding>& findings) {
  using Json = nlohmann::ordered_json;
  Json json{{"subject", subject}, {"findings", Json::array()}};
  for (const Finding& finding : findings)
    json["findings"].push_back({{"severity", toString(finding.severity)},
                                {"check", finding.check},
                                {"where", finding.where},
                                {"what", finding.what},
                                {"advice", finding.advice}});
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string findingsJUnit(const std::vector<Finding>& findings, std::optional<Severity> failing) {
  tinyxml2::XMLPrinter printer;
  printer.PushHeader(/*writeBOM=*/false, /*writeDec=*/true);
  printer.OpenElement("testsuite");
  printer.PushAttribute("name", "model_check");
  printer.PushAttribute("tests", static_cast<int>(checkNames().size()));
  const auto fails = [&](const Finding& finding) { return failing && finding.severity >= *failing; };
  for (const std::string& check : checkNames()) {
    printer.OpenElement("testcase");
    printer.PushAttribute("classname", "model_check");
    printer.PushAttribute("name", check.c_str());
    for (const Finding& finding : findings) {
      if (finding.check != check) continue;
      printer.OpenElement(fails(finding) ? "failure" : "system-out");
      if (fails(finding)) printer.PushAttribute("message", (finding.where + ": " + finding.what).c_str());
      printer.PushText((finding.where + ": " + sentenceOf(finding)).c_str());
      printer.CloseElement();
    }
    printer.CloseElement();
  }
  printer.CloseElement();
  return printer.CStr();
}

}  // namespace proximity_server::tools
