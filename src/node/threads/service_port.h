#pragma once

#include <ros/connection.h>
#include <ros/poll_set.h>
#include <ros/transport/transport_tcp.h>

#include <atomic>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace proximity_server::node {

/// A TCP port for the services of this process, with a thread of its own that accepts clients and reads requests.
///
/// roscpp has one thread, its poll thread, for the connections of all topics and services. Every answer of a service
/// takes a lock several times that the poll thread needs, too. With many clients the poll thread waits for this lock and
/// for a processor, and with it all transforms that arrive and all levels that leave. Clients of this port need neither
/// the poll thread nor its lock.
///
/// roscpp's own port serves the same services. So a client needs the address from the ROS master, see
/// registerService(). If roscpp has a fixed port (__tcpros_server_port, as behind a firewall), there is no second one,
/// and address() is roscpp's.
class ServicePort {
 public:
  ServicePort();
  /// Drops all connections. The threads that answer requests must have ended.
  ~ServicePort();
  ServicePort(const ServicePort&) = delete;
  ServicePort& operator=(const ServicePort&) = delete;

  /// The address for the ROS master: "rosrpc://HOST:PORT".
  const std::string& address() const { return address_; }

  /// False if it is roscpp's port.
  bool isSeparate() const { return is_separate_; }

 private:
  bool open();
  void run();
  void accept(const ros::TransportTCPPtr& client);
  void forgetDropped();

  ros::PollSet poll_set_;
  ros::TransportTCPPtr listener_;
  bool is_separate_;
  std::string address_;
  std::set<ros::ConnectionPtr> connections_;  // only thread_ uses it
  std::mutex mutex_;                          // guards the next member
  std::vector<ros::ConnectionPtr> dropped_;   // those that connections_ need not keep any more
  std::atomic<bool> ends_{false};
  std::thread thread_;  // the last member, because it uses the members above
};

}  // namespace proximity_server::node
