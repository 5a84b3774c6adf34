#include "node/threads/service_port.h"

#include <ros/connection_manager.h>
#include <ros/network.h>
#include <ros/service_client_link.h>
#include <boost/make_shared.hpp>

#include <cstdint>

namespace proximity_server::node {

ServicePort::ServicePort() : is_separate_(open()) {
  const std::uint32_t port = is_separate_ ? static_cast<std::uint32_t>(listener_->getServerPort())
                                          : ros::ConnectionManager::instance()->getTCPPort();
  address_ = "rosrpc://" + ros::network::getHost() + ":" + std::to_string(port);
  thread_ = std::thread([this] { run(); });
}

bool ServicePort::open() {
  if (ros::network::getTCPROSPort() != 0) return false;
  constexpr int kAnyPort = 0;
  constexpr int kWaitingClients = 100;  // as roscpp
  listener_ = boost::make_shared<ros::TransportTCP>(&poll_set_);
  return listener_->listen(kAnyPort, kWaitingClients, [this](const ros::TransportTCPPtr& client) { accept(client); });
}

ServicePort::~ServicePort() {
  ends_ = true;
  poll_set_.signal();
  thread_.join();
  if (listener_) listener_->close();
  for (const ros::ConnectionPtr& connection : connections_) connection->drop(ros::Connection::Destructing);
}

void ServicePort::run() {
  constexpr int kLongestWait = 100;  // [ms] as roscpp
  while (!ends_) {
    poll_set_.update(kLongestWait);
    forgetDropped();
  }
}

void ServicePort::accept(const ros::TransportTCPPtr& client) {
  const auto connection = boost::make_shared<ros::Connection>();
  connections_.insert(connection);
  connection->addDropListener([this](const ros::ConnectionPtr& dropped, ros::Connection::DropReason) {
    const std::lock_guard<std::mutex> lock(mutex_);
    dropped_.push_back(dropped);
  });
  connection->initialize(client, /*is_server=*/true, [](const ros::ConnectionPtr& from, const ros::Header& header) {
    const auto link = boost::make_shared<ros::ServiceClientLink>();
    link->initialize(from);
    return link->handleHeader(header);
  });
}

/// A dropped connection is destroyed here, and not when it is dropped: update() may still be using it then.
void ServicePort::forgetDropped() {
  std::vector<ros::ConnectionPtr> dropped;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    dropped.swap(dropped_);
  }
  for (const ros::ConnectionPtr& connection : dropped) connections_.erase(connection);
}

}  // namespace proximity_server::node
