#include "tools/clearance/clearance_rows.h"

#include "proximity_server/scene/levels/clearance_level.h"
#include "tools/robot/robot_text.h"
#include "tools/text/csv.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string_view>

namespace proximity_server::tools {
namespace {

using Json = nlohmann::ordered_json;

/// Appends the columns of a row to a text: their names, as the header of a CSV; their values, as a row of it; or both, as
/// an object of JSON. The same functions add the columns to all three, so that these cannot differ.
class Row {
 public:
  enum class Form : unsigned char { CsvHeader, CsvRow, JsonObject };

  Row(Form form, std::string& to) : form_(form), to_(to) {}
  Row(RowFormat format, std::string& to) : Row(formOf(format), to) {}

  template <typename Value>
  void add(std::string_view column, const Value& value) {
    if (has_columns_ || isJson()) to_ += has_columns_ ? ',' : '{';
    has_columns_ = true;
    if (isJson()) to_ += '"';
    if (form_ != Form::CsvRow) to_ += column;
    if (isJson()) to_ += "\":";
    if (form_ != Form::CsvHeader) append(value);
  }

  /// Ends a row, which must have columns.
  void end() {
    if (isJson()) to_ += '}';
  }

 private:
  /// Only CSV and JSON have this form; npy has none.
  static Form formOf(RowFormat format) {
    switch (format) {
      case RowFormat::Csv:
        return Form::CsvRow;
      case RowFormat::Json:
        return Form::JsonObject;
      case RowFormat::Npy:
        break;
    }
    throw std::logic_error("rows of numbers have no columns with names");
  }

  bool isJson() const { return form_ == Form::JsonObject; }

  void append(std::uint64_t number) { to_ += std::to_string(number); }

  void append(std::optional<std::uint64_t> number) { to_ += number ? std::to_string(*number) : isJson() ? "null" : ""; }

  void append(double number) {
    if (!isJson()) {
      to_ += shortest(number);
      return;
    }
    if (!std::isfinite(number)) return append(Json());
    // As Json::dump() writes it, without what that allocates. Some numbers have more digits than the shortest text.
    std::array<char, 64> text;
    to_.append(text.data(), nlohmann::detail::to_chars(text.data(), text.data() + text.size(), number));
  }

  /// A word that needs no quotes in CSV.
  void append(const char* word) {
    if (isJson()) to_ += '"';
    to_ += word;
    if (isJson()) to_ += '"';
  }

  void append(const std::string& name) {
    if (isJson()) return append(Json(name));
    to_ += csvField(name);
  }

  void append(std::optional<bool> decided) {
    to_ += decided ? *decided ? "true" : "false" : isJson() ? "null" : "unknown";
  }

  /// A URDF may contain any bytes: those that are not UTF-8 are replaced, because dump() would throw for them.
  void append(const Json& json) { to_ += json.dump(-1, ' ', false, Json::error_handler_t::replace); }

