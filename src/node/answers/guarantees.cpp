#include "node/answers/guarantees.h"

#include <cstdlib>

namespace proximity_server::node {
namespace {

constexpr char kCoarse[] = "guaranteed distances are coarse: ";
constexpr char kTimeOver[] = "their time was over after ";

}  // namespace

void appendEnd(std::string& text, const char* separator, const scene::GuaranteedDistances& distances) {
  if (distances.end() == scene::GuaranteeEnd::None) return;
  text += separator;
  text += kCoarse;
  if (distances.end() == scene::GuaranteeEnd::Steps) {
    text += "the steps of a cycle are too few";
    return;
  }
  text += kTimeOver;
  text += std::to_string(distances.steps());
  text += " steps";
}

std::string endIn(const std::string& text) {
  const std::size_t found = text.find(kCoarse);
  return found == std::string::npos ? "" : text.substr(found);
}

std::optional<std::int64_t> stepsOfTimeOver(const std::string& text) {
  const std::size_t found = text.find(kTimeOver);
  if (found == std::string::npos) return std::nullopt;
  return std::strtoll(text.c_str() + found + sizeof(kTimeOver) - 1, nullptr, 10);
}

}  // namespace proximity_server::node
