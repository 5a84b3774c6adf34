#include <yaml.h>

#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/model/names.h"
#include "system/number_text.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace proximity_server::scene {
namespace {

/// A mesh of 200,000 triangles, the largest that is read, has about 2 million values.
constexpr int kMostValues = 10'000'000;
/// The fields of objects are nested at most seven deep.
constexpr int kDeepest = 50;

/// One step of the parser. Its memory is freed at the end of its scope.
class Event {
 public:
  explicit Event(yaml_parser_t& parser) : is_read_(yaml_parser_parse(&parser, &event_) != 0) {}
  ~Event() {
    if (is_read_) yaml_event_delete(&event_);
  }
  Event(const Event&) = delete;
  Event& operator=(const Event&) = delete;

  bool isRead() const { return is_read_; }
  const yaml_event_t& get() const { return event_; }
  int line() const { return static_cast<int>(event_.start_mark.line) + 1; }

 private:
  yaml_event_t event_{};
  bool is_read_;
};

std::string_view textOf(const yaml_event_t& scalar) {
  return {reinterpret_cast<const char*>(scalar.data.scalar.value), scalar.data.scalar.length};
}

/// The finite number that a text is; nullopt if it is anything else.
std::optional<double> finiteNumberIn(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const std::optional<double> number = system::numberIn<double>(text);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

bool isAnyOf(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), text) != words.end();
}

decltype(FileValue::content) plainScalar(std::string_view text) {
  if (isAnyOf(text, {"", "~", "null", "Null", "NULL"})) return std::monostate();
  if (isAnyOf(text, {"true", "True", "TRUE"})) return true;
  if (isAnyOf(text, {"false", "False", "FALSE"})) return false;
  if (const std::optional<double> number = finiteNumberIn(text)) return *number;
  return std::string(text);
}

class YamlReader {
 public:
  YamlReader(const std::string& text, const std::string& source) : source_(source) {
    if (yaml_parser_initialize(&parser_) == 0) throw std::bad_alloc();
    yaml_parser_set_input_string(&parser_, reinterpret_cast<const unsigned char*>(text.data()), text.size());
  }
  ~YamlReader() { yaml_parser_delete(&parser_); }
  YamlReader(const YamlReader&) = delete;
  YamlReader& operator=(const YamlReader&) = delete;

  FileValue document() {
    FileValue root;
    bool has_document = false;
    for (;;) {
      const Event event(parser_);
      require(event);
      if (event.get().type == YAML_STREAM_END_EVENT) return root;
      if (event.get().type != YAML_DOCUMENT_START_EVENT) continue;
      if (std::exchange(has_document, true)) refuse(event.line(), "a second document begins: only one is read");
      const Event first(parser_);
      require(first);
      root = value(first, 0);
    }
  }

 private:
  FileValue value(const Event& event, int depth) {
    if (++values_ > kMostValues)
      refuse(event.line(), "there are more than 10 million values; large meshes go into files");
    if (depth > kDeepest) refuse(event.line(), "it is nested too deep");
    FileValue result;
    result.line = event.line();
    const yaml_event_t& at = event.get();
    switch (at.type) {
      case YAML_SCALAR_EVENT:
        requireNoTag(event, at.data.scalar.tag);
        if (at.data.scalar.style == YAML_PLAIN_SCALAR_STYLE)
          result.content = plainScalar(textOf(at));
        else
          result.content = std::string(textOf(at));
        break;
      case YAML_SEQUENCE_START_EVENT:
        requireNoTag(event, at.data.sequence_start.tag);
        result.content = list(depth);
        break;
      case YAML_MAPPING_START_EVENT:
        requireNoTag(event, at.data.mapping_start.tag);
        result.content = map(depth);
        break;
      default:
        refuse(event.line(), "an alias (*name) is not read: write the value out");
    }
    return result;
  }

  FileValue::List list(int depth) {
    FileValue::List entries;
    for (;;) {
      const Event event(parser_);
      require(event);
      if (event.get().type == YAML_SEQUENCE_END_EVENT) return entries;
      entries.push_back(value(event, depth + 1));
    }
  }

  FileValue::Map map(int depth) {
    FileValue::Map members;
    for (;;) {
      const Event key(parser_);
      require(key);
      if (key.get().type == YAML_MAPPING_END_EVENT) return requireEachOnce(members);
      if (key.get().type != YAML_SCALAR_EVENT) refuse(key.line(), "the name of a field must be a text");
      const Event event(parser_);
      require(event);
      members.push_back({std::string(textOf(key.get())), value(event, depth + 1)});
    }
  }

  FileValue::Map requireEachOnce(FileValue::Map& members) const {
    std::vector<std::pair<std::string_view, int>> names;
    for (const FileValue::Member& member : members) names.emplace_back(member.name, member.value.line);
    std::sort(names.begin(), names.end());
    const auto same = [](const auto& a, const auto& b) { return a.first == b.first; };
    const auto twice = std::adjacent_find(names.begin(), names.end(), same);
    if (twice != names.end()) refuse((twice + 1)->second, "there are two fields " + quoted(std::string(twice->first)));
    return std::move(members);
  }

  void requireNoTag(const Event& event, const yaml_char_t* tag) const {
    if (tag) refuse(event.line(), "a tag (!name) is not read");
  }

  void require(const Event& event) const {
    if (event.isRead()) return;
    if (parser_.error == YAML_MEMORY_ERROR) throw std::bad_alloc();
    const std::string problem = parser_.problem ? parser_.problem : "it cannot be read";
    const std::string context = parser_.context ? std::string(parser_.context) + ": " : "";
    refuse(static_cast<int>(parser_.problem_mark.line) + 1, "this is no YAML: " + context + problem);
  }

  [[noreturn]] void refuse(int line, const std::string& reason) const {
    throw std::invalid_argument(source_ + ", line " + std::to_string(line) + ": " + reason);
  }

  const std::string& source_;
  yaml_parser_t parser_{};
  int values_ = 0;
};

}  // namespace

FileValue readYaml(const std::string& text, const std::string& source) { return YamlReader(text, source).document(); }

std::string yamlName(const std::string& name) {
  static const std::set<std::string> words{"y", "n", "yes", "no", "on", "off", "true", "false", "null"};
  static const std::string letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_";
  std::string lower = name, escaped;
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  for (const char c : name) escaped += (c == '"' || c == '\\' ? "\\" : "") + std::string(1, c);
  const bool is_plain = !name.empty() && letters.find(name[0]) != std::string::npos &&
                        name.find_first_not_of(letters + "0123456789.-/") == std::string::npos && !words.count(lower);
  return is_plain ? name : "\"" + escaped + "\"";
}

}  // namespace proximity_server::scene
