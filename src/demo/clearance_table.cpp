// Shows the topic `clearance` in the terminal: a table that is redrawn in place, or one line per second if the output
// is not a terminal.
#include <proximity_server/Clearance.h>
#include "node/robot/level_name.h"
#include "system/version.h"

#include <ros/ros.h>
#include <rosgraph_msgs/Log.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>

namespace {

using proximity_server::Clearance;
using proximity_server::levelName;
using proximity_server::levelOfThreshold;
using proximity_server::Proximity;

constexpr std::size_t kRows = 8;  // the table lists at most this many pairs below the threshold
constexpr std::size_t kUnlimited = std::numeric_limits<std::size_t>::max();

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  char line[256];
  std::snprintf(line, sizeof line, pattern, values...);
  return line;
}

/// The terminal escape sequence that starts the colour of a level.
const char* colourOf(std::uint8_t level) {
  switch (level) {
    case Clearance::CLEAR:
      return "\033[1;32m";
    case Clearance::WARN:
      return "\033[1;33m";
    case Clearance::STOP:
      return "\033[1;31m";
    case Clearance::COLLISION:
      return "\033[1;37;41m";
    default:
      return "\033[1;35m";
  }
}

/// The number of columns of the terminal; 100 if it is not known.
std::size_t columnsOfTerminal() {
  winsize size{};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 100;
}

/// Returns whether the byte continues a character of UTF-8.
bool continues(char byte) { return (static_cast<unsigned char>(byte) & 0xC0u) == 0x80u; }

/// The number of columns of a text that has no escape sequences.
std::size_t columns(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char byte) { return !continues(byte); }));
}

/// The index of the byte at which this column of a text begins.
std::size_t byteOf(const std::string& text, std::size_t column) {
  std::size_t byte = 0;
  for (; byte < text.size(); ++byte)
    if (!continues(text[byte]) && column-- == 0) break;
  return byte;
}

constexpr std::size_t kDots = 3;  // [columns] of "..."

/// Cuts a text at its end to this many columns. A line must fit into the terminal: the table is redrawn by counting
/// lines, which fails if the terminal breaks one.
std::string clipped(const std::string& text, std::size_t width) {
  if (columns(text) <= width) return text;
  return text.substr(0, byteOf(text, width - std::min(width, kDots))) + std::string(std::min(width, kDots), '.');
}

/// Cuts a name in its middle, because names of one robot mostly differ at their ends ("left_...", "..._finger_tip").
std::string shortened(const std::string& name, std::size_t width) {
  if (columns(name) <= width) return name;
  const std::size_t kept = width - std::min(width, kDots), front = kept / 2;
  return name.substr(0, byteOf(name, front)) + "..." + name.substr(byteOf(name, columns(name) - (kept - front)));
}

/// The names of a pair in this many columns. If one name is short, the other one gets the columns that are left.
std::string names(const Proximity& pair, std::size_t width) {
  const std::string between = " - ";
  const std::string &a = pair.a.link, &b = pair.b.link;
  if (columns(a) + columns(b) + between.size() <= width) return a + between + b;
  constexpr std::size_t kMinNameColumns = 2 + kDots;
  const std::size_t both = std::max(width, 2 * kMinNameColumns + between.size()) - between.size(), half = both / 2;
  const std::size_t of_a = std::max(std::min(columns(a), half), both - std::min(columns(b), both - half));
  return shortened(a, of_a) + between + shortened(b, both - std::min(columns(a), of_a));
}

/// The distance and the names of a pair in this many columns.
std::string pairLine(const Proximity& pair, std::size_t width = kUnlimited) {
  const std::string distance = format("%+9.4f m  ", pair.distance);
  return distance + names(pair, width - std::min(width, distance.size()));
}

std::string firstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

/// The pair that sets the level. Its threshold follows if there is enough room for the names.
std::string decidingLine(const Clearance& clearance, std::size_t width = kUnlimited) {
  if (clearance.level == Clearance::INVALID) return clipped(firstLine(clearance.status.message), width);
  if (clearance.level == Clearance::COLLISION) return pairLine(clearance.deciding, width);
  const std::string guaranteed =
      clearance.by_guaranteed ? format("guaranteed %.4f m, ", clearance.deciding.guaranteed) : "";
  const std::string threshold =
      format(" (%s%s at %.4f m)", guaranteed.c_str(), levelOfThreshold(clearance.level), clearance.deciding_threshold);
  constexpr std::size_t kMinPairColumns = 40;
  if (width < kMinPairColumns + threshold.size()) return pairLine(clearance.deciding, width);
  return pairLine(clearance.deciding, width - threshold.size()) + threshold;
}

std::string settledLine(const Clearance& clearance) {
  const unsigned checked = clearance.pairs_total - clearance.pairs_filtered;
  return format("%u pairs: %u at rest, %u by motion, %u by bounds, %u computed, %u unknown", checked,
                clearance.pairs_at_rest, clearance.pairs_by_motion, clearance.pairs_by_bounds, clearance.pairs_computed,
                clearance.pairs_unknown);
}

std::string timeLine(const Clearance& clearance) {
  return format("cycle %.2f ms, tf age %.0f ms", 1e3 * clearance.computation_time.toSec(),
                1e3 * clearance.tf_age.toSec());
}

