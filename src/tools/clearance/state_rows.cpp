#include "tools/clearance/state_rows.h"

#include <array>
#include <charconv>
#include <nlohmann/json.hpp>

#include "tools/command_line/csv.h"

namespace proximity_server::tools {
namespace {

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

std::string jsonText(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

constexpr const char* kVerdictHeader = "state,verdict,link_a,link_b";
constexpr const char* kVerdictBegin = "{\"state\":";

}  // namespace

PairNumbers::PairNumbers(const std::vector<scene::ShapeRefPair>& pairs, std::size_t links)
    : links_(links), numbers_(links * links, -1) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto a = static_cast<std::size_t>(pairs[i].a.link()), b = static_cast<std::size_t>(pairs[i].b.link());
    numbers_[a * links + b] = static_cast<int>(i);
  }
}

int PairNumbers::of(const scene::ShapeRefPair& pair) const {
  if (pair.hasObject()) return -1;
  return numbers_[static_cast<std::size_t>(pair.a.link()) * links_ + static_cast<std::size_t>(pair.b.link())];
}

StateRows::StateRows(const PairSelection& selection, RowFormat format, const ClearanceQuestion& question)
    : question_(question),
      selection_(selection),
      format_(format),
      robot_(question.model->robot),
      numbers_(question.pairs, robot_.links.size()),
      separator_(rowsSeparator(format)),
      integer_(npyIntegerFor(question.pairs.size())) {
  if (selection.kind != PairSelection::Kind::Any || format == RowFormat::Npy) return;
  for (const scene::ShapeRefPair& pair : question.pairs)
    below_.push_back(restOf(Verdict::Below, nameOf(pair.a, robot_), nameOf(pair.b, robot_)));
  above_ = restOf(Verdict::Above, "", "");
  unknown_ = restOf(Verdict::Unknown, "", "");
}

OutputFormat StateRows::format() const {
  const LevelColumn levels = question_.thresholds ? LevelColumn::With : LevelColumn::Without;
  return StateRows::format(selection_, format_, question_.pairs.size(), levels);
}

OutputFormat StateRows::format(const PairSelection& selection, RowFormat format, std::size_t pairs,
                               LevelColumn levels) {
  const bool is_verdict = selection.kind == PairSelection::Kind::Any;
  OutputFormat made;
  if (format == RowFormat::Npy) {
    made.name = "npy";
    made.npy_type = is_verdict ? npyIntegerFor(pairs).type() : npyPairType();
    return made;
  }
  const bool is_csv = format == RowFormat::Csv;
  made.name = is_csv ? "csv" : "json";
  made.begin = is_csv && is_verdict ? kVerdictHeader : rowsBegin(RowKind::State, format, levels);
  made.between = rowsSeparator(format);
  made.before_first = "\n";
  made.end = rowsEnd(format);
  return made;
}

void StateRows::addPair(std::uint64_t state, const scene::PairProximity& pair, const scene::Objects* objects,
                        WrittenRows& to) const {
  if (format_ == RowFormat::Npy) {
    appendNpy({state, numbers_.of(pair.asked), pair.result.distance, pair.result.lower_bound, pair.result.upper_bound},
              to.bytes);
  } else {
    if (to.rows > 0) to.bytes += separator_;
    to.bytes += rowText(static_cast<long>(state), pair, robot_, objects, format_,
                        question_.thresholds ? &*question_.thresholds : nullptr);
  }
  ++to.rows;
}

void StateRows::addVerdict(std::uint64_t state, Verdict verdict, int pair, WrittenRows& to) const {
  if (format_ == RowFormat::Npy) {
    constexpr int kAbove = -1, kUnknown = -2;
    integer_.append(verdict == Verdict::Below ? pair : verdict == Verdict::Above ? kAbove : kUnknown, to.bytes);
    ++to.rows;
  } else {
    const bool is_below = verdict == Verdict::Below;
    addVerdictText(state,
                   is_below                    ? below_[static_cast<std::size_t>(pair)]
                   : verdict == Verdict::Above ? above_
                                               : unknown_,
                   to);
  }
}

void StateRows::addVerdict(std::uint64_t state, Verdict verdict, const scene::ShapeRefPair& pair,
                           const scene::Objects* objects, WrittenRows& to) const {
  if (format_ == RowFormat::Npy || verdict != Verdict::Below) return addVerdict(state, verdict, numbers_.of(pair), to);
  addVerdictText(state, restOf(verdict, nameOf(pair.a, robot_, objects), nameOf(pair.b, robot_, objects)), to);
}

void StateRows::addVerdictText(std::uint64_t state, const std::string& rest, WrittenRows& to) const {
  std::array<char, 24> digits;
  char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), state).ptr;
  if (to.rows > 0) to.bytes += separator_;
  if (format_ == RowFormat::Json) to.bytes += kVerdictBegin;
  to.bytes.append(digits.data(), static_cast<std::size_t>(end - digits.data()));
  to.bytes += rest;
  ++to.rows;
}

std::string StateRows::restOf(Verdict verdict, const std::string& link_a, const std::string& link_b) const {
  if (format_ == RowFormat::Csv)
    return std::string(",") + verdictName(verdict) + "," + csvField(link_a) + "," + csvField(link_b);
  return std::string(",\"verdict\":\"") + verdictName(verdict) + "\",\"link_a\":" + jsonText(link_a) +
         ",\"link_b\":" + jsonText(link_b) + "}";
}

}  // namespace proximity_server::tools
