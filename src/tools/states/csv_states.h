#pragma once

#include "tools/robot/robot_files.h"
#include "tools/states/state_source.h"

#include <fstream>
#include <istream>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// The most characters of one line: enough for the quoted names of as many joints as a robot may have.
constexpr std::size_t kLongestLine = std::size_t{8} << 20;

/// States as comma-separated values, read one at a time: a header of joint names, then a row for each state. Empty
/// lines are skipped. A column "time" is the time of the state, unless a joint has that name.
///
/// Failure: throws std::invalid_argument naming source, line and column: no header, names that jointColumns() refuses,
///          too few or many numbers, a text that is no finite number, a line longer than kLongestLine.
class CsvStates : public StateSource {
 public:
  /// Read the header.
  explicit CsvStates(const std::string& file, const scene::RobotModel& robot);
  /// `source` names the stream in messages. The stream must outlive this.
  CsvStates(std::istream& stream, std::string source, const scene::RobotModel& robot);

  void skipTo(std::uint64_t state) override;
  std::optional<std::uint64_t> count() const override;
  std::string identity() const override;

 protected:
  std::optional<const double*> fetch() override;
  std::string textOf(std::size_t column, double number) const override;

 private:
  void readHeader();
  double numberOf(const JointColumn& column, const std::string& text) const;
  bool nextLine(std::string& text);
  bool nextRecord(std::string& text);
  bool nextFields();

  std::optional<std::ifstream> file_;
  std::istream& stream_;
  std::vector<std::string> fields_;  ///< the fields of the current line
  std::vector<double> numbers_;      ///< their numbers
};

/// Reads "joint=position ..." as a table with one state; the other joints are at 0. It prints the warnings about it.
/// Failure: throws std::invalid_argument naming the option, as CsvStates does.
scene::Positions readState(const std::string& option, const std::string& text, const scene::RobotModel& robot,
                           Warnings warnings);

}  // namespace proximity_server::tools
