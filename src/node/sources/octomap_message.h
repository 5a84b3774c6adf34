#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <string>
#include <vector>

namespace proximity_server::node {

/// An octomap_msgs/Octomap, whose package Debian 12 has not.
struct OctomapMessage {
  std_msgs::Header header;
  std::uint8_t is_binary = 0;
  std::string id;           ///< the class of the octree
  double resolution = 0.0;  ///< [m]
  std::string data;
};

}  // namespace proximity_server::node

namespace ros {
namespace message_traits {
template <>
struct MD5Sum<proximity_server::node::OctomapMessage> {
  static const char* value() { return "9a45536b45c5e409cd49f04bb2d9999f"; }
  static const char* value(const proximity_server::node::OctomapMessage&) { return value(); }
};
template <>
struct DataType<proximity_server::node::OctomapMessage> {
  static const char* value() { return "octomap_msgs/Octomap"; }
  static const char* value(const proximity_server::node::OctomapMessage&) { return value(); }
};
}  // namespace message_traits
namespace serialization {
template <>
struct Serializer<proximity_server::node::OctomapMessage> {
  template <typename Stream, typename Message>
  static void allInOne(Stream& stream, Message message) {
    stream.next(message.header);
    stream.next(message.is_binary);
    stream.next(message.id);
    stream.next(message.resolution);
    stream.next(message.data);  // a string has the layout of int8[]
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};
}  // namespace serialization
}  // namespace ros
