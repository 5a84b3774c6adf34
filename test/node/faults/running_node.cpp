#include "node/faults/running_node.h"

#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpc.h>

namespace proximity_server::node {

pid_t processOf(const std::string& node) {
  XmlRpc::XmlRpcValue request, response, api;
  request[0] = ros::this_node::getName();
  request[1] = node;
  if (!ros::master::execute("lookupNode", request, response, api, /*wait_for_master=*/false)) return 0;

  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(api, host, port)) return 0;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port));
  XmlRpc::XmlRpcValue caller, answer;
  caller[0] = ros::this_node::getName();
  if (!client.execute("getPid", caller, answer) || client.isFault() || answer.size() < 3) return 0;
  return static_cast<int>(answer[2]);
}

}  // namespace proximity_server::node
