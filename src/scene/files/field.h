#pragma once

#include "proximity_server/scene/files/file_value.h"

#include <Eigen/Core>

#include <initializer_list>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// Returns make(arguments...). A std::invalid_argument of it becomes what refuse(reason) throws.
template <class Refuse, class Make, class... Arguments>
auto refusedBy(const Refuse& refuse, const Make& make, Arguments&&... arguments) {
  try {
    return make(std::forward<Arguments>(arguments)...);
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
    throw;
  }
}

/// A value with its path in the file, so that a message can name its place: "cell.yaml, line 3: objects[0]
/// "table"/padding". It refers to the value and to the field that contains it, which must outlive it.
///
/// Failure: all functions throw std::invalid_argument with the place and the reason.
class Field {
 public:
  /// warn() adds to `warnings`, which must live as long; nullptr: nobody wants them.
  Field(const FileValue& value, const std::string& source, std::vector<std::string>* warnings = nullptr)
      : value_(value), source_(source), warnings_(warnings) {}

  /// The member of a map; nullopt if it does not exist or is null.
  std::optional<Field> find(const std::string& name) const;
  /// Like find(), but throws if the member does not exist.
  Field member(const std::string& name) const;
  /// The entries of a list.
  std::vector<Field> entries() const;

  bool isList() const { return std::holds_alternative<FileValue::List>(value_.content); }
  bool isMap() const { return std::holds_alternative<FileValue::Map>(value_.content); }
  bool isText() const { return std::holds_alternative<std::string>(value_.content); }

  double number() const;  ///< finite
  /// A finite number, or an angle like "0.5deg" of something that turns, [rad].
  double angle(bool turns = true) const;
  long wholeNumber() const;  ///< at least 0
  bool truth() const;
  const std::string& text() const;
  std::vector<double> numbers() const;
  std::vector<std::string> texts() const;

  /// The names of the members of a map.
  std::vector<std::string> members() const;

  /// Refuses a map with any other name, and a value that is not a map.
  void requireMembers(const std::vector<std::string>& names) const;

  [[noreturn]] void refuse(const std::string& reason) const;
  void warn(const std::string& what) const;

  /// Returns make(arguments...). Its std::invalid_argument becomes one of this field.
  template <class Make, class... Arguments>
  auto checked(const Make& make, Arguments&&... arguments) const {
    return refusedBy([this](const std::string& reason) { refuse(reason); }, make,
                     std::forward<Arguments>(arguments)...);
  }

  /// Returns a text like: cell.yaml, line 3: objects[0] "table"
  std::string place() const;

 private:
  Field(const FileValue& value, const Field& parent, std::string name, int index)
      : value_(value),
        source_(parent.source_),
        warnings_(parent.warnings_),
        parent_(&parent),
        name_(std::move(name)),
        index_(index) {}

  std::string path() const;
  const FileValue::Map& map() const;

  const FileValue& value_;
  const std::string& source_;
  std::vector<std::string>* warnings_;
  const Field* parent_ = nullptr;
  std::string name_;  ///< if it is a member of a map
  int index_ = -1;    ///< if it is an entry of a list
};

}  // namespace proximity_server::scene
