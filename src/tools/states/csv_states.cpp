#include "tools/states/csv_states.h"

#include "proximity_server/scene/mesh/readable_file.h"
#include "tools/text/content_hash.h"
#include "tools/text/csv.h"
#include "tools/text/naming.h"

#include <filesystem>
#include <ios>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <streambuf>
#include <utility>

namespace proximity_server::tools {

CsvStates::CsvStates(const std::string& file, const scene::RobotModel& robot)
    : StateSource(file, robot), file_(std::in_place, file, std::ios::binary), stream_(*file_) {
  scene::requireReadable(file);
  if (!*file_) throw std::invalid_argument(file + ": cannot be read");
  readHeader();
}

CsvStates::CsvStates(std::istream& stream, std::string source, const scene::RobotModel& robot)
    : StateSource(std::move(source), robot), stream_(stream) {
  readHeader();
}

void CsvStates::readHeader() {
  if (!nextFields()) throw std::invalid_argument(header_.source + ": empty; expected a header of joint names");
  naming(place(), [&] { header_.setColumns(fields_); });
}

std::optional<const double*> CsvStates::fetch() {
  if (!nextFields()) return std::nullopt;
  if (fields_.size() != header_.columns.size()) {
    fail(std::to_string(fields_.size()) + " numbers for " + std::to_string(header_.columns.size()) + " columns");
  }
  numbers_.clear();
  for (std::size_t i = 0; i < fields_.size(); ++i) numbers_.push_back(numberOf(header_.columns[i], fields_[i]));
  return numbers_.data();
}

double CsvStates::numberOf(const JointColumn& column, const std::string& text) const {
  const std::optional<system::PositionText> value = system::positionIn(text);
  if (!value) return std::numeric_limits<double>::quiet_NaN();
  const bool turns = column.quantity != JointColumn::Quantity::Time &&
                     header_.robot.joints[column.joint].type != scene::Joint::Type::Prismatic;
  if (value->is_in_degrees && !turns) fail("'" + text + "' of " + scene::quoted(column.name) + ", which does not turn");
  return value->value;
}

std::string CsvStates::textOf(std::size_t column, double /*number*/) const { return fields_[column]; }

void CsvStates::skipTo(std::uint64_t state) {
  for (std::string text; this->state() < state && nextRecord(text);) passState();
}

std::optional<std::uint64_t> CsvStates::count() const {
  if (!file_ || !std::filesystem::is_regular_file(header_.source)) return std::nullopt;
  CsvStates all(header_.source, header_.robot);
  std::uint64_t count = 0;
  for (std::string text; all.nextRecord(text);) ++count;
  return count;
}

std::string CsvStates::identity() const {
  if (!file_ || !std::filesystem::is_regular_file(header_.source)) return "";
  return "csv " + contentHash(header_.source);
}

/// Reads a line; false at the end. std::getline would use all memory for a file without line ends.
bool CsvStates::nextLine(std::string& text) {
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

/// Reads the next line that is not empty; false at the end.
bool CsvStates::nextRecord(std::string& text) {
  while (nextLine(text)) {
    if (line_ == 1 && text.compare(0, 3, "\xEF\xBB\xBF") == 0) text.erase(0, 3);  // byte order mark of spreadsheets
    if (text.find_first_not_of(" \t\r") != std::string::npos) return true;
  }
  return false;
}

/// Splits the next line that is not empty into fields; false at the end.
bool CsvStates::nextFields() {
  std::string text;
  if (!nextRecord(text)) return false;
  try {
    fields_ = csvFields(text);
  } catch (const std::invalid_argument& error) {
    fail(error.what());
  }
  return true;
}

scene::Positions readState(const std::string& option, const std::string& text, const scene::RobotModel& robot,
                           Warnings warnings) {
  std::istringstream words(text);
  std::string names, values;
  bool is_first = true;
  for (std::string word; words >> word;) {
    const std::size_t equals = word.rfind('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == word.size()) {
      throw std::invalid_argument(option + ": '" + word + "' is not joint=position");
    }
    const std::string separator = is_first ? "" : ",";
    is_first = false;
    names += separator + csvField(word.substr(0, equals));
    values += separator + word.substr(equals + 1);
  }
  if (is_first) throw std::invalid_argument(option + ": no positions");
  std::istringstream table(names + "\n" + values + "\n");
  CsvStates states(table, option, robot);
  if (states.header().has(JointColumn::Quantity::Time)) throw std::invalid_argument(option + ": \"time\" is no joint");
  scene::TrajectoryPoint state;
  if (!states.next(state)) throw std::invalid_argument(option + ": no positions");
  printWarnings(states.header().warnings, warnings);
  printWarnings({states.limitWarning()}, warnings);
  return state.positions;
}

}  // namespace proximity_server::tools
