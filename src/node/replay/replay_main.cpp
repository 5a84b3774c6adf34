// Answers the states of a record again. `clearance --replay` starts it.
#include "node/replay/replay.h"

#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>

namespace {

using proximity_server::node::ReplayOptions;

constexpr char kHelp[] =
    "usage: clearance --replay FILE.bag [--mesh-tolerance METRES] [--explain-event]\n"
    "  --mesh-tolerance METRES  in place of that of the record; 0: triangles\n"
    "  --explain-event          contact, or the envelope around the surfaces: each share in millimetres\n"
    "A row for each cycle on standard output. Exit code 2: a level or bounds differ from the record.\n";

int run(int argc, char** argv) {
  ReplayOptions options;
  bool explains = false;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    const auto value = [&]() -> std::string {
      if (++i == argc) throw std::invalid_argument(option + " needs a value\n" + kHelp);
      return argv[i];
    };
    if (option == "--replay")
      options.file = value();
    else if (option == "--mesh-tolerance")
      options.mesh_tolerance = std::stod(value());
    else if (option == "--explain-event")
      explains = true;
    else
      throw std::invalid_argument(option + " does not go with --replay\n" + kHelp);
  }
  if (explains) {
    std::cout << proximity_server::node::explainEvent(options);
    return 0;
  }
  const auto result = proximity_server::node::replay(options, std::cout);
  std::cerr << "clearance: " << result.cycles << " cycles, " << result.different << " differ from the record\n";
  if (result.agrees()) return 0;
  for (const std::string& line : result.first_differences) std::cerr << "  " << line << '\n';
  for (const std::string& reason : result.reasons) std::cerr << "  possible reason: " << reason << '\n';
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "clearance: " << error.what() << '\n';
    return 1;
  }
}
