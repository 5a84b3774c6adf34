#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "proximity_server/scene/object_files/file_value.h"

namespace proximity_server::scene {

/// A value with the way that leads to it, so that a message can name its place: "cell.yaml, line 3: objects[0] "table"/padding".
/// It refers to the value and to the field that it is in, which must outlive it.
///
/// Failure: all functions throw std::invalid_argument naming the place and the reason.
class Field {
 public:
  Field(const FileValue& value, const std::string& source) : value_(value), source_(source) {}

  /// The member of a map; nullopt if it is not there or null.
  std::optional<Field> find(const std::string& name) const;
  /// The same for one that must be there.
  Field member(const std::string& name) const;
  /// The entries of a list.
  std::vector<Field> entries() const;

  bool isList() const { return std::holds_alternative<FileValue::List>(value_.content); }
  bool isText() const { return std::holds_alternative<std::string>(value_.content); }

  double number() const;     ///< finite
  long wholeNumber() const;  ///< at least 0
  bool truth() const;
  const std::string& text() const;
  std::vector<double> numbers() const;
  std::vector<std::string> texts() const;

  /// The names of a map.
  std::vector<std::string> members() const;

  /// Refuses a map with another name, and anything but a map.
  void requireMembers(const std::vector<std::string>& names) const;

  [[noreturn]] void refuse(const std::string& reason) const;

  /// "cell.yaml, line 3: objects[0] "table""
  std::string place() const;

 private:
  Field(const FileValue& value, const Field& parent, std::string name, int index)
      : value_(value), source_(parent.source_), parent_(&parent), name_(std::move(name)), index_(index) {}

  std::string path() const;
  const FileValue::Map& map() const;

  const FileValue& value_;
  const std::string& source_;
  const Field* parent_ = nullptr;
  std::string name_;  ///< of a member
  int index_ = -1;    ///< of an entry of a list
};

}  // namespace proximity_server::scene