  const Form form_;
  std::string& to_;
  bool has_columns_ = false;
};

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

void addVector(const std::array<const char*, 3>& columns, const Eigen::Vector3d& vector, Row& row) {
  for (int i = 0; i < 3; ++i) row.add(columns[static_cast<std::size_t>(i)], vector[i]);
}

/// A robot and what stands around it; nullptr: nothing.
struct Surroundings {
  const scene::RobotModel& robot;
  const scene::Objects* objects;
};

/// The number of a point; nullopt if it has none.
std::optional<std::uint64_t> numberOf(const scene::ShapeRef& point) {
  return point.point() < 0 ? std::nullopt : std::optional(static_cast<std::uint64_t>(point.point()));
}

void addPair(const scene::PairProximity& pair, const Surroundings& named, Row& row) {
  row.add("link_a", nameOf(pair.asked.a, named.robot, named.objects));
  if (pair.asked.b.isPoint())
    row.add("point", numberOf(pair.asked.b));
  else
    row.add("link_b", nameOf(pair.asked.b, named.robot, named.objects));
  row.add("distance", pair.result.distance);
  row.add("lower", pair.result.lower_bound);
  row.add("upper", pair.result.upper_bound);
  addVector({"point_a_x", "point_a_y", "point_a_z"}, pair.result.point_a, row);
  addVector({"point_b_x", "point_b_y", "point_b_z"}, pair.result.point_b, row);
  addVector({"normal_x", "normal_y", "normal_z"}, pair.result.normal, row);
  row.add("status", statusName(pair.result.status));
  row.add("representation", toString(pair.representation));
}

/// Whether there is contact; nullopt if that is not decided.
std::optional<bool> contactOf(const scene::RobotTimeOfContact& contact) {
  if (!contact.contact && contact.status != narrowphase::Status::Converged) return std::nullopt;
  return contact.contact;
}

void addContact(const ClearanceAnswer& answer, const Surroundings& named, Row& row) {
  const scene::ShapeRefPair& pair = answer.contact.pair.asked;
  row.add("contact", contactOf(answer.contact));
  row.add("t_free", answer.contact.t_free);
  row.add("t_contact", answer.contact.t_contact);
  row.add("contact_link_a", nameOf(pair.a, named.robot, named.objects));
  row.add("contact_link_b", nameOf(pair.b, named.robot, named.objects));
}

// These functions define the columns and their order.

/// `thresholds` and `guaranteed` are for the columns of that name; nullptr: there is none.
void addState(std::uint64_t state, const scene::PairProximity& pair, const Surroundings& named,
              const scene::LevelThresholds* thresholds, const double* guaranteed, Row& row) {
  row.add("state", state);
  addPair(pair, named, row);
  const bool is_known = pair.result.status != narrowphase::Status::Unknown;
  const auto level = [&] {
    return guaranteed ? levelOf(pair, *guaranteed, *thresholds).level : levelOf(pair, *thresholds).level;
  };
  if (thresholds) row.add("level", is_known ? toString(level()) : "INVALID");
  if (guaranteed) row.add("guaranteed", *guaranteed);
}

void addSegment(const ClearanceAnswer& answer, const ClearanceQuestion& question, Row& row) {
  scene::PairProximity closest = answer.closest.pair;
  closest.result.status = answer.closest.status;
  row.add("segment", static_cast<std::uint64_t>(answer.number));
  row.add("t_begin", answer.begin);
  row.add("t_end", answer.end);
  row.add("t_minimum", answer.closest.time);
  const Surroundings named{question.model->robot, answer.objects.get()};
  addPair(closest, named, row);
  addContact(answer, named, row);
  if (!question.thresholds) return;
  const SegmentLevel level = answer.level.value_or(SegmentLevel());
  row.add("level", answer.level ? toString(level.level) : "INVALID");
  row.add("t_level", level.time);
  row.add("level_link_a", nameOf(level.pair.a, named.robot, named.objects));
  row.add("level_link_b", nameOf(level.pair.b, named.robot, named.objects));
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

void addVerdict(std::uint64_t state, Verdict verdict, const scene::ShapeRefPair& pair, const Surroundings& named,
                Row& row) {
  row.add("state", state);
  row.add("verdict", verdictName(verdict));
  row.add("link_a", nameOf(pair.a, named.robot, named.objects));
  row.add("link_b", nameOf(pair.b, named.robot, named.objects));
}

}  // namespace

OutputFormat stateFormat(RowFormat format, const PairSelection& selection, std::size_t pairs, StateColumns wanted) {
  std::string header;
  Row columns(Row::Form::CsvHeader, header);
  if (selection.kind == PairSelection::Kind::Any) {
    addVerdict(0, {}, {}, {{}, nullptr}, columns);
    return {format, header, npyIntegerFor(pairs).type()};
  }
  const scene::LevelThresholds any;
  const double number = 0.0;
  scene::PairProximity pair;
  if (wanted.point) pair.asked.b = scene::ShapeRef::ofPoint(0);
  addState(0, pair, {{}, nullptr}, wanted.level ? &any : nullptr, wanted.guaranteed ? &number : nullptr, columns);
  return {format, header, npyPairType()};
}

OutputFormat segmentFormat(const ClearanceQuestion& question, RowFormat format) {
  std::string header;
  Row columns(Row::Form::CsvHeader, header);
  addSegment({}, question, columns);
  return {format, header, ""};
}

std::string rowText(const ClearanceAnswer& answer, const ClearanceQuestion& question, RowFormat format) {
  std::string text;
  Row row(format, text);
  addSegment(answer, question, row);
  if (format == RowFormat::Json)
    row.add("contact_state",
            answer.contact.contact ? positionsJson(question.model->robot, answer.contact.state) : Json());
  row.end();
  return text;
}

StateRows::StateRows(const ClearanceQuestion& question, RowFormat format)
    : question_(question),
      format_(format),
      between_(this->format().between),
      links_(question.model->robot.links.size()),
      numbers_(links_ * links_, -1),
      integer_(npyIntegerFor(question.pairs.size())) {
  for (std::size_t i = 0; i < question.pairs.size(); ++i) numbers_[placeOf(question.pairs[i])] = static_cast<int>(i);
}

std::size_t StateRows::placeOf(const scene::ShapeRefPair& pair) const {
  return static_cast<std::size_t>(pair.a.link()) * links_ + static_cast<std::size_t>(pair.b.link());
}

int StateRows::numberOf(const scene::ShapeRefPair& pair) const {
  return pair.areLinks() ? numbers_[placeOf(pair)] : -1;
}

OutputFormat StateRows::format() const {
  return stateFormat(
      format_, question_.selection, question_.pairs.size(),
      {question_.thresholds.has_value(), question_.uncertainty.has_value(), question_.points.has_value()});
}

void StateRows::addPair(std::uint64_t state, const scene::PairProximity& pair, double guaranteed,
                        const scene::Objects* objects, WrittenRows& to) const {
  if (to.rows++ > 0) to.bytes += between_;
  const narrowphase::SignedDistance& result = pair.result;
  if (format_ == RowFormat::Npy)
    return appendNpy({state, numberOf(pair.asked), result.distance, result.lower_bound, result.upper_bound}, to.bytes);
  Row row(format_, to.bytes);
  addState(state, pair, {question_.model->robot, objects}, question_.thresholds ? &*question_.thresholds : nullptr,
           question_.uncertainty ? &guaranteed : nullptr, row);
  row.end();
}

void StateRows::addVerdict(std::uint64_t state, Verdict verdict, const scene::ShapeRefPair& pair,
                           const scene::Objects* objects, WrittenRows& to) const {
  if (to.rows++ > 0) to.bytes += between_;
  constexpr int kAbove = -1, kUnknown = -2;
  const bool is_below = verdict == Verdict::Below;
  if (format_ == RowFormat::Npy)
    return integer_.append(is_below ? numberOf(pair) : verdict == Verdict::Above ? kAbove : kUnknown, to.bytes);
  Row row(format_, to.bytes);
  tools::addVerdict(state, verdict, pair, {question_.model->robot, objects}, row);
  row.end();
}

}  // namespace proximity_server::tools
