#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// Note: may be by design. Warning: something is not checked, or not as it seems. Error: a collision that nobody would
/// report, an alarm that never ends, or a file that was not finished.
enum class Severity : unsigned char { Note, Warning, Error };
const char* toString(Severity severity);

/// A fault of a URDF or an SRDF.
struct Finding {
  Severity severity;
  std::string check;   ///< one of checkNames()
  std::string where;   ///< names of links or joints, or the file and the line
  std::string what;    ///< what is the case, with numbers
  std::string advice;  ///< what to do; "" if `what` says it
};

/// The names of all checks, in the order of the report.
const std::vector<std::string>& checkNames();

/// The values of --accept: the name of a check, or with a place only its findings there, "visual:left_hand".
class Accepted {
 public:
  /// Throws std::invalid_argument, with the nearest name, for a check that does not exist.
  void add(const std::string& text);
  bool contains(const Finding& finding) const;
  /// The entries for which there was no finding.
  std::vector<std::string> unused(const std::vector<Finding>& findings) const;

 private:
  std::vector<std::string> entries_;
};

/// The findings for people, by check, and for programs: JSON, and an XML of JUnit with a test case for each check. It
/// fails if a finding is not below `failing`.
std::string findingsText(const std::string& subject, const std::vector<Finding>& findings);
std::string findingsJson(const std::string& subject, const std::vector<Finding>& findings);
std::string findingsJUnit(const std::vector<Finding>& findings, std::optional<Severity> failing);

}  // namespace proximity_server::tools
