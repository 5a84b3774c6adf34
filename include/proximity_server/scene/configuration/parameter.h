#pragma once

#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "proximity_server/scene/objects/object_rules.h"

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace proximity_server::scene {

/// The interval of the numbers that a parameter may have; both ends belong to it.
struct Range {
  double lowest = 0.0, highest = 0.0;

  std::string text() const;  ///< "[0, 100]"
};

/// The largest accelerations or decelerations of joints [rad/s^2] or [m/s^2], or their largest errors [rad] or [m].
struct JointLimits {
  std::optional<double> of_all;            ///< the limit of all joints which are not named; without it they have none
  std::map<std::string, double> of_joint;  ///< by name
};

/// A row of a table of parameters: values are read by it, and documented.
struct Parameter {
  /// The moment from which a new value counts in a node: at once (dynamic_reconfigure), with the service ~reload, or at
  /// the next start.
  enum class Change : unsigned char { Live, Reload, Start };

  using Names = PairFilterOptions::Names;
  using Field = std::variant<double*, int*, bool*, std::string*, std::vector<std::string>*, std::vector<Names>*,
                             std::vector<std::pair<Names, double>>*, std::map<std::string, double>*, JointLimits*,
                             ObjectFile*, ObjectRules::FreeObjects*, FileValue*>;

  std::string name;
  Field field;       ///< points into the configuration of the table; it begins with the default
  Range range;       ///< the range of each number in the field, if there are any
  std::string unit;  ///< "" if it has none
  Change change = Change::Reload;
  std::string text;     ///< in Markdown; dynamic_reconfigure shows only the first sentence
  std::string heading;  ///< heading of the rows from this one on; "" if the heading above stays
};

/// Makes the rows of a table.
struct ParameterRows {
  std::vector<Parameter> rows;
  std::string heading;  ///< of the next row

  void operator()(const char* name, const Parameter::Field& field, const Range& range, const char* unit,
                  Parameter::Change change, const char* text);
};

/// Reads the members of a map into the fields of parameters, and remembers the names that it was asked for.
///
/// Failure: throws std::invalid_argument with the place, the name and the demand: "parameter /node/rate must be a
///          number", "robot.yaml, line 3: link_padding/wrist is -1, outside of [0, 10]".
class ParameterReader {
 public:
  /// A value that is no map has no members. `values` must outlive the reader. `source` is the name of the file, if the
  /// value has lines, otherwise a namespace of ROS. Relative paths of meshes begin in `folder`.
  ParameterReader(const FileValue& values, std::string source, std::string folder = {});

  void read(const Parameter& parameter);

  /// The value of a name; nullptr if it is not set.
  const FileValue* find(const std::string& name);
  /// Reads a text, if it is set.
  void read(const std::string& name, std::string& text);
  std::vector<std::string> texts(const FileValue& value, const std::string& name) const;

  bool isSet(const std::string& name) const;

  /// Refuses the parameter unless the condition is true. `at`: the value that is wrong, if it is a part.
  void require(bool condition, const std::string& name, const std::string& demand, const FileValue* at = nullptr) const;

  /// The members that nobody asked for.
  std::vector<std::string> unknown() const;
  const std::vector<std::string>& known() const { return known_; }

  /// The beginning of a message, before the name: "parameter /node/", "robot.yaml, line 3: ".
  std::string place(int line = 0) const;

 private:
  struct Setter;

  const FileValue::Map& values_;
  bool has_lines_;
  std::string source_, folder_;
  std::vector<std::string> known_;
};

}  // namespace proximity_server::scene
