#pragma once

#include <CLI/CLI.hpp>

#include <optional>
#include <stdexcept>
#include <string>

namespace proximity_server::tools {

/// Reads a number of the command line: a finite number of at least `least`, or a whole number from `least` to `most`.
/// Otherwise throws std::invalid_argument naming the text and the legal values.
double readLength(const std::string& text, double least);
long readCount(const std::string& text, long least, long most);

/// An option whose text `read` turns into a value; what it throws becomes an error of the option.
template <typename Value, typename Read>
CLI::Option* addRead(CLI::App& app, const std::string& name, Value& value, const Read& read,
                     const std::string& description) {
  const auto store = [&value, name, read](const std::string& text) {
    try {
      value = read(text);
    } catch (const std::invalid_argument& error) {
      throw CLI::ValidationError(name, error.what());
    }
  };
  return app.add_option_function<std::string>(name, store, description);
}

/// An option that is one length [m]; `value` may be optional.
template <typename Value>
CLI::Option* addLength(CLI::App& app, const std::string& name, Value& value, double least,
                       const std::string& description) {
  const auto read = [least](const std::string& text) { return readLength(text, least); };
  return addRead(app, name, value, read, description)->type_name("METRES");
}

/// An option that is one whole number.
template <typename Value>
CLI::Option* addCount(CLI::App& app, const std::string& name, Value& value, long least, long most,
                      const std::string& description) {
  const auto read = [least, most](const std::string& text) { return static_cast<Value>(readCount(text, least, most)); };
  return addRead(app, name, value, read, description)->type_name("NUMBER");
}

// Options that several tools have.

CLI::Option* addMeshTolerance(CLI::App& app, std::optional<double>& value);

/// Adds --threads. The default is the number of cores.
CLI::Option* addThreads(CLI::App& app, int& value);

}  // namespace proximity_server::tools
