#include "node/robot/tf_frames.h"

#include <algorithm>
#include <cstddef>

namespace proximity_server::node {
namespace {

constexpr std::size_t kMaxNamedFrames = 3;  // a hint names no more frames than this

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// The frames of a link with any prefix or without one, sorted by name.
std::vector<std::string> framesOf(const std::string& link, const std::vector<std::string>& frames) {
  std::vector<std::string> result;
  for (const std::string& frame : frames) {
    if (frame == link || endsWith(frame, "/" + link)) result.push_back(frame);
  }
  std::sort(result.begin(), result.end());
  if (result.size() > kMaxNamedFrames) result.resize(kMaxNamedFrames);
  return result;
}

std::string joined(const std::vector<std::string>& words, const std::string& between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

std::string hintOf(const RobotSource& robot, const std::string& link, const std::vector<std::string>& frames) {
  const std::string exist = (frames.size() == 1 ? "frame " : "frames ") + joined(frames, " and ") +
                            (frames.size() == 1 ? " exists" : " exist");
  if (!robot.tf_prefix.empty()) return exist + ", but " + robot.prefixParameter() + " is '" + robot.tf_prefix + "'";
  std::vector<std::string> prefixes;
  for (const std::string& frame : frames)
    prefixes.push_back("'" + frame.substr(0, frame.size() - link.size() - 1) + "'");
  return exist + ": set " + robot.prefixParameter() + " to " + joined(prefixes, " or ");
}

}  // namespace

std::string tfFrame(const std::string& prefix, const std::string& link) {
  if (prefix.empty()) return link;
  return (prefix.front() == '/' ? prefix.substr(1) : prefix) + "/" + link;
}

std::string prefixHint(const tf2::BufferCore& buffer, const RobotSource& robot, const std::vector<std::string>& links) {
  std::vector<std::string> known;
  buffer._getFrameStrings(known);
  for (const std::string& link : links) {
    if (std::count(known.begin(), known.end(), tfFrame(robot.tf_prefix, link)) > 0) continue;
    const std::vector<std::string> frames = framesOf(link, known);
    if (!frames.empty()) return hintOf(robot, link, frames);
  }
  return {};
}

}  // namespace proximity_server::node
