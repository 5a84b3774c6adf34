#include "tools/clearance/clearance_rows.h"

#include "proximity_server/scene/levels/clearance_level.h"
#include "tools/robot/robot_text.h"
#include "tools/text/csv.h"

#include <nlohmann/json.hpp>

#include <array>
#include <charconv>
#include <stdexcept>

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
struct Surroundings {
  const scene::RobotModel& robot;
  const scene::Objects* objects;
};

void addNames(const std::string& prefix, const scene::ShapeRefPair& pair, const Surroundings& named, Row& row) {
  row[prefix + "link_a"] = nameOf(pair.a, named.robot, named.objects);
  row[prefix + "link_b"] = nameOf(pair.b, named.robot, named.objects);
}

void addPair(const scene::PairProximity& pair, const Surroundings& named, Row& row) {
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
Row contactOf(const scene::RobotTimeOfContact& contact) {
  if (contact.contact) return true;
  return contact.status == narrowphase::Status::Converged ? Row(false) : Row();
}

void addContact(const SegmentClearance& answer, const Surroundings& named, Row& row) {
  row["contact"] = contactOf(answer.contact);
  row["t_free"] = answer.segment.timeAt(answer.contact.t_free);
  row["t_contact"] = answer.segment.timeAt(answer.contact.t_contact);
  addNames("contact_", answer.contact.pair.asked, named, row);
}

// These functions define the columns and their order.

Row stateColumns(long state, const scene::PairProximity& pair, const Surroundings& named,
                 const scene::LevelThresholds* thresholds) {
  Row row;
  row["state"] = state;
  addPair(pair, named, row);
  const bool is_known = pair.result.status != narrowphase::Status::Unknown;
  if (thresholds) row["level"] = is_known ? toString(scene::levelOf(pair, *thresholds).level) : "INVALID";
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
  const Surroundings named{robot, answer.segment.objects.get()};
  addPair(closest, named, row);
  addContact(answer, named, row);
  return row;
}

const char* verdictName(Verdict verdict) {
  switch (verdict) {
    case Verdict::Above:
      return "above";
    case Verdict::Below:
      return "below";
    case Verdict::Unknown:
      break;
  }
  return "unknown";
}

Row verdictColumns(long state, Verdict verdict, const std::string& link_a, const std::string& link_b) {
  return {{"state", state}, {"verdict", verdictName(verdict)}, {"link_a", link_a}, {"link_b", link_b}};
}

Row namedPositions(const scene::RobotModel& robot, const scene::Positions& positions) {
  Row named = Row::object();
  for (const scene::JointRange& range : scene::jointRanges(robot))
    named[robot.joints[range.joint].name] = positions[range.joint];
  return named;
}

/// The first row of a CSV, made by the same functions as the others, so that the two cannot differ.
std::string csvHeader(const Row& columns) {
  std::string header;
  for (const auto& [name, value] : columns.items()) header += (header.empty() ? "" : ",") + name;
  return header;
}

std::string fieldOf(const Row& value) {
  if (value.is_null()) return "unknown";
  if (value.is_string()) return csvField(value.get<std::string>());
  return value.is_number_float() ? shortest(value.get<double>()) : value.dump();
}

std::string textOf(const Row& row, RowFormat format) {
  std::string line;
  switch (format) {
    case RowFormat::Csv:
      for (const Row& value : row) line += (line.empty() ? "" : ",") + fieldOf(value);
      return line;
    case RowFormat::Json:
      // A URDF may contain any bytes: those that are not UTF-8 are replaced, because dump() would throw for them.
      return row.dump(-1, ' ', false, Row::error_handler_t::replace);
    case RowFormat::Npy:
      break;
  }
  throw std::logic_error("a row of .npy is no text");
}

}  // namespace

OutputFormat stateFormat(RowFormat format, const PairSelection& selection, std::size_t pairs, LevelColumn levels) {
  if (selection.kind == PairSelection::Kind::Any)
    return {format, csvHeader(verdictColumns(0, Verdict::Unknown, "", "")), npyIntegerFor(pairs).type()};
  const scene::LevelThresholds any;
  const Row columns = stateColumns(0, {}, {{}, nullptr}, levels == LevelColumn::With ? &any : nullptr);
  return {format, csvHeader(columns), npyPairType()};
}

OutputFormat segmentFormat(RowFormat format) { return {format, csvHeader(segmentColumns({}, {})), ""}; }

