#include "node/load/client_process.h"

#include "node/load/programs.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <stdexcept>
#include <thread>

namespace proximity_server::node {
namespace {

using Clock = std::chrono::steady_clock;  // that of the system: the same in all processes

constexpr double kLeadTime = 0.1;  // [s] in which all clients read their tasks and connect

/// In front of a task.
struct TaskHeader {
  std::size_t service_size, request_size;
  Connection connection;
  Clock::time_point start, end;
};

/// In front of an outcome.
struct OutcomeHeader {
  std::size_t count, failed;
};

bool readAll(int file, void* data, std::size_t size) {
  auto* to = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t got = read(file, to, size);
    if (got <= 0) return false;
    to += got;
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

void writeAll(int file, const void* data, std::size_t size) {
  const auto* from = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t put = write(file, from, size);
    if (put <= 0) throw std::runtime_error("a process of the benchmark has died");
    from += put;
    size -= static_cast<std::size_t>(put);
  }
}

Calls callUntil(const Calling& task, Clock::time_point start, Clock::time_point end) {
  RawClient client(task.service, task.connection);
  client.call(task.request);
  std::this_thread::sleep_until(start);
  Calls calls;
  for (Clock::time_point begin = Clock::now(); begin < end; begin = Clock::now()) {
    const auto response = client.call(task.request);
    if (response && isSuccess(*response)) {
      calls.seconds.push_back(std::chrono::duration<float>(Clock::now() - begin).count());
    } else {
      ++calls.failed;
    }
  }
  return calls;
}

}  // namespace

void runClient(int input, int output) {
  TaskHeader header;
  while (readAll(input, &header, sizeof header)) {
    Calling task{std::string(header.service_size, ' '), header.connection, RawRequest(header.request_size)};
    if (!readAll(input, task.service.data(), task.service.size())) return;
    if (!readAll(input, task.request.data(), task.request.size())) return;
    const Calls calls = callUntil(task, header.start, header.end);
    const OutcomeHeader outcome{calls.seconds.size(), calls.failed};
    writeAll(output, &outcome, sizeof outcome);
    writeAll(output, calls.seconds.data(), calls.seconds.size() * sizeof(float));
  }
}

ClientProcesses::ClientProcesses(std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    std::array<int, 2> tasks{}, outcomes{};
    // Not for the children that come later: a pipe ends when its only writer does.
    if (pipe2(tasks.data(), O_CLOEXEC) != 0 || pipe2(outcomes.data(), O_CLOEXEC) != 0) {
      throw std::runtime_error("no pipe for a client");
    }
    fcntl(tasks[0], F_SETFD, 0);
    fcntl(outcomes[1], F_SETFD, 0);
    Client client{tasks[1], outcomes[0], nullptr};
    client.process = startOurselves({"--client", std::to_string(tasks[0]), std::to_string(outcomes[1])});
    close(tasks[0]);
    close(outcomes[1]);
    clients_.push_back(std::move(client));
  }
}

ClientProcesses::~ClientProcesses() {
  for (const Client& client : clients_) {
    close(client.to);
    close(client.from);
  }
}

Calls ClientProcesses::call(const std::vector<Calling>& tasks, double seconds) {
  const auto duration = [](double length) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(length));
  };
  const Clock::time_point start = Clock::now() + duration(kLeadTime), end = start + duration(seconds);
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const TaskHeader header{tasks[i].service.size(), tasks[i].request.size(), tasks[i].connection, start, end};
    writeAll(clients_[i].to, &header, sizeof header);
    writeAll(clients_[i].to, tasks[i].service.data(), tasks[i].service.size());
    writeAll(clients_[i].to, tasks[i].request.data(), tasks[i].request.size());
  }
  Calls all;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    OutcomeHeader outcome{};
    if (!readAll(clients_[i].from, &outcome, sizeof outcome)) throw std::runtime_error("a client has died");
    const std::size_t before = all.seconds.size();
    all.seconds.resize(before + outcome.count);
    if (!readAll(clients_[i].from, all.seconds.data() + before, outcome.count * sizeof(float))) {
      throw std::runtime_error("a client has died");
    }
    all.failed += outcome.failed;
  }
  return all;
}

}  // namespace proximity_server::node
