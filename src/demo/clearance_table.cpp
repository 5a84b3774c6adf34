// Shows the topic `clearance` in the terminal: a table that is redrawn in place, or one line per second if the output
// is not a terminal.
#include <proximity_server/Clearance.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Log.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "node/robot/level_name.h"

namespace {

using proximity_server::Clearance;
using proximity_server::levelName;
using proximity_server::levelOfThreshold;
using proximity_server::Proximity;

constexpr std::size_t kRows = 8;  // of the list of pairs below the threshold

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

std::string pairLine(const Proximity& pair) {
  return format("%+9.4f m  %s - %s", pair.distance, pair.a.link.c_str(), pair.b.link.c_str());
}

/// The pair that sets the level, with its threshold.
std::string decidingLine(const Clearance& clearance) {
  if (clearance.level == Clearance::INVALID) return clearance.status.message;
  if (clearance.level == Clearance::COLLISION) return pairLine(clearance.deciding);
  return pairLine(clearance.deciding) +
         format(" (%s at %.4f m)", levelOfThreshold(clearance.level), clearance.deciding_threshold);
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

/// The closest pair of each kind, each after `before` and before `after`; "" where no pair with an object is checked.
std::string kindLines(const Clearance& clearance, const std::string& before, const std::string& after) {
  const bool has_links = !clearance.self_minimum.a.link.empty();
  if (clearance.object_minimum.a.link.empty()) return "";
  return (has_links ? before + "links    " + pairLine(clearance.self_minimum) + after : "") + before + "objects  " +
         pairLine(clearance.object_minimum) + after;
}

std::string line(const Clearance& clearance) {
  return format("%-9s", levelName(clearance.level)) + " " + decidingLine(clearance) + kindLines(clearance, " | ", "") +
         " | " + settledLine(clearance) + " | " + timeLine(clearance) + "\n";
}

std::string table(const Clearance& clearance) {
  std::string text = std::string("  ") + colourOf(clearance.level) + format(" %-9s ", levelName(clearance.level)) +
                     "\033[0m  " + decidingLine(clearance) + "\n\n" + kindLines(clearance, "  ", "\n") + "  checked  " +
                     settledLine(clearance) + "\n  timing   " + timeLine(clearance) + "\n\n";
  const std::size_t rows = std::min(kRows, clearance.below_threshold.size());
  for (std::size_t i = 0; i < rows; ++i)
    text += "  " + pairLine(clearance.below_threshold[i]) + "  " + levelName(clearance.levels[i]) + "\n";
  if (clearance.pairs_below_threshold > rows) {
    text += format("             and %u more below the threshold\n",
                   clearance.pairs_below_threshold - static_cast<unsigned>(rows));
  }
  return text;
}

/// The name of the node that has this private topic.
std::string nodeOf(const std::string& topic) { return topic.substr(0, topic.find_last_of('/')); }

/// The first line of a text, cut so that it fits into one line of the terminal: the table is redrawn by counting lines.
std::string firstLine(const std::string& text) {
  constexpr std::size_t kLongest = 60;
  std::size_t end = std::min(text.find('\n'), text.size());
  if (end <= kLongest) return text.substr(0, end);
  const auto continues = [&](std::size_t i) {
    return (static_cast<unsigned char>(text[i]) & 0xC0u) == 0x80u;
  };  // UTF-8
  for (end = kLongest; continues(end);) --end;
  return text.substr(0, end) + "...";
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

  /// Keeps the node's last log message, which is shown as long as no clearance arrives, as while the node loads.
  void onLog(const rosgraph_msgs::Log::ConstPtr& log) {
    if (log->name == nodeOf(subscriber_.getTopic())) last_message_ = firstLine(log->msg);
  }

  void onTimer(const ros::WallTimerEvent&) { show(text()); }

  std::string text() const {
    const double silence = (ros::WallTime::now() - arrival_).toSec();
    if (!clearance_ || silence > 1.0) {
      const std::string message =
          last_message_.empty() ? "" : (is_terminal_ ? "\n  the node says: " : "; the node says: ") + last_message_;
      return format("  nothing has arrived on %s for %.0f s", subscriber_.getTopic().c_str(), silence) + message + "\n";
    }
    return is_terminal_ ? table(*clearance_) : line(*clearance_);
  }

  void show(const std::string& text) {
    // Moves the cursor up to the first line of the last table, and erases everything from there.
    if (lines_ > 0) std::printf("\033[%ldA\033[J", lines_);
    std::fputs(text.c_str(), stdout);
    if (std::fflush(stdout) != 0) ros::shutdown();  // the reader of the output has ended
    if (is_terminal_) lines_ = std::count(text.begin(), text.end(), '\n');
  }

  const bool is_terminal_ = isatty(STDOUT_FILENO) != 0;
  long lines_ = 0;            // of the table in the terminal
  std::string last_message_;  // of the node's log
  Clearance::ConstPtr clearance_;
  ros::WallTime arrival_ = ros::WallTime::now();
  ros::Subscriber subscriber_;
  ros::Subscriber log_subscriber_;
  ros::WallTimer timer_;
};

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "clearance_table", ros::init_options::AnonymousName);
  ros::NodeHandle nh;
  Display display(nh);
  ros::spin();
  return 0;
}
