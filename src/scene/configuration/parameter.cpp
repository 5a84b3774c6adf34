#include "proximity_server/scene/configuration/parameter.h"

#include "proximity_server/scene/model/names.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

const FileValue::Map& membersOf(const FileValue& value) {
  static const FileValue::Map kNone;
  const auto* const members = std::get_if<FileValue::Map>(&value.content);
  return members ? *members : kNone;
}

const FileValue* memberOf(const FileValue& value, const std::string& name) {
  const FileValue::Map& members = membersOf(value);
  const int found = findNamed(members, name);
  return found < 0 ? nullptr : &members[found].value;
}

/// An example of a list of pairs for an error message. If the user's flat list begins with two names, the example has
/// these.
std::string exampleOfPairs(const FileValue::List& flat) {
  const auto textAt = [&](std::size_t i) {
    return i < flat.size() ? std::get_if<std::string>(&flat[i].content) : nullptr;
  };
  if (!textAt(0) || !textAt(1)) return "[[a, b]]";
  return "[[" + *textAt(0) + ", " + *textAt(1) + "]]";
}

}  // namespace

std::string Range::text() const { return "[" + shortest(lowest) + ", " + shortest(highest) + "]"; }

void ParameterRows::operator()(const char* name, const Parameter::Field& field, const Range& range, const char* unit,
                               Parameter::Change change, const char* text) {
  rows.push_back({name, field, range, unit, change, text, std::exchange(heading, "")});
}

/// Sets a field of each type.
struct ParameterReader::Setter {
  const ParameterReader& reader;
  const FileValue& value;
  const Parameter& parameter;

  void operator()(std::string* target) const { *target = text(value); }
  void operator()(std::vector<std::string>* target) const {
    const auto* const one = std::get_if<std::string>(&value.content);
    *target = one ? std::vector<std::string>{*one} : reader.texts(value, parameter.name);
  }
  void operator()(bool* target) const {
    const auto* const truth = std::get_if<bool>(&value.content);
    require(truth, "must be true or false");
    *target = *truth;
  }
  void operator()(ObjectRules::FreeObjects* target) const {
    bool is_checked = false;
    (*this)(&is_checked);
    *target = is_checked ? ObjectRules::FreeObjects::Checked : ObjectRules::FreeObjects::NotChecked;
  }
  void operator()(double* target) const { *target = number(value, parameter.name); }
  void operator()(int* target) const {
    const auto* const given = std::get_if<double>(&value.content);
    require(given && *given == std::floor(*given), "must be a whole number");
    *target = static_cast<int>(number(value, parameter.name));
  }
  void operator()(std::map<std::string, double>* target) const {
    require(std::holds_alternative<FileValue::Map>(value.content), "must map names to numbers");
    for (const auto& [key, entry] : membersOf(value))
      (*target)[key] = number(entry, std::string(parameter.name).append("/").append(key));
  }
  void operator()(JointLimits* target) const {
    if (std::holds_alternative<FileValue::Map>(value.content)) return (*this)(&target->of_joint);
    require(std::holds_alternative<double>(value.content), "must be a number, or map names of joints to numbers");
    target->of_all = number(value, parameter.name);
  }
  void operator()(std::vector<Parameter::Names>* target) const {
    for (const FileValue& entry : entries()) {
      require(std::holds_alternative<FileValue::List>(entry.content),
              "must be a list of pairs, with brackets around each of them: " + exampleOfPairs(entries()), &entry);
      target->push_back(pairOfNames(entry));
    }
  }
  void operator()(std::vector<std::pair<Parameter::Names, double>>* target) const {
    const std::string key = parameter.name.substr(parameter.name.rfind('_') + 1);  // "padding" of pair_padding
    for (const FileValue& entry : entries()) {
      const FileValue *const links = memberOf(entry, "links"), *const distance = memberOf(entry, key);
      require(links && distance, "must list entries of the form {links: [a, b], " + key + ": 0.01}", &entry);
      target->emplace_back(pairOfNames(*links), number(*distance, parameter.name));
    }
  }
  void operator()(ObjectFile* target) const {
    *target =
        objectFileFrom(value, reader.has_lines_ ? reader.source_ : reader.place() + parameter.name, reader.folder_);
  }
  void operator()(FileValue* target) const { *target = value; }

 private:
  void require(bool condition, const std::string& demand, const FileValue* at = nullptr) const {
    reader.require(condition, parameter.name, demand, at);
  }

  const FileValue::List& entries() const {
    const auto* const list = std::get_if<FileValue::List>(&value.content);
    require(list, "must be a list");
    return *list;
  }

  double number(const FileValue& of, const std::string& name) const {
    const auto* const given = std::get_if<double>(&of.content);
    reader.require(given, name, "must be a number", &of);
    const Range& range = parameter.range;
    // Written with >= and <= so that NaN is outside of every range.
    reader.require(*given >= range.lowest && *given <= range.highest, name,
                   "is " + shortest(*given) + ", outside of " + range.text(), &of);
    return *given;
  }

  const std::string& text(const FileValue& of) const {
    const auto* const given = std::get_if<std::string>(&of.content);
    require(given, "must be a text");
    return *given;
  }

  Parameter::Names pairOfNames(const FileValue& of) const {
    const std::vector<std::string> names = reader.texts(of, parameter.name);
    require(names.size() == 2, "must name two links per pair", &of);
    return {names[0], names[1]};
  }
};

ParameterReader::ParameterReader(const FileValue& values, std::string source, std::string folder)
    : values_(membersOf(values)), has_lines_(values.line > 0), source_(std::move(source)), folder_(std::move(folder)) {}

void ParameterReader::read(const Parameter& parameter) {
  if (const FileValue* const value = find(parameter.name))
    std::visit(Setter{*this, *value, parameter}, parameter.field);
}

const FileValue* ParameterReader::find(const std::string& name) {
  known_.push_back(name);
  const int found = findNamed(values_, name);
  return found < 0 ? nullptr : &values_[found].value;
}

void ParameterReader::read(const std::string& name, std::string& text) {
  Parameter parameter;
  parameter.name = name;
  parameter.field = &text;
  read(parameter);
}

std::vector<std::string> ParameterReader::texts(const FileValue& value, const std::string& name) const {
  const auto* const list = std::get_if<FileValue::List>(&value.content);
  require(list, name, "must be a list of texts", &value);
  std::vector<std::string> result;
  for (const FileValue& entry : *list) {
    const auto* const text = std::get_if<std::string>(&entry.content);
    require(text, name, "must be a text", &entry);
    result.push_back(*text);
  }
  return result;
}

bool ParameterReader::isSet(const std::string& name) const { return findNamed(values_, name) >= 0; }

void ParameterReader::require(bool condition, const std::string& name, const std::string& demand,
                              const FileValue* at) const {
  if (condition) return;
  const int member = findNamed(values_, name.substr(0, name.find('/')));
  const int line = at ? at->line : member < 0 ? 0 : values_[member].value.line;
  throw std::invalid_argument(place(line) + name + " " + demand);
}

std::string ParameterReader::place(int line) const {
  if (!has_lines_) return "parameter " + source_ + "/";
  return source_ + (line > 0 ? ", line " + std::to_string(line) : "") + ": ";
}

std::vector<std::string> ParameterReader::unknown() const {
  std::vector<std::string> names;
  for (const FileValue::Member& member : values_)
    if (std::find(known_.begin(), known_.end(), member.name) == known_.end()) names.push_back(member.name);
  return names;
}

}  // namespace proximity_server::scene
