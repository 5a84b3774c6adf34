#include "proximity_server/scene/inequalities/joint_inequalities.h"

#include "proximity_server/scene/mesh/readable_file.h"
#include "proximity_server/scene/model/names.h"
#include "scene/files/field.h"
#include "scene/inequalities/contradiction.h"
#include "scene/inequalities/inequality_text.h"
#include "system/number_text.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

namespace proximity_server::scene {
namespace {

/// By how much the sum stays below its bound at least, whatever the positions within the limits of the joints are.
double leastSlack(const JointInequality& inequality, const RobotModel& robot) {
  double most = 0.0;
  for (const auto& [joint, coefficient] : inequality.terms)
    most += std::max(coefficient * robot.joints[joint].lower, coefficient * robot.joints[joint].upper);
  return inequality.bound - most;
}

void addTo(std::vector<JointInequality>& all, const Field& entry, const RobotModel& robot) {
  try {
    for (JointInequality& inequality : inequalitiesOf(entry.text(), robot)) all.push_back(std::move(inequality));
  } catch (const std::invalid_argument& error) {
    if (!entry.isText()) throw;
    entry.refuse("'" + entry.text() + "': " + error.what());
  }
}

}  // namespace

void setJointInequalities(const FileValue& value, const std::string& source, RobotModel& robot) {
  const Field file(value, source);
  if (file.isMap()) file.requireMembers({"joint_inequalities"});
  const Field list = file.isMap() ? file.member("joint_inequalities") : file;
  std::vector<JointInequality> before = std::exchange(robot.inequalities, {});
  try {
    std::vector<std::string> warnings;
    for (const Field& entry : list.entries()) {
      const auto first = static_cast<std::ptrdiff_t>(robot.inequalities.size());
      addTo(robot.inequalities, entry, robot);
      double slack = std::numeric_limits<double>::infinity();
      for (auto of_entry = robot.inequalities.begin() + first; of_entry != robot.inequalities.end(); ++of_entry)
        slack = std::min(slack, leastSlack(*of_entry, robot));
      if (!(slack > 0.0)) continue;
      std::string warning =
          "joint_inequalities: '" + entry.text() + "' is never broken: within the limits of its joints ";
      system::appendRounded(warning, slack, 3);
      warnings.push_back(warning + " are left at least. Degrees are written like 90deg.");
    }
    std::vector<std::string> texts;
    for (const int i : contradiction(robot)) texts.push_back("'" + robot.inequalities[i].text + "'");
    if (!texts.empty())
      list.refuse("no positions of the joints within their limits obey " + listed(texts) +
                  (texts.size() > 1 ? " together" : ""));
    robot.warnings.insert(robot.warnings.end(), warnings.begin(), warnings.end());
  } catch (const std::invalid_argument&) {
    robot.inequalities = std::move(before);
    throw;
  }
}

void readJointInequalities(const std::string& path, RobotModel& robot) {
  requireReadable(path);
  std::ifstream stream(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  setJointInequalities(readYaml(text, path), path, robot);
}

}  // namespace proximity_server::scene
