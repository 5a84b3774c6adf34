#include "scene/files/field.h"

#include "proximity_server/scene/model/names.h"
#include "system/number_text.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace proximity_server::scene {

std::optional<Field> Field::find(const std::string& name) const {
  const FileValue::Map& members = map();
  const int found = findNamed(members, name);
  if (found < 0 || std::holds_alternative<std::monostate>(members[found].value.content)) return std::nullopt;
  return Field(members[found].value, *this, name, -1);
}

Field Field::member(const std::string& name) const {
  if (const std::optional<Field> found = find(name)) return *found;
  refuse("there is no field " + quoted(name));
}

std::vector<Field> Field::entries() const {
  const auto* list = std::get_if<FileValue::List>(&value_.content);
  if (!list) refuse("must be a list");
  std::vector<Field> fields;
  fields.reserve(list->size());
  for (const FileValue& entry : *list) fields.push_back(Field(entry, *this, "", static_cast<int>(fields.size())));
  return fields;
}

double Field::number() const {
  const auto* number = std::get_if<double>(&value_.content);
  if (!number || !std::isfinite(*number)) refuse("must be a finite number");
  return *number;
}

double Field::angle(bool turns) const {
  if (!isText()) return number();
  const auto angle = system::positionIn(text());
  if (!angle || !angle->is_in_degrees) refuse("must be a finite number" + std::string(turns ? ", or like 0.5deg" : ""));
  if (!turns) refuse("must be in metres, not an angle");
  return angle->value;
}

long Field::wholeNumber() const {
  constexpr double kMost = 1e15;  // whole numbers are exact up to this one
  const double value = number();
  if (!(value >= 0.0 && value <= kMost) || value != std::floor(value)) refuse("must be a whole number of at least 0");
  return static_cast<long>(value);
}

bool Field::truth() const {
  const auto* truth = std::get_if<bool>(&value_.content);
  if (!truth) refuse("must be true or false");
  return *truth;
}

const std::string& Field::text() const {
  const auto* text = std::get_if<std::string>(&value_.content);
  if (!text) refuse("must be a text; a number is one in quotes");
  return *text;
}

std::vector<double> Field::numbers() const {
  std::vector<double> result;
  for (const Field& entry : entries()) result.push_back(entry.number());
  return result;
}

std::vector<std::string> Field::texts() const {
  std::vector<std::string> result;
  for (const Field& entry : entries()) result.push_back(entry.text());
  return result;
}

std::vector<std::string> Field::members() const { return namesOf(map()); }

void Field::requireMembers(const std::vector<std::string>& names) const {
  for (const FileValue::Member& member : map()) {
    if (std::find(names.begin(), names.end(), member.name) != names.end()) continue;
    const std::string nearest = nearestName(member.name, names);
    Field(member.value, *this, member.name, -1)
        .refuse("there is no such field" + (nearest.empty() ? "" : " (did you mean " + quoted(nearest) + "?)"));
  }
}

void Field::refuse(const std::string& reason) const { throw std::invalid_argument(place() + ": " + reason); }

std::string Field::place() const {
  const std::string keys = path();
  return source_ + (value_.line > 0 ? ", line " + std::to_string(value_.line) : "") + (keys.empty() ? "" : ": " + keys);
}

void Field::warn(const std::string& what) const {
  if (warnings_) warnings_->push_back(place() + ": " + what);
}

std::string Field::path() const {
  const std::string above = parent_ ? parent_->path() : "";
  if (index_ < 0) return above + (above.empty() || name_.empty() ? "" : "/") + name_;
  std::string id;
  if (const auto* members = std::get_if<FileValue::Map>(&value_.content)) {
    const int found = findNamed(*members, "id");
    const auto* text = found < 0 ? nullptr : std::get_if<std::string>(&(*members)[found].value.content);
    if (text) id = " " + quoted(*text);
  }
  return above + "[" + std::to_string(index_) + "]" + id;
}

const FileValue::Map& Field::map() const {
  const auto* members = std::get_if<FileValue::Map>(&value_.content);
  if (!members) refuse("must be a map of fields");
  return *members;
}

}  // namespace proximity_server::scene
