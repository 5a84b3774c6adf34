#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::tools {

/// An option of a program; or an argument, which is known by its place and has no dashes before its name.
struct Option {
  std::string name, type, description;  ///< "--states", "FILE", and what the help says of it; a flag has no type
  std::function<void(const std::string& text)> read;  ///< throws std::invalid_argument if the text is no value
  std::string heading;                                ///< above it in the help
  std::string needs;                                  ///< another option, without which this one is an error
  std::set<std::string> excludes;                     ///< those with which it is an error
  bool is_required = false, is_repeatable = false, is_given = false, is_output = false;
  std::vector<std::string> texts{};  ///< those that were given
};

/// The options of a program. Each is declared with a function that takes its text; then parse() reads the command line.
class ProgramOptions {
 public:
  /// Declares --help and --version.
  ProgramOptions(const std::string& program, const std::string& about);

  /// Declares an option or an argument. The reference is valid until the next one.
  Option& add(const std::string& name, const std::string& type, const std::string& description,
              const std::function<void(const std::string& text)>& read);

  /// Declares an option or an argument whose text `read` turns into the value.
  template <typename Value, typename Read>
  Option& addRead(const std::string& name, const std::string& type, Value& value, const Read& read,
                  const std::string& description) {
    return add(name, type, description, [&value, read](const std::string& text) { value = read(text); });
  }

  /// Declares an option or an argument whose text is the value.
  template <typename Text>
  Option& addText(const std::string& name, const std::string& type, Text& value, const std::string& description) {
    return add(name, type, description, [&value](const std::string& text) { value = text; });
  }

  /// Declares an option whose text names a file that the program writes by system::WholeFile; or a folder, if its type
  /// has the word DIR. All others whose type has the word FILE name one that the program reads.
  template <typename Text>
  Option& addOutput(const std::string& name, const std::string& type, Text& value, const std::string& description) {
    Option& option = addText(name, type, value, description);
    option.is_output = true;
    return option;
  }

  /// Declares an option without a text, which sets the value.
  template <typename Value>
  Option& addFlag(const std::string& name, Value& value, const Value& set, const std::string& description) {
    return add(name, "", description, [&value, set](const std::string&) { value = set; });
  }

  /// Makes each two of these options exclude each other.
  void atMostOneOf(const std::set<std::string>& names);

  /// The heading of the options that are declared from now on.
  void setHeading(const std::string& heading = "Options") { heading_ = heading; }

  /// The end of the help.
  void setFooter(const std::string& footer) { footer_ = footer; }

  /// Reads the command line. Returns an exit code if the program ends with that: --help or --version are printed, or an
  /// error, on standard error.
  std::optional<int> parse(int argc, const char* const* argv);

  /// Notes the files that the options name as those that this process reads and writes.
  /// Failure: throws system::FileConflict if one is both, and std::invalid_argument for one that cannot be written.
  void claimFiles() const;

  Option& operator[](const std::string& name);
  const std::string& program() const { return program_; }

 private:
  std::string help() const;

  std::string program_, about_, heading_ = "Options", footer_;
  std::vector<Option> options_;
};

/// Reads a number of the command line: a finite number of at least `least`, a whole number from `least` to `most`, or a
/// positive number. Otherwise throws std::invalid_argument naming the text and the legal values.
double readLength(const std::string& text, double least);
long readCount(const std::string& text, long least, long most);
double readPositive(const std::string& text);

/// Reads one of some names, and returns its value. Otherwise throws std::invalid_argument with all names.
template <typename Value>
auto oneOf(const std::vector<std::pair<std::string, Value>>& values) {
  return [values](const std::string& text) {
    std::string names;
    for (const auto& [name, value] : values) {
      if (name == text) return value;
      names += (names.empty() ? "" : ", ") + name;
    }
    throw std::invalid_argument("'" + text + "' is none of " + names);
  };
}

/// An option that is one length [m]; `value` may be optional.
template <typename Value>
Option& addLength(ProgramOptions& program, const std::string& name, Value& value, double least,
                  const std::string& description) {
  const auto read = [least](const std::string& text) { return readLength(text, least); };
  return program.addRead(name, "METRES", value, read, description);
}

/// An option that is one whole number.
template <typename Value>
Option& addCount(ProgramOptions& program, const std::string& name, Value& value, long least, long most,
                 const std::string& description) {
  const auto read = [least, most](const std::string& text) { return static_cast<Value>(readCount(text, least, most)); };
  return program.addRead(name, "NUMBER", value, read, description);
}

/// An option that is one positive number, a whole one if Number is. The help shows its value of now as the default.
template <typename Number>
void addPositive(ProgramOptions& program, const std::string& name, Number& value, const std::string& description) {
  std::ostringstream text;
  text << description << " (default: " << value << ")";
  if constexpr (std::numeric_limits<Number>::is_integer)
    addCount(program, name, value, 1, static_cast<long>(std::numeric_limits<Number>::max()), text.str());
  else
    program.addRead(name, "NUMBER", value, readPositive, text.str());
}

/// The option --threads, which several tools have.
void addThreads(ProgramOptions& program, int& value);

}  // namespace proximity_server::tools
