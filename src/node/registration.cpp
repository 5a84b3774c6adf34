#include "node/registration.h"

#include <ros/console.h>
#include <ros/init.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/publication.h>
#include <ros/this_node.h>
#include <ros/topic_manager.h>
#include <ros/xmlrpc_manager.h>

#include <optional>
#include <utility>

namespace proximity_server::node {
namespace {

using XmlRpc::XmlRpcValue;

constexpr double kPeriod = 1.0;  // [s] of wall time between two checks

/// Calls a method of the master, and returns its answer; nullopt if it refuses or cannot be reached. Does not wait for
/// the master.
template <class... Arguments>
std::optional<XmlRpcValue> askMaster(const std::string& method, const Arguments&... arguments) {
  XmlRpcValue request, response, payload;
  int count = 0;
  request[count++] = ros::this_node::getName();
  ((request[count++] = arguments), ...);
  if (!ros::master::execute(method, request, response, payload, /*wait_for_master=*/false)) return std::nullopt;
  return payload;
}

std::string ownApi() { return ros::XMLRPCManager::instance()->getServerURI(); }

/// The services of this node, as the master lists them.
std::vector<std::string> registeredServices() {
  std::vector<std::string> services;
  XmlRpcValue request, response, state;
  request[0] = ros::this_node::getName();
  // This waits for the master, as advertising a service does.
  if (!ros::master::execute("getSystemState", request, response, state, /*wait_for_master=*/true)) return services;
  constexpr int kServices = 2;  // the state lists publishers, subscribers, services
  XmlRpcValue& all = state[kServices];
  for (int i = 0; i < all.size(); ++i) {
    XmlRpcValue& providers = all[i][1];
    for (int j = 0; j < providers.size(); ++j) {
      if (std::string(providers[j]) == ros::this_node::getName()) services.push_back(all[i][0]);
    }
  }
  return services;
}

/// Sends this node the list of the publishers of a topic, as the master does.
void announcePublishers(const std::string& topic, const XmlRpcValue& publishers) {
  const auto& xmlrpc = ros::XMLRPCManager::instance();
  XmlRpcValue request, response;
  request[0] = "/master";
  request[1] = topic;
  request[2] = publishers;
  XmlRpc::XmlRpcClient* self =
      xmlrpc->getXMLRPCClient(ros::network::getHost(), static_cast<int>(xmlrpc->getServerPort()), "/");
  self->execute("publisherUpdate", request, response);
  xmlrpc->releaseXMLRPCClient(self);
}

void registerPublishers(const std::string& api) {
  std::vector<std::string> topics;
  ros::this_node::getAdvertisedTopics(topics);
  for (const std::string& topic : topics) {
    const ros::PublicationPtr publication = ros::TopicManager::instance()->lookupPublication(topic);
    if (publication) askMaster("registerPublisher", topic, publication->getDataType(), api);
  }
}

void registerSubscribers(const std::string& api) {
  std::vector<std::string> topics;
  ros::this_node::getSubscribedTopics(topics);
  for (const std::string& topic : topics) {
    const std::optional<XmlRpcValue> publishers = askMaster("registerSubscriber", topic, "*", api);
    // If the new master knows no publisher yet, the connections to the old publishers are kept.
    if (publishers && publishers->size() > 0) announcePublishers(topic, *publishers);
  }
}

}  // namespace

void registerService(const std::string& service, const std::string& address) {
  askMaster("registerService", service, address, ownApi());
}

Registration::Registration(std::string service_api)
    : api_(ownApi()), service_api_(std::move(service_api)), services_(registeredServices()), spinner_(1, &queue_) {
  for (const std::string& service : services_) registerService(service, service_api_);
  nh_.setCallbackQueue(&queue_);
  timer_ = nh_.createWallTimer(ros::WallDuration(kPeriod), [this](const ros::WallTimerEvent&) { check(); });
  spinner_.start();
}

Registration::~Registration() {
  queue_.disable();
  spinner_.stop();
  for (const std::string& service : services_) askMaster("unregisterService", service, service_api_);
}

void Registration::check() {
  if (services_.empty()) return;  // ROS was shut down during the start
  // The services are registered in their order, so a master that knows the last one knows all.
  if (askMaster("lookupService", services_.back()) || !ros::master::check()) return;
  if (ros::isShuttingDown()) return;  // the master does not know the service because roscpp has removed it
  ROS_WARN_STREAM("the master at " << ros::master::getURI() << " has forgotten this node: registering again");
  registerAgain();
}

void Registration::registerAgain() const {
  registerPublishers(api_);
  registerSubscribers(api_);
  for (const std::string& service : services_) askMaster("registerService", service, service_api_, api_);
}

}  // namespace proximity_server::node
