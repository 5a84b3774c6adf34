#include "clearance_rows.h"

#include <nlohmann/json.hpp>

#include "csv.h"

namespace proximity_server {
namespace {

using Row = nlohmann::ordered_json;

const char* nameOf(Status status) {
  switch (status) {
    case Status::Unknown:
      return "unknown";
    case Status::Converged:
      return "converged";
    case Status::Threshold:
      return "threshold";
    case Status::IterationLimit:
      return "iteration_limit";
    case Status::Degenerate:
      return "degenerate";
  }
  return "unknown";
}

void addVector(const std::string& name, const Eigen::Vector3d& vector, Row& row) {
  row[name + "_x"] = vector.x();
  row[name + "_y"] = vector.y();
  row[name + "_z"] = vector.z();
}

/// The columns in their order; the header is made of it, too, so that the two cannot differ.
Row columns(long state, const std::string& link_a, const std::string& link_b, const PairProximity& pair) {
  Row row;
  row["state"] = state;
  row["link_a"] = link_a;
  row["link_b"] = link_b;
  row["distance"] = pair.result.distance;
  row["lower"] = pair.result.lower_bound;
  row["upper"] = pair.result.upper_bound;
  addVector("point_a", pair.result.point_a, row);
  addVector("point_b", pair.result.point_b, row);
  addVector("normal", pair.result.normal, row);
  row["status"] = nameOf(pair.result.status);
  row["representation"] = toString(pair.representation);
  return row;
}

std::string fieldOf(const Row& value) {
  if (value.is_string()) return csvField(value.get<std::string>());
  return value.is_number_float() ? numberText(value.get<double>()) : value.dump();
}

std::string csvLine(const Row& row) {
  std::string line;
  for (const Row& value : row) line += (line.empty() ? "" : ",") + fieldOf(value);
  return line;
}

}  // namespace

std::string rowsBegin(RowFormat format) {
  if (format == RowFormat::Json) return "[";
  const Row row = columns(0, "", "", {});
  std::string header;
  for (const auto& [name, value] : row.items()) header += (header.empty() ? "" : ",") + name;
  return header;
}

std::string rowText(long state, const PairProximity& pair, const RobotModel& robot, RowFormat format) {
  const Row row = columns(state, robot.links[pair.asked.a.link].name, robot.links[pair.asked.b.link].name, pair);
  // A URDF may hold any bytes; what is no UTF-8 is replaced rather than ending the run.
  return format == RowFormat::Csv ? csvLine(row) : row.dump(-1, ' ', false, Row::error_handler_t::replace);
}

std::string rowsSeparator(RowFormat format) { return format == RowFormat::Json ? ",\n" : "\n"; }
std::string rowsEnd(RowFormat format) { return format == RowFormat::Json ? "\n]\n" : "\n"; }

}  // namespace proximity_server
