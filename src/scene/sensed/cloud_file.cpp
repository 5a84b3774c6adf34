#include "proximity_server/scene/sensed/cloud_file.h"

#include "proximity_server/scene/mesh/readable_file.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/sensed/octree.h"
#include "proximity_server/scene/sensed/point_record.h"
#include "proximity_server/scene/sensed/voxel_grid.h"
#include "system/number_text.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <stdexcept>
#include <string_view>

namespace proximity_server::scene {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using system::numberIn;
using Type = PointRecord::Type;

/// The words of a file, line by line. Words end at blanks.
class Lines {
 public:
  explicit Lines(const std::string& path) : path_(path) {
    requireReadable(path);
    std::ifstream stream(path, std::ios::binary);
    text_.assign(std::istreambuf_iterator<char>(stream), {});
  }

  /// Goes to the next line; false at the end of the file.
  bool next() {
    if (next_ == text_.size()) return false;
    const std::size_t end = std::min(text_.find('\n', next_), text_.size());
    line_ = std::string_view(text_).substr(next_, end - next_);
    next_ = std::min(end + 1, text_.size());
    ++number_;
    words_.clear();
    constexpr const char* kBlanks = " \t\r";
    for (std::size_t begin = 0; (begin = line_.find_first_not_of(kBlanks, begin)) != line_.npos;) {
      const std::size_t word_end = std::min(line_.find_first_of(kBlanks, begin), line_.size());
      words_.push_back(line_.substr(begin, word_end - begin));
      begin = word_end;
    }
    return true;
  }

  /// Goes to the next line of a header that has words and is no comment.
  void nextOfHeader() {
    do {
      if (!next()) fail("the file ends in its header");
    } while (words_.empty() || words_[0][0] == '#');
  }

  std::string_view line() const { return line_; }
  const std::vector<std::string_view>& words() const { return words_; }
  std::string_view word(std::size_t number) const { return number < words_.size() ? words_[number] : ""; }
  std::string_view rest() const { return std::string_view(text_).substr(next_); }  ///< behind the line

  [[noreturn]] void fail(const std::string& what) const {
    throw std::invalid_argument(path_ + ", line " + std::to_string(number_) + ": " + what);
  }

  /// A whole number below 2^32, so that products of two fit into 64 bits.
  std::uint32_t count(std::string_view word) const {
    const std::optional<std::uint32_t> number = numberIn<std::uint32_t>(word);
    if (!number) fail(quoted(std::string(word)) + " is no whole number");
    return *number;
  }

 private:
  std::string path_, text_;
  std::size_t next_ = 0, number_ = 0;
  std::string_view line_;
  std::vector<std::string_view> words_;
};

/// How a file writes its points.
struct PointTable {
  struct Column {
    PointRecord::Field field;
    std::uint64_t number;  // of the record
  };

  bool is_text = false, is_big_endian = false;
  bool ends_file = false;  // nothing follows the points
  std::uint64_t points = 0;
  std::uint64_t numbers = 0, bytes = 0;          // of a record
  std::map<std::string_view, Column> columns{};  // the first of each name

  void add(std::string_view name, Type type, std::uint64_t size, std::uint64_t count) {
    if (count > 0) columns.try_emplace(name, Column{{bytes, type, size}, numbers});
    numbers += count;
    bytes += size * count;
  }

