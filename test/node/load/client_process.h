#pragma once

#include "node/faults/child_process.h"
#include "node/load/raw_calls.h"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

// Clients as they are: each a process of its own, with a connection of its own.

namespace proximity_server::node {

/// The task of a client: it calls a service again and again.
struct Calling {
  std::string service;
  Connection connection;
  RawRequest request;
};

struct Calls {
  std::vector<float> seconds;  ///< of each round trip that had an answer
  std::size_t failed = 0;      ///< lost, or answered without success
};

/// Reads tasks from `input`, does them and writes the outcomes to `output`, until the input ends: the main() of a
/// client process.
void runClient(int input, int output);

/// Processes that run runClient(): our own program, with the arguments "--client INPUT OUTPUT".
class ClientProcesses {
 public:
  explicit ClientProcesses(std::size_t count);
  ~ClientProcesses();
  ClientProcesses(const ClientProcesses&) = delete;
  ClientProcesses& operator=(const ClientProcesses&) = delete;

  std::size_t size() const { return clients_.size(); }

  /// The first clients each do one of `tasks` at the same time, for so many seconds.
  /// Failure: throws std::runtime_error where a client has died.
  Calls call(const std::vector<Calling>& tasks, double seconds);

 private:
  struct Client {
    int to = -1, from = -1;
    std::unique_ptr<ChildProcess> process;
  };
  std::vector<Client> clients_;
};

}  // namespace proximity_server::node
