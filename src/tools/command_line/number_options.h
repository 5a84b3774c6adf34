#pragma once

#include <CLI/CLI.hpp>

#include <optional>
#include <string>

namespace proximity_server::tools {

/// Reads a number of the command line. Throws CLI::ValidationError naming the option, the text and what is legal: not a
/// finite number of at least `least`, not a whole number of `least` to `most`.
double readLength(const std::string& option, const std::string& text, double least);
long readCount(const std::string& option, const std::string& text, long least, long most);

/// An option that is one length [m]; `value` may be optional.
template <typename Value>
CLI::Option* addLength(CLI::App& app, const std::string& name, Value& value, double least,
                       const std::string& description) {
  const auto take = [&value, name, least](const std::string& text) { value = readLength(name, text, least); };
  return app.add_option_function<std::string>(name, take, description)->type_name("METRES");
}

/// An option that is one whole number.
template <typename Value>
CLI::Option* addCount(CLI::App& app, const std::string& name, Value& value, long least, long most,
                      const std::string& description) {
  const auto take = [&value, name, least, most](const std::string& text) {
    value = static_cast<Value>(readCount(name, text, least, most));
  };
  return app.add_option_function<std::string>(name, take, description)->type_name("NUMBER");
}

// The options that both tools have.

CLI::Option* addMeshTolerance(CLI::App& app, std::optional<double>& value);

/// All cores unless it is given.
CLI::Option* addThreads(CLI::App& app, int& value);

}  // namespace proximity_server::tools