  /// The columns of x, y and z.
  std::array<Column, 3> coordinates(const Lines& lines) const {
    const auto named = [&](const char* name) {
      const auto column = columns.find(name);
      if (column == columns.end()) lines.fail(std::string("the points have no ") + name);
      return column->second;
    };
    return {named("x"), named("y"), named("z")};
  }
};

/// The type of a field of .pcd.
Type typeOf(std::string_view word, std::uint32_t size, const Lines& lines) {
  const bool is_whole = word == "I" || word == "U", is_long = size == 4 || size == 8;
  if (!(is_long && word == "F") && !(is_whole && (is_long || size == 1 || size == 2)))
    lines.fail("a field of TYPE " + quoted(std::string(word)) + " and SIZE " + std::to_string(size) +
               " is not supported");
  return word == "F" ? Type::Float : word == "I" ? Type::Signed : Type::Unsigned;
}

PointTable tableOfPcd(Lines& lines) {
  std::map<std::string_view, std::vector<std::string_view>> header;
  while (header.count("DATA") == 0) {
    lines.nextOfHeader();
    header[lines.word(0)].assign(lines.words().begin() + 1, lines.words().end());
  }
  const std::string_view encoding = lines.word(1);
  if (encoding == "binary_compressed")
    lines.fail("DATA binary_compressed is not supported; pcl_convert_pcd_ascii_binary makes a binary file of it");
  if (encoding != "ascii" && encoding != "binary") lines.fail("DATA is neither ascii nor binary");
  PointTable table;
  table.is_text = encoding == "ascii";
  table.ends_file = true;
  const auto &names = header["FIELDS"], &sizes = header["SIZE"], &types = header["TYPE"], &counts = header["COUNT"];
  const bool has_counts = !counts.empty();
  if (sizes.size() != names.size() || types.size() != names.size() || (has_counts && counts.size() != names.size()))
    lines.fail("FIELDS, SIZE, TYPE and COUNT of the header differ in their numbers of words");
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::uint32_t size = lines.count(sizes[i]);
    table.add(names[i], typeOf(types[i], size, lines), size, has_counts ? lines.count(counts[i]) : 1);
  }
  const auto number = [&](const char* name) {
    if (header[name].size() != 1) lines.fail("the header has no number " + std::string(name));
    return std::uint64_t{lines.count(header[name][0])};
  };
  table.points = number("WIDTH") * number("HEIGHT");
  if (number("POINTS") != table.points) lines.fail("POINTS of the header is not WIDTH times HEIGHT");
  return table;
}

/// A type of .ply, with its two names.
struct PlyType {
  std::string_view name, other_name;
  Type type;
  std::uint64_t size;
};
constexpr std::array<PlyType, 8> kPlyTypes{{{"char", "int8", Type::Signed, 1},
                                            {"uchar", "uint8", Type::Unsigned, 1},
                                            {"short", "int16", Type::Signed, 2},
                                            {"ushort", "uint16", Type::Unsigned, 2},
                                            {"int", "int32", Type::Signed, 4},
                                            {"uint", "uint32", Type::Unsigned, 4},
                                            {"float", "float32", Type::Float, 4},
                                            {"double", "float64", Type::Float, 8}}};

PointTable tableOfPly(Lines& lines) {
  PointTable table;
  std::string_view format, element;
  lines.nextOfHeader();
  if (lines.word(0) != "ply") lines.fail("no PLY: it does not begin with ply");
  for (lines.nextOfHeader(); lines.word(0) != "end_header"; lines.nextOfHeader()) {
    if (lines.word(0) == "format") {
      format = lines.word(1);
    } else if (lines.word(0) == "element") {
      if (element.empty() != (lines.word(1) == "vertex")) lines.fail("vertex must be the first element, and no other");
      element = lines.word(1);
      if (element == "vertex") table.points = lines.count(lines.word(2));
    } else if (lines.word(0) == "property" && element == "vertex") {
      const std::string_view word = lines.word(1);
      const auto is_it = [&](const PlyType& type) { return type.name == word || type.other_name == word; };
      const auto* const type = std::find_if(kPlyTypes.begin(), kPlyTypes.end(), is_it);
      if (type == kPlyTypes.end())
        lines.fail("a property of a vertex of type " + quoted(std::string(word)) + " is not supported");
      table.add(lines.word(2), type->type, type->size, 1);
    }
  }
  if (format != "ascii" && format != "binary_little_endian" && format != "binary_big_endian")
    lines.fail("the format is none of ascii, binary_little_endian and binary_big_endian");
  table.is_text = format == "ascii";
  table.is_big_endian = format == "binary_big_endian";
  return table;
}

