#include "node/load/programs.h"

#include "node/patience.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstdlib>
#include <stdexcept>

namespace proximity_server::node {
namespace {

sockaddr_in onThisMachine(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/// Closed at the end.
struct Socket {
  Socket() : descriptor(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {}
  ~Socket() { close(descriptor); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  const int descriptor;
};

bool isListening(int port) {
  const Socket socket;
  const sockaddr_in address = onThisMachine(port);
  return connect(socket.descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

}  // namespace

std::unique_ptr<ChildProcess> startProgram(const std::vector<std::string>& command) {
  std::vector<std::string> words = {"sh", "-c", "exec setsid setpriv --pdeathsig KILL \"$@\" >&2", "sh"};
  words.insert(words.end(), command.begin(), command.end());
  return std::make_unique<ChildProcess>(words);
}

std::unique_ptr<ChildProcess> startOurselves(const std::vector<std::string>& arguments) {
  std::array<char, PATH_MAX> path{};
  if (readlink("/proc/self/exe", path.data(), path.size() - 1) < 0) throw std::runtime_error("/proc is not there");
  std::vector<std::string> command = {path.data()};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return startProgram(command);
}

void stopProgram(ChildProcess& program) {
  program.signal(SIGINT);
  if (program.hasEndedWithin(std::chrono::seconds(5))) return;
  program.signal(SIGKILL);
  program.hasEndedWithin(std::chrono::seconds(5));
}

int freePort() {
  const Socket socket;
  sockaddr_in address = onThisMachine(0);
  socklen_t size = sizeof address;
  if (bind(socket.descriptor, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      getsockname(socket.descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    throw std::runtime_error("there is no free port");
  }
  return ntohs(address.sin_port);
}

bool awaitListener(int port) {
  return holdsWithin(std::chrono::seconds(10), [port] { return isListening(port); });
}

void useMasterAt(int port) {
  setenv("ROS_MASTER_URI", ("http://localhost:" + std::to_string(port)).c_str(), 1);
  setenv("ROS_HOSTNAME", "localhost", 1);
}

std::unique_ptr<ChildProcess> startMasterAt(int port) {
  auto master = startProgram({"rosmaster", "--core", "-p", std::to_string(port)});
  if (!awaitListener(port)) throw std::runtime_error("rosmaster does not start");
  return master;
}

}  // namespace proximity_server::node
