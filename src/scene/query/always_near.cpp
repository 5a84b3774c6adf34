#include "proximity_server/scene/query/always_near.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <set>
#include <utility>

namespace proximity_server::scene {
namespace {

constexpr double kSure = 0.002;  // [m] below it the distance of two links of a real robot says nothing
constexpr double kSame = 5e-5;   // [m] distances that differ by less are written as one

/// The largest number with two digits that is not above a length; 0 for 0.
double roundedDown(double length) {
  if (!(length > 0.0)) return 0.0;
  // Divided by a power of ten, the result is the number that its decimals stand for. 0.02 must not become 0.019.
  const double per_metre = std::pow(10.0, 1.0 - std::floor(std::log10(length)));
  return std::floor(length * per_metre * (1.0 + 1e-12)) / per_metre;
}

/// Without an exponent: the YAML of rosparam reads 1e-05 as a text.
std::string numberText(double number) {
  std::array<char, 400> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed).ptr};
}

/// A length in mm with three digits.
std::string millimetres(double length) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g mm", 1e3 * length);
  return text.data();
}

}  // namespace

std::string yamlName(const std::string& name) {
  static const std::set<std::string> words{"y", "n", "yes", "no", "on", "off", "true", "false", "null"};
  static const std::string letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_";
  std::string lower = name, escaped;
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  for (const char c : name) escaped += (c == '"' || c == '\\' ? "\\" : "") + std::string(1, c);
  const bool is_plain = !name.empty() && letters.find(name[0]) != std::string::npos &&
                        name.find_first_not_of(letters + "0123456789.-/") == std::string::npos && !words.count(lower);
  return is_plain ? name : "\"" + escaped + "\"";
}

StopAndWarn fittingThresholds(const AlwaysNear& pair, const StopAndWarn& usual) {
  const double reference = pair.smallest > kSure ? pair.smallest : std::max(pair.smallest, 0.5 * pair.largest);
  return {roundedDown(std::min(usual.stop, 0.5 * reference)), roundedDown(std::min(usual.warn, 0.75 * reference))};
}

std::string distancesText(const AlwaysNear& pair) {
  if (pair.smallest > 0.0 && pair.largest - pair.smallest < kSame) return "stays at " + millimetres(pair.smallest);
  const std::string smallest = pair.smallest > 0.0 ? millimetres(pair.smallest) : "contact";
  return "has " + smallest + " to " + millimetres(pair.largest);
}

std::string thresholdEntry(const RobotModel& robot, const ShapeRefPair& pair, double distance) {
  return "{links: [" + yamlName(robot.links[pair.a.link].name) + ", " + yamlName(robot.links[pair.b.link].name) +
         "], distance: " + numberText(distance) + "}";
}

std::string thresholdsYaml(const RobotModel& robot, const std::vector<AlwaysNear>& pairs, const StopAndWarn& usual) {
  std::string text;
  for (const auto& [name, threshold] :
       {std::pair("pair_stop_distance", &StopAndWarn::stop), std::pair("pair_warn_distance", &StopAndWarn::warn)}) {
    text += name + std::string(pairs.empty() ? ": []\n" : ":\n");
    for (const AlwaysNear& pair : pairs) {
      text += "- " + thresholdEntry(robot, pair.pair, fittingThresholds(pair, usual).*threshold) + "  # " +
              distancesText(pair) + "\n";
    }
  }
  return text;
}

}  // namespace proximity_server::scene