std::string rowText(const SegmentClearance& answer, const scene::RobotModel& robot, RowFormat format) {
  Row row = segmentColumns(answer, robot);
  if (format == RowFormat::Json)
    row["contact_state"] =
        answer.contact.contact ? namedPositions(robot, answer.segment.positionsAt(answer.contact.t_contact)) : Row();
  return textOf(row, format);
}

PairColumns::PairColumns(const std::vector<scene::ShapeRefPair>& pairs, std::size_t links)
    : links_(links), numbers_(links * links, -1) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto a = static_cast<std::size_t>(pairs[i].a.link()), b = static_cast<std::size_t>(pairs[i].b.link());
    numbers_[a * links + b] = static_cast<int>(i);
  }
}

int PairColumns::of(const scene::ShapeRefPair& pair) const {
  if (!pair.areLinks()) return -1;
  return numbers_[static_cast<std::size_t>(pair.a.link()) * links_ + static_cast<std::size_t>(pair.b.link())];
}

StateRows::StateRows(const ClearanceQuestion& question, RowFormat format)
    : question_(question),
      format_(format),
      between_(this->format().between),
      numbers_(question.pairs, question.model->robot.links.size()),
      integer_(npyIntegerFor(question.pairs.size())) {
  if (question.selection.kind != PairSelection::Kind::Any || format == RowFormat::Npy) return;
  const std::vector<scene::Link>& links = question.model->robot.links;
  for (const scene::ShapeRefPair& pair : question.pairs)
    below_.push_back(restOf(Verdict::Below, links[pair.a.link()].name, links[pair.b.link()].name));
  above_ = restOf(Verdict::Above, "", "");
  unknown_ = restOf(Verdict::Unknown, "", "");
  const std::string row = textOf(verdictColumns(0, Verdict::Unknown, "", ""), format);
  verdict_begin_ = row.substr(0, row.find('0'));
}

OutputFormat StateRows::format() const {
  return stateFormat(format_, question_.selection, question_.pairs.size(),
                     question_.thresholds ? LevelColumn::With : LevelColumn::Without);
}

void StateRows::addPair(std::uint64_t state, const scene::PairProximity& pair, const scene::Objects* objects,
                        WrittenRows& to) const {
  const scene::LevelThresholds* const thresholds = question_.thresholds ? &*question_.thresholds : nullptr;
  if (format_ == RowFormat::Npy) {
    appendNpy({state, numbers_.of(pair.asked), pair.result.distance, pair.result.lower_bound, pair.result.upper_bound},
              to.bytes);
  } else {
    separate(to);
    const Surroundings named{question_.model->robot, objects};
    to.bytes += textOf(stateColumns(static_cast<long>(state), pair, named, thresholds), format_);
  }
  ++to.rows;
}

void StateRows::addVerdict(std::uint64_t state, Verdict verdict, const scene::ShapeRefPair& pair,
                           const scene::Objects* objects, WrittenRows& to) const {
  constexpr int kAbove = -1, kUnknown = -2;
  const bool is_below = verdict == Verdict::Below;
  const int number = is_below ? numbers_.of(pair) : verdict == Verdict::Above ? kAbove : kUnknown;
  const scene::RobotModel& robot = question_.model->robot;
  if (format_ == RowFormat::Npy) {
    integer_.append(number, to.bytes);
  } else if (!is_below) {
    addVerdictText(state, verdict == Verdict::Above ? above_ : unknown_, to);
  } else if (number >= 0) {
    addVerdictText(state, below_[number], to);
  } else {
    addVerdictText(state, restOf(verdict, nameOf(pair.a, robot, objects), nameOf(pair.b, robot, objects)), to);
  }
  ++to.rows;
}

void StateRows::separate(WrittenRows& to) const {
  if (to.rows > 0) to.bytes += between_;
}

void StateRows::addVerdictText(std::uint64_t state, const std::string& rest, WrittenRows& to) const {
  std::array<char, 24> digits;
  char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), state).ptr;
  separate(to);
  to.bytes += verdict_begin_;
  to.bytes.append(digits.data(), static_cast<std::size_t>(end - digits.data()));
  to.bytes += rest;
}

/// The text of a row behind the number of its state.
std::string StateRows::restOf(Verdict verdict, const std::string& link_a, const std::string& link_b) const {
  const std::string row = textOf(verdictColumns(0, verdict, link_a, link_b), format_);
  return row.substr(row.find('0') + 1);
}

}  // namespace proximity_server::tools
