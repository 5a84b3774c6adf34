#pragma once

#include "benchmark/machine.h"
#include "benchmark/wanted.h"
#include "peers/aborts.h"
#include "tools/program/options.h"

#include <nlohmann/json.hpp>

#include <exception>
#include <fstream>
#include <functional>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>

namespace proximity_server::benchmark {

/// main() of a benchmark: reads `--json FILE [REGEX]` or `--list [REGEX]` and the options that `program` already has, and
/// writes the machine and the result of `measure` into the file. `measure` returns a JSON object with the wanted rows.
/// Returns 1, with the reason on standard error, if something throws.
inline int benchmarkMain(tools::ProgramOptions& program, int argc, char** argv,
                         const std::function<nlohmann::json(const Wanted& wanted)>& measure) {
  std::string file, regex = ".";
  bool lists = false;
  program.addText("--json", "FILE", file, "where the results go");
  program.addFlag("--list", lists, true, "only print the names of the rows");
  program.addText("regex", "REGEX", regex, "only rows whose name matches");
  if (const std::optional<int> exit_code = program.parse(argc, argv)) return *exit_code;
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
