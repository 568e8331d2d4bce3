/// Reads and writes the fields of a protocol buffer, without its library: numbers, 32-bit floats and bytes.
///
///     WireReader fields(bytes);
///     while (fields.next()) switch (fields.number()) { case 3: x = fields.float32(); break; ... }   // others: skipped
///     if (!fields.ok()) ... fields.problem()
///
/// Source: Protocol Buffers, "Encoding" (wire types 0, 1, 2 and 5; groups are refused). Bad input: reading stops at the
/// first fault, and problem() names it. A field asked for as another type than it is stored as is a fault too.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace holdfast::io {

class WireReader {
 public:
  explicit WireReader(std::string_view bytes) : rest_(bytes) {}

  /// Goes to the next field; false at the end and after a fault.
  [[nodiscard]] bool next() {
    if (!problem_.empty() || rest_.empty()) return false;
    const std::uint64_t key = varint(rest_);
    number_ = key >> 3;
    type_ = static_cast<unsigned>(key & 7);
    if (problem_.empty() && (number_ == 0 || number_ >= (std::uint64_t(1) << 29)))
      fault("a field number is impossible");
    switch (type_) {
      case 0:
        value_ = varint(rest_);
        break;
      case 1:
        payload_ = take(8);
        break;
      case 2: {
        const std::uint64_t length = varint(rest_);
        if (length > rest_.size()) {
          fault("a field is longer than the message");
        } else {
          payload_ = take(static_cast<std::size_t>(length));
        }
        break;
      }
      case 5:
        payload_ = take(4);
        break;
      default:
        fault("a field has an unknown type");
        break;
    }
    return problem_.empty();
  }

  [[nodiscard]] std::uint64_t number() const { return number_; }
  [[nodiscard]] bool ok() const { return problem_.empty(); }
  [[nodiscard]] std::string_view problem() const { return problem_; }

  [[nodiscard]] std::uint64_t integer() { return expect(0) ? value_ : 0; }
  [[nodiscard]] float float32() { return expect(5) ? float_at(0) : 0.0f; }
  [[nodiscard]] std::string_view bytes() { return expect(2) ? payload_ : std::string_view(); }

  /// Calls visit(float) for each number of a repeated field: packed or single.
  template <typename Visit>
  void floats(const Visit& visit) {
    if (type_ == 5) return visit(float_at(0));
    if (!expect(2)) return;
    if (payload_.size() % 4 != 0) return fault("packed floats are cut short");
    for (std::size_t i = 0; i < payload_.size(); i += 4) visit(float_at(i));
  }

 private:
  void fault(std::string_view problem) {
    if (problem_.empty()) problem_ = problem;
  }
  [[nodiscard]] bool expect(unsigned type) {
    if (type_ != type) fault("a field is stored as another type");
    return type_ == type;
  }
  std::string_view take(std::size_t count) {
    if (count > rest_.size()) {
      fault("the message is cut short");
      return {};
    }
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }
  std::uint64_t varint(std::string_view& from) {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      if (from.empty()) {
        fault("the message is cut short");
        return 0;
      }
      const auto byte = static_cast<unsigned char>(from.front());
      from.remove_prefix(1);
      value |= static_cast<std::uint64_t>(byte & 127) << shift;
      if (byte < 128) return value;
    }
    fault("a number has too many bytes");
    return 0;
  }
  [[nodiscard]] float float_at(std::size_t at) const {
    std::uint32_t bits = 0;
    for (std::size_t i = 4; i-- > 0;) bits = (bits << 8) | static_cast<unsigned char>(payload_[at + i]);
    return std::bit_cast<float>(bits);
  }

  std::string_view rest_;
  std::string_view payload_;
  std::string_view problem_;
  std::uint64_t number_ = 0;
  std::uint64_t value_ = 0;
  unsigned type_ = 0;
};

class WireWriter {
 public:
  void integer(unsigned number, std::uint64_t value) {
    varint(number << 3);
    varint(value);
  }
  void float32(unsigned number, float value) {
    varint((number << 3) | 5);
    append(value);
  }
  void bytes(unsigned number, std::string_view value) {
    varint((number << 3) | 2);
    varint(value.size());
    bytes_ += value;
  }
  template <typename Floats>
  void floats(unsigned number, const Floats& values) {
    varint((number << 3) | 2);
    varint(values.size() * 4);
    for (const float value : values) append(value);
  }

  [[nodiscard]] const std::string& written() const { return bytes_; }

 private:
  void varint(std::uint64_t value) {
    for (; value >= 128; value >>= 7) bytes_ += static_cast<char>((value & 127) | 128);
    bytes_ += static_cast<char>(value);
  }
  void append(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    for (int shift = 0; shift < 32; shift += 8) bytes_ += static_cast<char>((bits >> shift) & 255);
  }

  std::string bytes_;
};

}  // namespace holdfast::io
