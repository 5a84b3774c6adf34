#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

// A campaign of ./dev stress has families of cases, asks as many cases of each family as it is told to, and ends with a
// table. The programs and the tests that run a part of a campaign share it.

namespace proximity_server::stress {

/// A case that broke a promise.
struct Failure {
  std::int64_t number;   ///< of the case in its family
  std::string sentence;  ///< says which promise is broken
  /// Makes a line of a JSON file from the name of the failure. Without it the line says the seed that makes the case
  /// again.
  std::function<std::string(const std::string& name)> line;
};

/// The result of the cases of one family: numbers by name, and the first failures.
class Tally {
 public:
  std::string family;

  void add(const std::string& name, double number = 1.0) { entry(name, Kind::Sum).value += number; }
  /// Keeps the largest of the numbers; of numbers below 0 it is 0.
  void raise(const std::string& name, double number);
  /// Keeps the smallest of the numbers.
  void lower(const std::string& name, double number);
  /// Keeps every number.
  void sample(const std::string& name, double number) { entry(name, Kind::Sample).samples.push_back(number); }
  void fail(const Failure& failure);

  /// Returns a sum, the largest or the smallest number; 0 if there was none.
  double operator[](const std::string& name) const;
  /// Returns the number that a share of the samples does not exceed; 0 if there was none.
  double quantile(const std::string& name, double share) const;
  std::int64_t failed() const { return failed_; }
  /// At most kFailuresKept of them: a broken family would fill the memory.
  const std::vector<Failure>& failures() const { return failures_; }
  /// Returns every number under its name, the median of samples, and the number of failures.
  std::map<std::string, double> numbers() const;

  /// Adds the result of other cases of the family.
  void merge(const Tally& other);

  static constexpr std::size_t kFailuresKept = 20;

 private:
  enum class Kind : unsigned char { Sum, Largest, Smallest, Sample };
  struct Entry {
    Kind kind;
    double value;
    std::vector<double> samples;
  };
  Entry& entry(const std::string& name, Kind kind);

  std::map<std::string, Entry> entries_;
  std::int64_t failed_ = 0;
  std::vector<Failure> failures_;
};

/// A column of the table.
struct Column {
  const char* head;
  int width;
  const char* format;  ///< of printf(), with the width as an argument: "%*.1f"
  std::function<double(const Tally&)> value;
};

/// A column of one number of a tally, which is a count.
Column count(const char* head, int width, const char* name);
Column failures(int width);
Column number(const char* head, int width, const char* format, const char* name);
/// A column of a sum over the sum of another number, times a factor.
Column ratio(const char* head, int width, const char* format, const char* sum, const char* over, double factor = 1.0);

/// Prints what a row is about, `width` wide, and the names of the columns.
void printHead(const char* rows, int width, const std::vector<Column>& columns);
void printRow(int width, const std::vector<Column>& columns, const Tally& tally);

struct Family {
  std::string name;
  int rarity = 1;  ///< a slow family takes part in every so many rounds of a run only
};

template <class AnyFamily>
std::vector<Family> namesOf(const std::vector<AnyFamily>& families) {
  std::vector<Family> names;
  for (const AnyFamily& family : families) names.push_back({family.name, family.rarity});
  return names;
}

/// One part of a run. All that is asked in it depends on the seed, the family and the number only.
struct Part {
  unsigned seed;
  std::size_t family;
  std::int64_t number;  ///< of the part in its family
  int per_reference;
};

struct Campaign {
  const char* program;
  const char* about;
  const char* cases;  ///< "pairs", "motions", ...
  const char* one;    ///< the numbered thing that a failure names: "pair", "cell", ...
  const char* option = "";
  std::int64_t usual = 0;  ///< so many cases in a run of the program
  int cases_of_part = 1;
  const char* record_file = "";  ///< in test/data, for failures
  const char* reference_option = nullptr;
  const char* reference_help = nullptr;
  int per_reference = 1;  ///< one in so many parts or cases is compared with a slow reference

  std::vector<Family> families{};
  /// Asks a part, and adds its result to the tally.
  std::function<void(const Part& part, Tally& tally)> ask{};
  int name_width = 24;
  std::vector<Column> columns{};
  const char* legend = "";
};

// The campaigns of the programs.
Campaign pairCampaign();
Campaign motionCampaign();
Campaign sceneCampaign();
Campaign pointCampaign();
Campaign cloudCampaign();
Campaign freeMotionCampaign();
Campaign stopCampaign();
Campaign peopleCampaign();
Campaign driveCampaign();
/// With drives that end after so many seconds of the robot's time.
Campaign driveCampaign(double duration);

/// How much of a campaign is asked.
struct Run {
  std::int64_t cases;  ///< of all families together, rounded up to whole rounds
  unsigned seed = 1;
  std::string family{};  ///< one only; empty: all
  unsigned threads = 0;  ///< 0: one for each core
};

/// Asks each family, in rounds in which each of them that is not too rare takes part once. The result does not depend
/// on the threads. `done` counts the cases meanwhile. Throws std::invalid_argument if no family has the name.
std::vector<Tally> observe(const Campaign& campaign, const Run& run);
std::vector<Tally> observe(const Campaign& campaign, const Run& run, std::atomic<std::int64_t>& done);

/// Does what a program of ./dev stress does: returns 0 without a failure, 1 with failures, 2 if the run was not
/// possible.
int runProgram(Campaign campaign, int argc, char** argv);

class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

}  // namespace proximity_server::stress
