#pragma once

#include <CLI/CLI.hpp>
#include <exception>
#include <fstream>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <regex>
#include <stdexcept>
#include <string>

#include "benchmark/machine.h"
#include "peers/aborts.h"

namespace proximity_server::benchmark {

/// main() of a benchmark: reads `--json FILE [REGEX]` and the options that `app` already has, and writes the machine and
/// the result of `measure` into the file. `measure` returns a JSON object with the rows whose name the regular expression
/// matches. Returns 1, with the reason on standard error, if something throws.
inline int benchmarkMain(CLI::App& app, int argc, char** argv,
                         const std::function<nlohmann::json(const std::regex& wanted)>& measure) {
  std::string file, regex = ".";
  app.add_option("--json", file, "where the results go")->required();
  app.add_option("regex", regex, "only rows whose name matches");
  CLI11_PARSE(app, argc, argv);
  try {
    peers::surviveAborts();
    nlohmann::json result = machine();
    result.update(measure(std::regex(regex)));
    std::ofstream out(file);
    out << result.dump(1) << "\n";
    if (!out) throw std::runtime_error("cannot write " + file);
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
  return 0;
}

}  // namespace proximity_server::benchmark