/// The closest pair of links and the closest pair with an object, each between `before` and `after`, in this many
/// columns. Returns "" if no pair with an object is checked.
std::string kindLines(const Clearance& clearance, const std::string& before, const std::string& after,
                      std::size_t width = kUnlimited) {
  if (clearance.object_minimum.a.link.empty()) return "";
  const auto kind_line = [&](const std::string& name, const Proximity& pair) {
    return before + name + pairLine(pair, width - std::min(width, before.size() + name.size())) + after;
  };
  const bool has_links = !clearance.self_minimum.a.link.empty();
  return (has_links ? kind_line("links    ", clearance.self_minimum) : "") +
         kind_line("objects  ", clearance.object_minimum);
}

std::string line(const Clearance& clearance) {
  return format("%-9s", levelName(clearance.level)) + " " + decidingLine(clearance) + kindLines(clearance, " | ", "") +
         " | " + settledLine(clearance) + " | " + timeLine(clearance) + "\n";
}

/// The table about a clearance. No line is longer than this many columns.
std::string table(const Clearance& clearance, std::size_t width) {
  const std::string level = format(" %-9s ", levelName(clearance.level)), margin = "  ";
  const std::size_t beside_level = width - std::min(width, level.size() + 2 * margin.size());
  std::string text = margin + colourOf(clearance.level) + level + "\033[0m" + margin +
                     decidingLine(clearance, beside_level) + "\n\n" + kindLines(clearance, margin, "\n", width) +
                     clipped("  checked  " + settledLine(clearance), width) + "\n" +
                     clipped("  timing   " + timeLine(clearance), width) + "\n\n";
  const std::size_t rows = std::min(kRows, clearance.below_threshold.size());
  for (std::size_t i = 0; i < rows; ++i) {
    const std::string suffix = margin + levelName(clearance.levels[i]);
    text += margin + pairLine(clearance.below_threshold[i], width - std::min(width, margin.size() + suffix.size())) +
            suffix + "\n";
  }
  if (clearance.pairs_below_threshold > rows) {
    text += format("             and %u more below the threshold\n",
                   clearance.pairs_below_threshold - static_cast<unsigned>(rows));
  }
  return text;
}

/// The name of the node that has this private topic.
std::string nodeOf(const std::string& topic) { return topic.substr(0, topic.find_last_of('/')); }

/// Names another topic on which a node publishes a clearance: "; there is one on /cell/clearance:
/// clearance:=/cell/clearance". "" if there is none.
std::string elsewhere(const std::string& topic) {
  ros::master::V_TopicInfo topics;
  ros::master::getTopics(topics);
  for (const ros::master::TopicInfo& other : topics)
    if (other.datatype == ros::message_traits::datatype<Clearance>() && other.name != topic)
      return "; there is one on " + other.name + ": clearance:=" + other.name;
  return {};
}

class Display {
 public:
  explicit Display(ros::NodeHandle& nh)
      : subscriber_(nh.subscribe("clearance", 1, &Display::onClearance, this)),
        log_subscriber_(nh.subscribe("/rosout", 100, &Display::onLog, this)),
        timer_(nh.createWallTimer(ros::WallDuration(is_terminal_ ? 0.1 : 1.0), &Display::onTimer, this)) {}

 private:
  void onClearance(const Clearance::ConstPtr& clearance) {
    clearance_ = clearance;
    arrival_ = ros::WallTime::now();
  }

  /// Keeps the node's last log message. It is shown as long as no clearance arrives, for example while the node loads.
  void onLog(const rosgraph_msgs::Log::ConstPtr& log) {
    constexpr std::size_t kLongest = 63;  // [columns], so that it fits into a line of its own
    if (log->name == nodeOf(subscriber_.getTopic())) last_message_ = clipped(firstLine(log->msg), kLongest);
  }

  void onTimer(const ros::WallTimerEvent&) { show(text()); }

  std::string text() const {
    const double silence = (ros::WallTime::now() - arrival_).toSec();
    if (!clearance_ || silence > 1.0) {
      const std::string message =
          last_message_.empty() ? "" : (is_terminal_ ? "\n  the node says: " : "; the node says: ") + last_message_;
      return format("  nothing has arrived on %s for %.0f s", subscriber_.getTopic().c_str(), silence) +
             (clearance_ ? "" : elsewhere(subscriber_.getTopic())) + message + "\n";
    }
    return is_terminal_ ? table(*clearance_, columnsOfTerminal()) : line(*clearance_);
  }

  void show(const std::string& text) {
    // Moves the cursor up to the first line of the last table, and erases everything from there.
    if (lines_ > 0) std::printf("\033[%ldA\033[J", lines_);
    std::fputs(text.c_str(), stdout);
    if (std::fflush(stdout) != 0) ros::shutdown();  // the program that reads the output has ended
    if (is_terminal_) lines_ = std::count(text.begin(), text.end(), '\n');
  }

  const bool is_terminal_ = isatty(STDOUT_FILENO) != 0;
  long lines_ = 0;            // number of lines of the table in the terminal
  std::string last_message_;  // the node's last log message
  Clearance::ConstPtr clearance_;
  ros::WallTime arrival_ = ros::WallTime::now();
  ros::Subscriber subscriber_;
  ros::Subscriber log_subscriber_;
  ros::WallTimer timer_;
};

}  // namespace

int main(int argc, char** argv) {
  if (proximity_server::system::tellsVersion(argc, argv, "clearance_table")) return 0;
  ros::init(argc, argv, "clearance_table", ros::init_options::AnonymousName);
  ros::NodeHandle nh;
  Display display(nh);
  ros::spin();
  return 0;
}
