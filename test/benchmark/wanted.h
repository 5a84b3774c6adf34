#pragma once

#include <nlohmann/json.hpp>

#include <iostream>
#include <regex>
#include <string>

namespace proximity_server::benchmark {

/// The rows of a benchmark that are asked for: a regular expression matches their names. A list of rows prints these
/// names, and wants none measured.
class Wanted {
 public:
  explicit Wanted(const std::string& regex, bool lists = false) : regex_(regex), lists_(lists) {}

  bool operator()(const std::string& row) const {
    if (!std::regex_search(row, regex_)) return false;
    if (lists_) std::cout << row << "\n";
    return !lists_;
  }

 private:
  std::regex regex_;
  bool lists_;
};

inline void append(nlohmann::json& rows, const nlohmann::json& entries) {
  rows.insert(rows.end(), entries.begin(), entries.end());
}

/// Shows on the terminal that a row is measured.
inline void showProgress() { std::cerr << "." << std::flush; }

}  // namespace proximity_server::benchmark
