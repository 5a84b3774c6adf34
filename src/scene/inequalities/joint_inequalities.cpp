#include "proximity_server/scene/inequalities/joint_inequalities.h"

#include "proximity_server/scene/mesh/readable_file.h"
#include "proximity_server/scene/model/names.h"
#include "scene/files/field.h"
#include "scene/inequalities/contradiction.h"
#include "scene/inequalities/inequality_text.h"

#include <fstream>
#include <iterator>
#include <stdexcept>
#include <utility>
#include <vector>

namespace proximity_server::scene {
namespace {

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
    for (const Field& entry : list.entries()) addTo(robot.inequalities, entry, robot);
    std::vector<std::string> texts;
    for (const int i : contradiction(robot)) texts.push_back("'" + robot.inequalities[i].text + "'");
    if (!texts.empty())
      list.refuse("no positions of the joints within their limits obey " + listed(texts) +
                  (texts.size() > 1 ? " together" : ""));
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
