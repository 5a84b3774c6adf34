#include "tools/clearance/point_file.h"

#include "tools/robot/robot_files.h"
#include "tools/states/npy_array.h"
#include "tools/states/state_options.h"
#include "tools/text/csv.h"
#include "tools/text/naming.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace proximity_server::tools {
namespace {

constexpr std::size_t kWithRadius = 4;  // columns

void addPoint(const double* numbers, std::size_t columns, scene::Points& points) {
  points.centres.emplace_back(numbers[0], numbers[1], numbers[2]);
  if (columns == kWithRadius) points.radii.push_back(numbers[3]);
}

void readCsv(const std::string& file, scene::Points& points) {
  const std::vector<std::string> header{"x", "y", "z"}, with_radius{"x", "y", "z", "radius"};
  std::istringstream lines(readTextFile(file));
  std::size_t columns = 0;
  int number = 0;
  const auto readLine = [&](const std::string& line) {
    const std::vector<std::string> fields = csvFields(line);
    if (columns == 0 && fields != header && fields != with_radius)
      throw std::invalid_argument("expected the header x,y,z or x,y,z,radius");
    if (columns == 0) return static_cast<void>(columns = fields.size());
    if (fields.size() != columns)
      throw std::invalid_argument(std::to_string(fields.size()) + " numbers for " + std::to_string(columns) +
                                  " columns");
    std::vector<double> numbers;
    for (const std::string& field : fields) {
      const std::optional<double> value = finiteNumber(field);
      if (!value) throw std::invalid_argument("'" + field + "' is no finite number");
      numbers.push_back(*value);
    }
    addPoint(numbers.data(), columns, points);
  };
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    naming(file + ", line " + std::to_string(number), [&] { readLine(line); });
  }
}

void readNpy(const std::string& file, scene::Points& points) {
  NpyTable table(std::make_unique<FileBytes>(file), file);
  const std::size_t columns = table.columns();
  if (table.dimensions() != 2 || (columns != 3 && columns != kWithRadius))
    throw std::invalid_argument(file + ": expected a table of 3 columns, x, y and z, or of 4 with the radius");
  std::vector<double> numbers(table.rows() * columns);
  table.read(0, table.rows(), columns, numbers.data());
  for (std::size_t i = 0; i < numbers.size(); i += columns) addPoint(&numbers[i], columns, points);
}

}  // namespace

scene::Points readPoints(const std::string& file) {
  scene::Points points;
  isNumpy(file) ? readNpy(file, points) : readCsv(file, points);
  if (points.centres.empty()) throw std::invalid_argument(file + ": no point");
  naming(file, [&] { scene::requireValid(points); });
  return points;
}

}  // namespace proximity_server::tools
