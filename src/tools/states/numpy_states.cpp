#include "tools/states/numpy_states.h"

#include "system/whole_file.h"
#include "tools/robot/robot_files.h"
#include "tools/states/bytes.h"
#include "tools/text/content_hash.h"
#include "tools/text/csv.h"
#include "tools/text/naming.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace proximity_server::tools {
namespace {

constexpr std::uint64_t kBlockNumbers = 1 << 15;  // few enough for the second cache

std::filesystem::path namesFileOf(const std::string& file) {
  return std::filesystem::path(file).replace_extension(".joints");
}

/// The names in the file beside the table; empty if there is none.
std::vector<std::string> namesBeside(const std::string& file) {
  const std::filesystem::path path = namesFileOf(file);
  if (!std::filesystem::is_regular_file(path)) return {};
  system::FileRoles::ofProcess().addInput("the names of joints", path);
  std::vector<std::string> names;
  std::istringstream lines(readTextFile(path));
  for (std::string line; std::getline(lines, line);) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    for (const std::string& name : csvFields(line)) names.push_back(name);
  }
  return names;
}

/// The joints that a state has to name, as an example of --joints.
std::string exampleOf(const scene::RobotModel& robot) {
  std::string names;
  for (const scene::Joint& joint : robot.joints)
    if (!joint.mimic && scene::hasOnePosition(joint)) names += (names.empty() ? "" : ",") + csvField(joint.name);
  return names;
}

bool contains(const std::vector<std::string>& all, const std::string& one) {
  return std::find(all.begin(), all.end(), one) != all.end();
}

/// The first of these arrays that the archive has; "" if it has none.
std::string firstOf(const std::vector<std::string>& arrays, const ZipArchive& archive) {
  for (const std::string& array : arrays)
    if (contains(archive.members(), array + ".npy")) return array + ".npy";
  return "";
}

/// The member with the positions.
std::string tableOf(const ZipArchive& archive, const std::string& file) {
  const std::string known = firstOf({"states", "positions", "q"}, archive);
  if (!known.empty()) return known;
  std::vector<std::string> others;
  std::string list;
  for (const std::string& member : archive.members()) {
    if (member == "joints.npy" || member == "names.npy" || member == "time.npy") continue;
    others.push_back(member);
    list += (list.empty() ? "" : ", ") + member;
  }
  if (others.size() == 1) return others.front();
  throw std::invalid_argument(file + ": which array are the states? Name it \"states\"; there " +
                              (others.empty() ? "is none" : "are " + list));
}

}  // namespace

NumpyStates::NumpyStates(const std::string& file, const std::vector<std::string>& joints,
                         const scene::RobotModel& robot)
    : StateSource(file, robot) {
  std::vector<std::string> names = joints;
  auto bytes = std::make_unique<FileBytes>(file);
  std::array<char, 2> begin{};
  if (bytes->size() >= begin.size()) bytes->read(0, begin.data(), begin.size());
  if (begin == std::array<char, 2>{'P', 'K'}) {
    openMembers(names);
  } else {
    table_.emplace(std::move(bytes), file);
  }
  if (table_->dimensions() != 2)
    throw std::invalid_argument(table_->source() + ": an array of one dimension; expected a row for each state");
  if (names.empty()) names = namesBeside(file);
  nameColumns(names);
}

/// Opens the table of an archive, and the times if it has them. Reads the names if there are none.
void NumpyStates::openMembers(std::vector<std::string>& names) {
  const ZipArchive archive(header_.source);
  const std::string table = tableOf(archive, header_.source), joints = firstOf({"joints", "names"}, archive);
  table_.emplace(archive.open(table), header_.source + ", " + table);
  if (names.empty() && !joints.empty()) names = readNpyTexts(*archive.open(joints), header_.source + ", " + joints);
  if (!contains(archive.members(), "time.npy")) return;
  times_.emplace(archive.open("time.npy"), header_.source + ", time.npy");
  if (times_->dimensions() == 1 && times_->rows() == table_->rows()) return;
  throw std::invalid_argument(times_->source() + ": not one time for each of " + std::to_string(table_->rows()) +
                              " states");
}

void NumpyStates::nameColumns(const std::vector<std::string>& names) {
  const auto refuse = [&](const std::string& what) { throw std::invalid_argument(table_->source() + ": " + what); };
  const std::string columns = std::to_string(table_->columns()) + " columns";
  if (names.empty()) {
    refuse("the joints of its " + columns + " are not named: give --joints NAME,NAME, ..., or the file " +
           namesFileOf(header_.source).string() + "; the joints of the robot are " + exampleOf(header_.robot));
  }
  if (names.size() != table_->columns()) refuse(columns + " for " + std::to_string(names.size()) + " names of joints");
  naming(table_->source(), [&] { header_.setColumns(names); });
  if (!times_) return;
  if (header_.has(JointColumn::Quantity::Time)) refuse("a column \"time\", and an array \"time\" beside it");
  header_.columns.push_back({"time", -1, JointColumn::Quantity::Time});
}

std::optional<const double*> NumpyStates::fetch() {
  if (state() >= table_->rows()) return std::nullopt;
  if (state() < block_begin_ || state() >= block_end_) readBlock();
  return block_.data() + (state() - block_begin_) * header_.columns.size();
}

std::string NumpyStates::place() const {
  // The place in an archive has the name of the table.
  return table_->source() + StateSource::place().substr(header_.source.size());
}

/// Reads the block that begins with the next state.
void NumpyStates::readBlock() {
  const std::uint64_t most = std::max<std::uint64_t>(1, kBlockNumbers / header_.columns.size());
  const std::size_t count = std::min(most, table_->rows() - state());
  block_.resize(count * header_.columns.size());
  block_end_ = block_begin_;  // nothing is there if reading fails
  table_->read(state(), count, header_.columns.size(), block_.data());
  if (times_) times_->read(state(), count, header_.columns.size(), block_.data() + table_->columns());
  block_begin_ = state();
  block_end_ = state() + count;
}

std::string NumpyStates::identity() const {
  ContentHash names;
  for (std::uint64_t i = 0; i < table_->columns(); ++i) names.add(header_.columns[i].name);
  return "numpy " + contentHash(header_.source) + " " + names.text();
}

}  // namespace proximity_server::tools
