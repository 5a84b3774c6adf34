#include "node/record/bag_file.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace proximity_server::node {
namespace {

constexpr std::size_t kChunk = 768 * 1024;  ///< [byte] as rosbag has it
constexpr std::size_t kHeader = 4096;       ///< [byte] of the first record, so that it can be replaced at the end
enum Operation : char { kMessage = 2, kBag = 3, kIndex = 4, kChunkOfRecords = 5, kChunkInfo = 6, kConnection = 7 };

/// The bytes of a number; all processors that ROS runs on are little-endian like the format.
template <class Number>
std::string bytesOf(Number number) {
  std::string bytes(sizeof number, '\0');
  std::memcpy(bytes.data(), &number, sizeof number);
  return bytes;
}
std::string bytesOf(const ros::Time& time) { return bytesOf(time.sec) + bytesOf(time.nsec); }
std::string sized(std::string_view text) { return bytesOf(static_cast<std::uint32_t>(text.size())).append(text); }
std::string field(const std::string& name, std::string_view value) { return sized((name + "=").append(value)); }
template <class Number>
std::string number(const std::string& name, Number value) {
  return field(name, bytesOf(value));
}
std::string operation(Operation value) { return field("op", {reinterpret_cast<const char*>(&value), 1}); }
std::string record(const std::string& header, std::string_view data) { return sized(header) + sized(data); }

}  // namespace

BagFile::BagFile(const std::string& path) : file_(path) { file_.append("#ROSBAG V2.0\n" + headerRecord(0, 0, 0)); }

std::string BagFile::headerRecord(std::uint64_t index, std::size_t connections, std::size_t chunks) {
  const std::string header = operation(kBag) + number("index_pos", index) +
                             number("conn_count", static_cast<std::uint32_t>(connections)) +
                             number("chunk_count", static_cast<std::uint32_t>(chunks));
  return record(header, std::string(kHeader - header.size(), ' '));
}

std::string BagFile::connectionRecord(std::uint32_t number_of, const Connection& connection) {
  return record(operation(kConnection) + number("conn", number_of) + field("topic", connection.topic),
                field("topic", connection.topic) + field("type", connection.type) + field("md5sum", connection.md5sum) +
                    field("message_definition", connection.definition));
}

void BagFile::write(const Connection& connection, const ros::Time& stamp, std::string_view bytes) {
  const ros::Time time = std::max(stamp, ros::TIME_MIN);  // readers refuse the time 0
  const auto known = std::find_if(connections_.begin(), connections_.end(),
                                  [&](const Connection& other) { return other.topic == connection.topic; });
  const auto number_of = static_cast<std::uint32_t>(known - connections_.begin());
  if (known == connections_.end()) {
    data_ += connectionRecord(number_of, connection);
    connections_.push_back(connection);
  }
  index_[number_of] += bytesOf(time) + bytesOf(static_cast<std::uint32_t>(data_.size()));
  ++chunk_.counts[number_of];
  chunk_.begin = chunk_.begin.isZero() ? time : std::min(chunk_.begin, time);
  chunk_.end = std::max(chunk_.end, time);
  data_ += record(operation(kMessage) + number("conn", number_of) + field("time", bytesOf(time)), bytes);
  if (data_.size() >= kChunk) endChunk();
}

void BagFile::endChunk() {
  if (data_.empty()) return;
  chunk_.position = file_.size();
  const std::string header = operation(kChunkOfRecords) + field("compression", "none") +
                             number("size", static_cast<std::uint32_t>(data_.size()));
  file_.append(record(header, data_));
  for (const auto& [connection, places] : index_)
    file_.append(record(operation(kIndex) + number("ver", std::uint32_t{1}) + number("conn", connection) +
                            number("count", chunk_.counts[connection]),
                        places));
  chunks_.push_back(std::exchange(chunk_, {}));
  data_.clear();
  index_.clear();
}

void BagFile::complete() {
  endChunk();
  const std::uint64_t index = file_.size();
  for (std::size_t i = 0; i < connections_.size(); ++i)
    file_.append(connectionRecord(static_cast<std::uint32_t>(i), connections_[i]));
  for (const Chunk& chunk : chunks_) {
    std::string counts;
    for (const auto& [connection, count] : chunk.counts) counts += bytesOf(connection) + bytesOf(count);
    file_.append(record(operation(kChunkInfo) + number("ver", std::uint32_t{1}) + number("chunk_pos", chunk.position) +
                            field("start_time", bytesOf(chunk.begin)) + field("end_time", bytesOf(chunk.end)) +
                            number("count", static_cast<std::uint32_t>(chunk.counts.size())),
                        counts));
  }
  file_.replaceBegin("#ROSBAG V2.0\n" + headerRecord(index, connections_.size(), chunks_.size()));
  file_.complete();
}

}  // namespace proximity_server::node
