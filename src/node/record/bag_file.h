#pragma once

#include "system/whole_file.h"

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <ros/time.h>

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace proximity_server::node {

/// Writes messages into a rosbag of version 2.0, which gets its name when it is complete.
///
/// rosbag::Bag cannot be used, because it writes once more in its destructor: where the disk is full, that throws and
/// ends the process.
/// Failure: throws std::invalid_argument with the file and the cause, as system::WholeFile.
/// Source:  ROS wiki, Bags/Format/2.0.
class BagFile {
 public:
  explicit BagFile(const std::string& path);

  template <class Message>
  void write(const std::string& topic, const ros::Time& time, const Message& message) {
    namespace traits = ros::message_traits;
    const std::uint32_t size = ros::serialization::serializationLength(message);
    std::string bytes(size, '\0');
    ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()), size);
    ros::serialization::serialize(stream, message);
    write({topic, traits::datatype<Message>(), traits::md5sum<Message>(), traits::definition<Message>()}, time, bytes);
  }

  /// Nothing may be written afterwards.
  void complete();

 private:
  struct Connection {
    std::string topic, type, md5sum, definition;
  };
  struct Chunk {
    std::uint64_t position = 0;                     ///< in the file
    ros::Time begin, end;                           ///< of its messages
    std::map<std::uint32_t, std::uint32_t> counts;  ///< messages by connection
  };

  void write(const Connection& connection, const ros::Time& time, std::string_view bytes);
  void endChunk();
  static std::string connectionRecord(std::uint32_t number, const Connection& connection);
  static std::string headerRecord(std::uint64_t index, std::size_t connections, std::size_t chunks);

  system::WholeFile file_;
  std::vector<Connection> connections_;
  std::vector<Chunk> chunks_;                   ///< those in the file
  std::string data_;                            ///< records of the chunk that has not ended
  Chunk chunk_;                                 ///< about these
  std::map<std::uint32_t, std::string> index_;  ///< of these, by connection: time and place of each message
};

}  // namespace proximity_server::node
