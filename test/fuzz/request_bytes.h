#pragma once

#include <ros/duration.h>
#include <ros/serialization.h>
#include <ros/time.h>
#include <boost/array.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace proximity_server::fuzz {

/// A stream for ros::serialization in which any bytes are a message, so that a fuzzer comes past the lengths that
/// roscpp reads: a list has at most seven elements, a text is one of `names` or at most 31 letters, and behind the end
/// everything is 0.
class RequestBytes {
 public:
  RequestBytes(std::string_view bytes, const std::vector<std::string>& names) : rest_(bytes), names_(names) {}

  template <class T>
  void next(T& value) {
    if constexpr (std::is_arithmetic_v<T>) {
      const std::string_view bytes = take(sizeof value);
      value = T();
      if (!bytes.empty()) std::memcpy(&value, bytes.data(), bytes.size());
    } else {
      ros::serialization::Serializer<T>::template allInOne<RequestBytes, T&>(*this, value);
    }
  }
  void next(ros::Time& time) {
    next(time.sec);
    next(time.nsec);
  }
  void next(ros::Duration& duration) {
    next(duration.sec);
    next(duration.nsec);
  }
  void next(std::string& text) {
    const std::size_t choice = number();
    text = choice < names_.size() ? names_[choice] : std::string(take(choice % 32));
  }
  template <class T, std::size_t Size>
  void next(boost::array<T, Size>& list) {
    for (T& element : list) next(element);
  }
  template <class T>
  void next(std::vector<T>& list) {
    list.resize(number() % 8);
    for (T& element : list) next(element);
  }

 private:
  std::size_t number() {
    std::uint8_t byte = 0;
    next(byte);
    return byte;
  }
  std::string_view take(std::size_t size) {
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(taken.size());
    return taken;
  }

  std::string_view rest_;
  const std::vector<std::string>& names_;
};

}  // namespace proximity_server::fuzz
