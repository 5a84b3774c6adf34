#include "tools/clearance/clearance_rows.h"

#include <nlohmann/json.hpp>

#include "proximity_server/scene/levels/clearance_level.h"
#include "tools/command_line/csv.h"

namespace proximity_server::tools {
namespace {

using Row = nlohmann::ordered_json;

const char* statusName(narrowphase::Status status) {
  switch (status) {
    case narrowphase::Status::Unknown:
      return "unknown";
    case narrowphase::Status::Converged:
      return "converged";
    case narrowphase::Status::Threshold:
      return "threshold";
    case narrowphase::Status::IterationLimit:
      return "iteration_limit";
    case narrowphase::Status::Degenerate:
      return "degenerate";
  }
  return "unknown";
}

void addVector(const std::string& name, const Eigen::Vector3d& vector, Row& row) {
  row[name + "_x"] = vector.x();
  row[name + "_y"] = vector.y();
  row[name + "_z"] = vector.z();
}

/// A robot and what stands around it; nullptr: nothing.
struct Named {
  const scene::RobotModel& robot;
  const scene::Objects* objects;
};

void addNames(const std::string& prefix, const scene::ShapeRefPair& pair, const Named& named, Row& row) {
  row[prefix + "link_a"] = nameOf(pair.a, named.robot, named.objects);
  row[prefix + "link_b"] = nameOf(pair.b, named.robot, named.objects);
}

void addPair(const scene::PairProximity& pair, const Named& named, Row& row) {
  addNames("", pair.asked, named, row);
  row["distance"] = pair.result.distance;
  row["lower"] = pair.result.lower_bound;
  row["upper"] = pair.result.upper_bound;
  addVector("point_a", pair.result.point_a, row);
  addVector("point_b", pair.result.point_b, row);
  addVector("normal", pair.result.normal, row);
  row["status"] = statusName(pair.result.status);
  row["representation"] = toString(pair.representation);
}

/// Whether there is contact; null if that is not decided.
Row contactOf(const scene::RobotContact& contact) {
  if (contact.contact) return true;
  return contact.status == narrowphase::Status::Converged ? Row(false) : Row();
}

void addContact(const SegmentClearance& answer, const Named& named, Row& row) {
  row["contact"] = contactOf(answer.contact);
  row["t_free"] = answer.segment.timeAt(answer.contact.t_free);
  row["t_contact"] = answer.segment.timeAt(answer.contact.t_contact);
  addNames("contact_", answer.contact.pair.asked, named, row);
}

// These functions define the columns and their order. The headers are made by them, too, so that the two cannot differ.

Row stateColumns(long state, const scene::PairProximity& pair, const Named& named,
                 const scene::LevelThresholds* thresholds) {
  Row row;
  row["state"] = state;
  addPair(pair, named, row);
  if (thresholds) row["level"] = levelText(pair, *thresholds);
  return row;
}

Row segmentColumns(const SegmentClearance& answer, const scene::RobotModel& robot) {
  scene::PairProximity closest = answer.minimum.pair;
  closest.result.lower_bound = answer.minimum.lower_bound;
  closest.result.upper_bound = answer.minimum.upper_bound;
  closest.result.status = answer.minimum.status;
  Row row;
  row["segment"] = answer.segment.number;
  row["t_begin"] = answer.segment.begin;
  row["t_end"] = answer.segment.end;
  row["t_minimum"] = answer.segment.timeAt(answer.minimum.time);
  const Named named{robot, answer.objects.get()};
  addPair(closest, named, row);
  addContact(answer, named, row);
  return row;
}

Row namedPositions(const scene::RobotModel& robot, const scene::Positions& positions) {
  Row named = Row::object();
  for (const scene::JointRange& range : scene::jointRanges(robot))
    named[robot.joints[range.joint].name] = positions[range.joint];
  return named;
}

std::string fieldOf(const Row& value) {
  if (value.is_null()) return "unknown";
  if (value.is_string()) return csvField(value.get<std::string>());
  return value.is_number_float() ? numberText(value.get<double>()) : value.dump();
}

std::string csvLine(const Row& row) {
  std::string line;
  for (const Row& value : row) line += (line.empty() ? "" : ",") + fieldOf(value);
  return line;
}

// A URDF may contain any bytes: those that are not UTF-8 are replaced, because dump() would throw for them.
std::string jsonObject(const Row& row) { return row.dump(-1, ' ', false, Row::error_handler_t::replace); }

}  // namespace

std::string rowsBegin(RowKind kind, RowFormat format, LevelColumn levels) {
  if (format == RowFormat::Json) return "[";
  const scene::LevelThresholds any;
  const Row row = kind == RowKind::State
                      ? stateColumns(0, {}, {{}, nullptr}, levels == LevelColumn::With ? &any : nullptr)
                      : segmentColumns({}, {});
  std::string header;
  for (const auto& [name, value] : row.items()) header += (header.empty() ? "" : ",") + name;
  return header;
}

std::string levelText(const scene::PairProximity& pair, const scene::LevelThresholds& thresholds) {
  if (pair.result.status == narrowphase::Status::Unknown) return "INVALID";
  return toString(scene::levelOf(pair, thresholds).level);
}

std::string rowText(long state, const scene::PairProximity& pair, const scene::RobotModel& robot,
                    const scene::Objects* objects, RowFormat format, const scene::LevelThresholds* thresholds) {
  const Row row = stateColumns(state, pair, {robot, objects}, thresholds);
  return format == RowFormat::Csv ? csvLine(row) : jsonObject(row);
}

std::string rowText(const SegmentClearance& answer, const scene::RobotModel& robot, RowFormat format) {
  Row row = segmentColumns(answer, robot);
  if (format == RowFormat::Csv) return csvLine(row);
  row["contact_state"] =
      answer.contact.contact ? namedPositions(robot, answer.segment.positionsAt(answer.contact.t_contact)) : Row();
  return jsonObject(row);
}

std::string rowsSeparator(RowFormat format) { return format == RowFormat::Json ? ",\n" : "\n"; }
std::string rowsEnd(RowFormat format) { return format == RowFormat::Json ? "\n]\n" : "\n"; }

}  // namespace proximity_server::tools
