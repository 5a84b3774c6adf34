#include "tools/states/npy_array.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <utility>

namespace proximity_server::tools {
namespace {

constexpr std::size_t kLongestHeader = 65535;  // as many as version 1 can have
constexpr std::uint64_t kMostTextBytes = std::uint64_t{16} << 20;
constexpr char kNativeOrder = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? '<' : '>';

/// Reads the text of the header: a Python dictionary of texts, truth values and tuples of whole numbers.
class HeaderText {
 public:
  explicit HeaderText(std::string text) : text_(std::move(text)) {}

  NpyHeader read() {
    NpyHeader header;
    expect('{');
    while (!take('}')) {
      readEntry(header);
      if (!take(',') && !sees('}')) fail();
    }
    skipBlanks();
    if (at_ != text_.size() || keys_ != kAllKeys) fail();
    return header;
  }

 private:
  enum Key : unsigned { kDescr = 1, kOrder = 2, kShape = 4, kAllKeys = 7 };

  void readEntry(NpyHeader& header) {
    const std::string key = string();
    expect(':');
    if (key == "descr") {
      add(kDescr);
      readDtype(header);
    } else if (key == "fortran_order") {
      add(kOrder);
      header.order = truth() ? NpyHeader::Order::Fortran : NpyHeader::Order::C;
    } else if (key == "shape") {
      add(kShape);
      header.shape = tuple();
    } else {
      fail();
    }
  }

  void readDtype(NpyHeader& header) {
    if (sees('[')) throw std::invalid_argument("a structured array; expected a table of float64 or float32");
    header.dtype = string();
  }

  std::string string() {
    skipBlanks();
    if (at_ == text_.size() || (text_[at_] != '\'' && text_[at_] != '"')) fail();
    const std::size_t end = text_.find(text_[at_], at_ + 1);
    if (end == std::string::npos) fail();
    const std::string content = text_.substr(at_ + 1, end - at_ - 1);
    at_ = end + 1;
    return content;
  }

  bool truth() {
    skipBlanks();
    for (const std::string word : {"False", "True"}) {
      if (text_.compare(at_, word.size(), word) != 0) continue;
      at_ += word.size();
      return word == "True";
    }
    fail();
  }

  std::vector<std::uint64_t> tuple() {
    std::vector<std::uint64_t> numbers;
    expect('(');
    while (!take(')')) {
      numbers.push_back(number());
      if (!take(',') && !sees(')')) fail();
    }
    return numbers;
  }

  std::uint64_t number() {
    skipBlanks();
    std::uint64_t value = 0;
    const auto [stop, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error != std::errc()) fail();
    at_ = static_cast<std::size_t>(stop - text_.data());
    take('L');  // Python 2 wrote long numbers so
    return value;
  }

  void add(Key key) {
    if ((keys_ & key) != 0) fail();
    keys_ |= key;
  }
  void skipBlanks() { at_ = std::min(text_.find_first_not_of(" \t\n", at_), text_.size()); }
  bool sees(char letter) {
    skipBlanks();
    return at_ < text_.size() && text_[at_] == letter;
  }
  bool take(char letter) {
    const bool is_there = sees(letter);
    if (is_there) ++at_;
    return is_there;
  }
  void expect(char letter) {
    if (!take(letter)) fail();
  }
  [[noreturn]] static void fail() { throw std::invalid_argument("the header of the array is damaged"); }

  std::string text_;
  std::size_t at_ = 0;
  unsigned keys_ = 0;
};

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
  std::uint64_t characters = 0;
  const char* end = dtype.data() + dtype.size();
  const bool is_text = dtype.size() > 2 && (dtype[1] == 'U' || dtype[1] == 'S') &&
                       std::from_chars(dtype.data() + 2, end, characters).ptr == end;
  if (!is_text || header.shape.size() != 1)
    throw std::invalid_argument("dtype " + dtype + ", shape " + shapeText(header.shape) + "; expected a list of texts");
  const std::uint64_t width = dtype[1] == 'U' ? 4 : 1;
  checkSize(bytes, header, header.shape[0], characters, width);
  const std::uint64_t size = bytes.size() - header.data_begin;
  if (size > kMostTextBytes || (size == 0 && header.shape[0] > 0)) throw std::invalid_argument("no names of joints");
  std::vector<char> raw(size);
  bytes.read(header.data_begin, raw.data(), raw.size());
  std::vector<std::string> texts;
  for (std::uint64_t i = 0; i < header.shape[0]; ++i)
    texts.push_back(textAt(raw.data() + i * characters * width, characters, header));
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
  NpyHeader header = HeaderText(std::move(text)).read();
  header.data_begin = text_begin + length;
  return header;
}

NpyTable::NpyTable(std::unique_ptr<Bytes> bytes, std::string source)
    : bytes_(std::move(bytes)), source_(std::move(source)) {
  try {
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
  } catch (const std::invalid_argument& error) {
    fail(error.what());
  }
}

void NpyTable::read(std::uint64_t first, std::size_t count, double* to) {
  try {
    if (header_.dtype[2] == '8') {
      readAs<double>(first, count, to);
    } else {
      readAs<float>(first, count, to);
    }
  } catch (const std::invalid_argument& error) {
    fail(error.what());
  }
}

template <typename Number>
void NpyTable::readAs(std::uint64_t first, std::size_t count, double* to) {
  const bool is_c = header_.order == NpyHeader::Order::C;
  const auto numbers = [&](std::uint64_t begin, std::size_t size) {
    raw_.resize(size * sizeof(Number));
    bytes_->read(header_.data_begin + begin * sizeof(Number), raw_.data(), raw_.size());
  };
  const auto convert = [&](std::size_t size, std::size_t stride, double* place) {
    const bool is_native = header_.dtype[0] == kNativeOrder;
    for (std::size_t i = 0; i < size; ++i) {
      const auto number = numberAt<Number>(raw_.data() + i * sizeof(Number));
      place[i * stride] = static_cast<double>(is_native ? number : swapped(number));
    }
  };
  if (is_c) {
    numbers(first * columns_, count * columns_);
    convert(count * columns_, 1, to);
  } else {
    for (std::uint64_t column = 0; column < columns_; ++column) {
      numbers(column * rows_ + first, count);
      convert(count, columns_, to + column);
    }
  }
}

void NpyTable::fail(const std::string& what) const { throw std::invalid_argument(source_ + ": " + what); }

std::vector<std::string> readNpyTexts(Bytes& bytes, const std::string& source) {
  try {
    return readTexts(bytes);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(source + ": " + error.what());
  }
}

}  // namespace proximity_server::tools