std::vector<Vector3d> pointsOfText(const PointTable& table, Lines& lines) {
  const std::array<PointTable::Column, 3> columns = table.coordinates(lines);
  const auto numberAt = [&](const PointTable::Column& column) {
    const std::string_view word = lines.words()[column.number];
    const std::optional<double> number = numberIn<double>(word);
    if (!number) lines.fail(quoted(std::string(word)) + " is no number");
    return *number;
  };
  std::vector<Vector3d> points;
  while (points.size() < table.points) {
    if (!lines.next())
      lines.fail("the file ends after " + std::to_string(points.size()) + " of " + std::to_string(table.points) +
                 " points");
    if (lines.words().empty()) continue;
    if (lines.words().size() != table.numbers)
      lines.fail(std::to_string(lines.words().size()) + " numbers, expected " + std::to_string(table.numbers));
    points.emplace_back(numberAt(columns[0]), numberAt(columns[1]), numberAt(columns[2]));
  }
  while (table.ends_file && lines.next())
    if (!lines.words().empty()) lines.fail("more follows behind the points");
  return points;
}

std::vector<Vector3d> pointsOfBytes(const PointTable& table, const Lines& lines) {
  const auto [x, y, z] = table.coordinates(lines);
  const PointRecord record{{x.field, y.field, z.field}, table.is_big_endian};
  const std::string_view bytes = lines.rest();
  if (bytes.size() / table.bytes < table.points || (table.ends_file && table.points * table.bytes != bytes.size()))
    lines.fail("behind it are " + std::to_string(bytes.size()) + " bytes, but " + std::to_string(table.points) +
               " points have " + std::to_string(table.bytes) + " bytes each");
  std::vector<Vector3d> points;
  for (std::uint64_t i = 0; i < table.points; ++i) points.push_back(record.at(bytes.data() + i * table.bytes));
  return points;
}

std::vector<AlignedBox3d> boxesOfOctree(const std::string& path) {
  Lines lines(path);
  lines.next();
  Octree octree{"", lines.line() == "# Octomap OcTree binary file", 0.0, {}};
  if (!octree.is_binary && lines.line() != "# Octomap OcTree file")
    lines.fail("no octree of octomap: it does not begin with \"# Octomap OcTree\"");
  for (lines.nextOfHeader(); lines.word(0) != "data"; lines.nextOfHeader()) {
    if (lines.word(0) == "id") octree.id = lines.word(1);
    if (lines.word(0) == "res") octree.resolution = numberIn<double>(lines.word(1)).value_or(0.0);
  }
  octree.bytes = lines.rest();
  try {
    return occupiedBoxes(octree);
  } catch (const std::invalid_argument& error) {
    lines.fail(std::string("behind it, ") + error.what());
  }
}

}  // namespace

std::vector<Vector3d> readCloudPoints(const std::string& path) {
  const std::string suffix = std::filesystem::path(path).extension();
  if (suffix != ".pcd" && suffix != ".ply")
    throw std::invalid_argument(path + ": the name of a cloud ends with .pcd, .ply, .bt or .ot");
  Lines lines(path);
  const PointTable table = suffix == ".pcd" ? tableOfPcd(lines) : tableOfPly(lines);
  std::vector<Vector3d> points = table.is_text ? pointsOfText(table, lines) : pointsOfBytes(table, lines);
  const auto is_no_return = [](const Vector3d& point) { return !point.allFinite(); };
  points.erase(std::remove_if(points.begin(), points.end(), is_no_return), points.end());
  return points;
}

bool isCloudFile(const std::string& path) {
  const std::string suffix = std::filesystem::path(path).extension();
  return suffix == ".pcd" || suffix == ".ply" || suffix == ".bt" || suffix == ".ot";
}

std::vector<AlignedBox3d> readCloudBoxes(const std::string& path, double resolution) {
  const std::string suffix = std::filesystem::path(path).extension();
  std::vector<AlignedBox3d> boxes;
  if (suffix == ".bt" || suffix == ".ot") {
    boxes = boxesOfOctree(path);
  } else {
    VoxelGrid grid(resolution);
    const std::vector<Vector3d> points = readCloudPoints(path);
    try {
      for (const Vector3d& point : points) grid.add(point);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(path + ": " + error.what());
    }
    boxes = grid.boxes();
  }
  if (boxes.empty()) throw std::invalid_argument(path + ": nothing is occupied");
  return boxes;
}

}  // namespace proximity_server::scene
