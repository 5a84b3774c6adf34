#include "tools/command_line/state_text.h"

#include "tools/command_line/csv.h"

namespace proximity_server::tools {

std::string stateText(const scene::RobotModel& robot, const scene::ShapeRefPair& pair,
                      const scene::Positions& positions) {
  std::string text;
  for (const scene::JointRange& range :
       scene::rangesBetween(robot, scene::jointRanges(robot), pair.a.link(), pair.b.link())) {
    text += (text.empty() ? "" : " ") + robot.joints[range.joint].name + "=" + numberText(positions[range.joint]);
  }
  return text;
}

}  // namespace proximity_server::tools
