#include "tools/command_line/joint_states.h"

#include <algorithm>
#include <ios>
#include <stdexcept>
#include <streambuf>
#include <utility>

#include "proximity_server/scene/model/names.h"
#include "tools/command_line/csv.h"

namespace proximity_server::tools {
namespace {

std::string inQuotes(const std::string& name) { return '"' + name + '"'; }

int findJoint(const scene::RobotModel& robot, const std::string& name) {
  const auto hit = std::find_if(robot.joints.begin(), robot.joints.end(),
                                [&](const scene::Joint& joint) { return joint.name == name; });
  return hit == robot.joints.end() ? -1 : static_cast<int>(hit - robot.joints.begin());
}

std::string suggestion(const scene::RobotModel& robot, const std::string& name) {
  std::vector<std::string> known;
  for (const scene::Joint& joint : robot.joints) known.push_back(joint.name);
  const std::string nearest = scene::nearestName(name, known);
  return nearest.empty() ? "" : " (did you mean " + inQuotes(nearest) + "?)";
}

bool isFixed(const scene::RobotModel& robot, const std::string& name) {
  return std::count(robot.fixed_joints.begin(), robot.fixed_joints.end(), name) > 0;
}

}  // namespace

JointStates::JointStates(std::istream& stream, std::string source, const scene::RobotModel& robot)
    : stream_(stream), source_(std::move(source)), robot_(robot), limits_(robot) {
  if (!nextFields()) throw std::invalid_argument(source_ + ": empty; expected a header of joint names");
  for (const std::string& name : fields_) addColumn(name);
}

bool JointStates::next(std::vector<double>& positions) {
  if (!nextFields()) return false;
  if (fields_.size() != columns_.size()) {
    fail(std::to_string(fields_.size()) + " numbers for " + std::to_string(columns_.size()) + " columns");
  }
  positions.assign(robot_.joints.size(), 0.0);
  limits_.beginState(line_);
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (columns_[i].joint == kTime) {
      time_ = number(i);
    } else {
      positions[columns_[i].joint] = number(i);
      limits_.add(columns_[i].joint, positions[columns_[i].joint]);
    }
  }
  return true;
}

bool JointStates::hasTimes() const {
  return std::any_of(columns_.begin(), columns_.end(), [](const Column& column) { return column.joint == kTime; });
}

/// Reads a line; false at the end. std::getline would use all memory for a file without line ends.
bool JointStates::nextLine(std::string& text) {
  using Letters = std::istream::traits_type;
  text.clear();
  if (!stream_.good()) return false;
  ++line_;
  try {
    std::streambuf& letters = *stream_.rdbuf();
    for (auto next = letters.sbumpc(); next != '\n'; next = letters.sbumpc()) {
      if (Letters::eq_int_type(next, Letters::eof())) {
        stream_.setstate(std::ios::eofbit);
        return !text.empty();
      }
      if (text.size() == kLongestLine) fail("longer than " + std::to_string(kLongestLine) + " characters");
      text += Letters::to_char_type(next);
    }
  } catch (const std::ios_base::failure&) {
    fail("reading failed");
  }
  return true;
}

/// Splits the next line that is not empty into fields; false at the end.
bool JointStates::nextFields() {
  std::string text;
  while (nextLine(text)) {
    if (line_ == 1 && text.compare(0, 3, "\xEF\xBB\xBF") == 0) text.erase(0, 3);  // byte order mark of spreadsheets
    if (text.find_first_not_of(" \t\r") == std::string::npos) continue;
    try {
      fields_ = csvFields(text);
    } catch (const std::invalid_argument& error) {
      fail(error.what());
    }
    return true;
  }
  return false;
}

void JointStates::addColumn(const std::string& name) {
  const auto hasName = [&](const Column& column) { return column.name == name; };
  if (std::any_of(columns_.begin(), columns_.end(), hasName)) fail("two columns are named " + inQuotes(name));
  columns_.push_back({name, jointOf(name)});
  if (columns_.back().joint == kTime) return;
  const scene::Joint& joint = robot_.joints[columns_.back().joint];
  if (joint.mimic) {
    warnings_.push_back(source_ + ": column " + inQuotes(name) + " is not used: the joint follows " +
                        inQuotes(robot_.joints[joint.mimic->joint].name) + ".");
  }
}

/// The joint of a column, or kTime.
int JointStates::jointOf(const std::string& name) const {
  const int joint = findJoint(robot_, name);
  if (joint < 0 && isFixed(robot_, name)) fail("column " + inQuotes(name) + ": a fixed joint has no position");
  if (joint < 0 && name == "time") return kTime;
  if (joint < 0) fail("column " + inQuotes(name) + ": no such joint" + suggestion(robot_, name));
  const scene::Joint::Type type = robot_.joints[joint].type;
  if (type == scene::Joint::Type::Floating || type == scene::Joint::Type::Planar) {
    fail("column " + inQuotes(name) + ": a floating or planar joint has more than one position");
  }
  return joint;
}

double JointStates::number(std::size_t column) const {
  const std::optional<double> value = finiteNumber(fields_[column]);
  if (!value) {
    fail("column " + inQuotes(columns_[column].name) + ": " + inQuotes(fields_[column]) + " is no finite number");
  }
  return *value;
}

std::string JointStates::place() const { return source_ + ", line " + std::to_string(line_); }

void JointStates::fail(const std::string& what) const { throw std::invalid_argument(place() + ": " + what); }

}  // namespace proximity_server::tools
