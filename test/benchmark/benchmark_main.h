#pragma once

#include "benchmark/machine.h"
#include "benchmark/wanted.h"
#include "peers/aborts.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <exception>
#include <fstream>
#include <functional>
#include <iostream>
#include <stdexcept>
#include <string>

namespace proximity_server::benchmark {

/// main() of a benchmark: reads `--json FILE [REGEX]` or `--list [REGEX]` and the options that `app` already has, and
/// writes the machine and the result of `measure` into the file. `measure` returns a JSON object with the wanted rows.
/// Returns 1, with the reason on standard error, if something throws.
inline int benchmarkMain(CLI::App& app, int argc, char** argv,
                         const std::function<nlohmann::json(const Wanted& wanted)>& measure) {
  std::string file, regex = ".";
  bool lists = false;
  app.add_option("--json", file, "where the results go");
  app.add_flag("--list", lists, "only print the names of the rows");
  app.add_option("regex", regex, "only rows whose name matches");
  CLI11_PARSE(app, argc, argv);
  try {
    if (file.empty() != lists) throw std::invalid_argument("give --json FILE or --list");
    peers::surviveAborts();
    nlohmann::json result = machine();
    result.update(measure(Wanted(regex, lists)));
    if (lists) return 0;
    std::cerr << "\n";
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
