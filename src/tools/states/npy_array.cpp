#include "tools/states/npy_array.h"

#include "tools/text/csv.h"
#include "tools/text/naming.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <utility>

namespace proximity_server::tools {
namespace {

constexpr std::size_t kLongestHeader = 65535;  // as many as version 1 can have
constexpr std::uint64_t kMostTextBytes = std::uint64_t{16} << 20;
constexpr char kNativeOrder = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? '<' : '>';

[[noreturn]] void refuseHeader() { throw std::invalid_argument("the header of the array is damaged"); }

/// The text of a header as JSON: it is a Python dictionary of texts, truth values and tuples of whole numbers, which
/// differs in its quotes, words and parentheses, and in commas behind the last item.
std::string jsonOf(const std::string& python) {
  std::string json;
  for (std::size_t i = 0; i < python.size(); ++i) {
    const char letter = python[i];
    if (letter == '\'' || letter == '"') {
      const std::size_t end = python.find(letter, i + 1);
      if (end == std::string::npos) refuseHeader();
      json += nlohmann::json(python.substr(i + 1, end - i - 1))
                  .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
      i = end;
    } else if (letter == ')' || letter == ']' || letter == '}') {
      if (!json.empty() && json.back() == ',') json.pop_back();
      json += letter == ')' ? ']' : letter;
    } else if (python.compare(i, 5, "False") == 0 || python.compare(i, 4, "True") == 0) {
      json += letter == 'F' ? "false" : "true";
      i += letter == 'F' ? 4 : 3;
    } else if (std::isalpha(static_cast<unsigned char>(letter)) != 0) {
      if (letter != 'L' || i == 0 || std::isdigit(static_cast<unsigned char>(python[i - 1])) == 0) refuseHeader();
    } else if (std::isspace(static_cast<unsigned char>(letter)) == 0 || json.empty() || json.back() != ',') {
      json += letter == '(' ? '[' : letter;
    }
  }
  return json;
}

NpyHeader headerOf(const std::string& python) {
  int keys = 0;
  const auto countKeys = [&](int, nlohmann::json::parse_event_t event, const nlohmann::json&) {
    if (event == nlohmann::json::parse_event_t::key) ++keys;
    return true;
  };
  const nlohmann::json json = nlohmann::json::parse(jsonOf(python), countKeys, false);
  const bool is_whole = json.is_object() && keys == 3 && json.contains("descr") && json.contains("shape") &&
                        json.value("fortran_order", nlohmann::json()).is_boolean() && json["shape"].is_array();
  if (!is_whole) refuseHeader();
  if (json["descr"].is_array())
    throw std::invalid_argument("a structured array; expected a table of float64 or float32");
  if (!json["descr"].is_string()) refuseHeader();
  NpyHeader header{json["descr"], json["fortran_order"] ? NpyHeader::Order::Fortran : NpyHeader::Order::C, {}, 0};
  for (const nlohmann::json& size : json["shape"]) {
    if (!size.is_number_unsigned()) refuseHeader();
    header.shape.push_back(size);
  }
  return header;
}

/// The bytes from `first` to `last` as a little-endian number.
std::size_t littleEndian(const unsigned char* first, const unsigned char* last) {
  std::size_t value = 0;
  while (last != first) value = value << 8 | *--last;
  return value;
}

template <typename Number>
Number swapped(Number number) {
  std::array<char, sizeof(Number)> bytes;
  std::memcpy(bytes.data(), &number, bytes.size());
  std::reverse(bytes.begin(), bytes.end());
  std::memcpy(&number, bytes.data(), bytes.size());
  return number;
}

template <typename Number>
Number numberAt(const char* from) {
  Number number;
  std::memcpy(&number, from, sizeof number);
  return number;
}

/// a * b * c; nullopt if that is more than any file has.
std::optional<std::uint64_t> product(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  std::uint64_t result = 0;
  if (__builtin_mul_overflow(a, b, &result) || __builtin_mul_overflow(result, c, &result)) return std::nullopt;
  return result;
}

std::string shapeText(const std::vector<std::uint64_t>& shape) {
  std::string text;
  for (const std::uint64_t size : shape) text += (text.empty() ? "" : ", ") + std::to_string(size);
  return "(" + text + ")";
}

/// Throws std::invalid_argument unless the data are as long as `shape` and the size of an item say.
void checkSize(const Bytes& bytes, const NpyHeader& header, std::uint64_t rows, std::uint64_t columns,
               std::uint64_t item) {
  const std::uint64_t there = bytes.size() - header.data_begin;
  const std::optional<std::uint64_t> expected = product(rows, columns, item);
  if (expected == there) return;
  const std::string size = expected ? std::to_string(*expected) + " bytes" : "more bytes than a file can have";
  throw std::invalid_argument(
      (!expected || there < *expected ? "truncated: shape " : "there is more behind the array: shape ") +
      shapeText(header.shape) + " of " + header.dtype + " has " + size + ", there are " + std::to_string(there));
}

/// Appends a character in UTF-8. Throws std::invalid_argument if the number is none.
void appendUtf8(std::uint32_t character, std::string& text) {
  if (character > 0x10FFFF || (character >= 0xD800 && character < 0xE000))
    throw std::invalid_argument("a text with an illegal character");
  const auto append = [&](std::uint32_t byte) { text += static_cast<char>(static_cast<unsigned char>(byte)); };
  const auto appendRest = [&](int shift) { append(0x80 | (character >> shift & 0x3F)); };
  if (character < 0x80) return append(character);
  if (character < 0x800) {
    append(0xC0 | character >> 6);
  } else {
    if (character < 0x10000) {
      append(0xE0 | character >> 12);
    } else {
      append(0xF0 | character >> 18);
      appendRest(12);
    }
    appendRest(6);
  }
  appendRest(0);
}

/// A text of an array: its characters have 4 bytes (U) or 1 (S), and zeros fill the rest.
std::string textAt(const char* from, std::size_t characters, const NpyHeader& header) {
  std::string text;
  std::size_t zeros = 0;
  for (std::size_t i = 0; i < characters; ++i) {
    std::uint32_t character = static_cast<unsigned char>(from[i]);
    if (header.dtype[1] == 'U') {
      character = numberAt<std::uint32_t>(from + 4 * i);
      if (header.dtype[0] != kNativeOrder) character = swapped(character);
    }
    if (character == 0) {
      ++zeros;
      continue;
    }
    text.append(std::exchange(zeros, 0), '\0');
    if (header.dtype[1] == 'U') {
      appendUtf8(character, text);
    } else {
      text += from[i];
    }
  }
  return text;
}

std::vector<std::string> readTexts(Bytes& bytes) {
  const NpyHeader header = readNpyHeader(bytes);
  const std::string& dtype = header.dtype;
  const auto characters = numberIn<std::uint64_t>(dtype.substr(std::min<std::size_t>(dtype.size(), 2)));
  const bool is_text = characters && (dtype[1] == 'U' || dtype[1] == 'S');
  if (!is_text || header.shape.size() != 1)
    throw std::invalid_argument("dtype " + dtype + ", shape " + shapeText(header.shape) + "; expected a list of texts");
  const std::uint64_t width = dtype[1] == 'U' ? 4 : 1;
  checkSize(bytes, header, header.shape[0], *characters, width);
  const std::uint64_t size = bytes.size() - header.data_begin;
  if (size > kMostTextBytes || (size == 0 && header.shape[0] > 0)) throw std::invalid_argument("no names of joints");
  std::vector<char> raw(size);
  bytes.read(header.data_begin, raw.data(), raw.size());
  std::vector<std::string> texts;
  for (std::uint64_t i = 0; i < header.shape[0]; ++i)
    texts.push_back(textAt(raw.data() + i * *characters * width, *characters, header));
  return texts;
}

}  // namespace

NpyHeader readNpyHeader(Bytes& bytes) {
  constexpr std::size_t kShortestBegin = 10;
  std::array<unsigned char, 12> begin{};
  const std::string magic = "\x93NUMPY";
  if (bytes.size() >= kShortestBegin) bytes.read(0, begin.data(), kShortestBegin);
  if (!std::equal(magic.begin(), magic.end(), reinterpret_cast<const char*>(begin.data())))
    throw std::invalid_argument("no NumPy array: it does not begin as a .npy");
  const int version = begin[6];
  if (version < 1 || version > 3)
    throw std::invalid_argument("version " + std::to_string(version) + " of .npy; known are 1 to 3");
  const std::size_t text_begin = version == 1 ? 10 : 12;
  if (bytes.size() < text_begin) throw std::invalid_argument("truncated: ends in the header");
  bytes.read(8, begin.data() + 8, text_begin - 8);
  const std::size_t length = littleEndian(begin.data() + 8, begin.data() + text_begin);
  if (length > kLongestHeader) throw std::invalid_argument("a header of " + std::to_string(length) + " bytes");
  if (bytes.size() - text_begin < length) throw std::invalid_argument("truncated: ends in the header");
  std::string text(length, '\0');
  bytes.read(text_begin, text.data(), length);
  NpyHeader header = headerOf(text);
  header.data_begin = text_begin + length;
  return header;
}

NpyTable::NpyTable(std::unique_ptr<Bytes> bytes, std::string source)
    : bytes_(std::move(bytes)), source_(std::move(source)) {
  naming(source_, [&] {
    header_ = readNpyHeader(*bytes_);
    const std::string& dtype = header_.dtype;
    if (dtype != "<f8" && dtype != ">f8" && dtype != "<f4" && dtype != ">f4")
      throw std::invalid_argument("dtype " + dtype + "; expected float64 or float32");
    dimensions_ = static_cast<int>(header_.shape.size());
    if (dimensions_ < 1 || dimensions_ > 2)
      throw std::invalid_argument("shape " + shapeText(header_.shape) + "; expected a row for each state");
    rows_ = header_.shape[0];
    if (dimensions_ == 2) columns_ = header_.shape[1];
    checkSize(*bytes_, header_, rows_, columns_, dtype[2] == '8' ? 8 : 4);
  });
}

void NpyTable::read(std::uint64_t first, std::size_t count, std::size_t stride, double* to) {
  naming(source_, [&] {
    if (header_.dtype[2] == '8') {
      readAs<double>(first, count, stride, to);
    } else {
      readAs<float>(first, count, stride, to);
    }
  });
}

template <typename Number>
void NpyTable::readAs(std::uint64_t first, std::size_t count, std::size_t stride, double* to) {
  const bool is_c = header_.order == NpyHeader::Order::C, is_native = header_.dtype[0] == kNativeOrder;
  // A run is of numbers that lie side by side: all rows, or a column of them.
  const std::uint64_t runs = is_c ? 1 : columns_, width = is_c ? columns_ : 1;
  raw_.resize(count * width * sizeof(Number));
  for (std::uint64_t run = 0; run < runs; ++run) {
    const std::uint64_t begin = is_c ? first * columns_ : run * rows_ + first;
    bytes_->read(header_.data_begin + begin * sizeof(Number), raw_.data(), raw_.size());
    const char* from = raw_.data();
    for (std::size_t row = 0; row < count; ++row) {
      for (std::size_t i = 0; i < width; ++i, from += sizeof(Number)) {
        const auto number = numberAt<Number>(from);
        to[row * stride + run + i] = static_cast<double>(is_native ? number : swapped(number));
      }
    }
  }
}

std::vector<std::string> readNpyTexts(Bytes& bytes, const std::string& source) {
  return naming(source, [&] { return readTexts(bytes); });
}

}  // namespace proximity_server::tools
