/// Reading numbers, times and cells out of text: exact, fast and the same under every locale.
///
/// Times are decimal numbers turned into whole nanoseconds digit by digit, never through a double: 1705504375.238748312
/// s keeps its last digit. Exponents are understood (numpy writes 1.705504375238748312e+09). Beyond nanoseconds the
/// value is rounded, halves away from zero. Bad input: nothing is returned.
#pragma once

#include <charconv>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include <holdfast/timing/clock.hpp>

namespace holdfast::io::detail {

[[nodiscard]] constexpr bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
[[nodiscard]] constexpr bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

[[nodiscard]] inline std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

/// A double, or NaN and infinity as spelled "nan", "inf"; nothing when any character is left over or the number does
/// not fit.
[[nodiscard]] inline std::optional<double> parse_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// sign * 0.DIGITS * 10^point, where the digits of whole and fraction stand in `text` with perhaps one '.' among them.
struct Decimal {
  bool negative = false;
  std::string_view digits;  ///< digits and at most one '.'
  std::int64_t point = 0;   ///< count of digits before the decimal point, exponent included
};

[[nodiscard]] inline std::optional<Decimal> parse_decimal(std::string_view text) {
  Decimal decimal;
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
    decimal.negative = text.front() == '-';
    text.remove_prefix(1);
  }
  std::size_t end = 0, digits = 0, dots = 0, whole = 0;
  for (; end < text.size() && (is_digit(text[end]) || text[end] == '.'); ++end) {
    if (text[end] == '.') {
      ++dots;
    } else {
      ++digits;
      if (dots == 0) ++whole;
    }
  }
  if (digits == 0 || dots > 1) return std::nullopt;
  decimal.digits = text.substr(0, end);
  decimal.point = static_cast<std::int64_t>(whole);
  text.remove_prefix(end);
  if (text.empty()) return decimal;
  if (text.front() != 'e' && text.front() != 'E') return std::nullopt;
  text.remove_prefix(1);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  int exponent = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), exponent);
  if (error != std::errc() || rest != text.data() + text.size()) return std::nullopt;
  decimal.point += exponent;
  return decimal;
}

/// Whole units of 10^-unit_digits (9: seconds to nanoseconds; 0: the number is in nanoseconds already); nothing if it
/// does not fit.
[[nodiscard]] inline std::optional<Duration> parse_time(std::string_view text, int unit_digits) {
  const auto decimal = parse_decimal(text);
  if (!decimal) return std::nullopt;
  constexpr std::int64_t limit = std::numeric_limits<std::int64_t>::max() / 2;  // differences of two times still fit
  const std::int64_t keep = decimal->point + unit_digits;
  std::int64_t value = 0, taken = 0;
  bool round_up = false;
  for (const char c : decimal->digits) {
    if (c == '.') continue;
    if (taken >= keep) {
      round_up = taken == keep && c >= '5';
      break;
    }
    if (value > (limit - 9) / 10) return std::nullopt;
    value = 10 * value + (c - '0');
    ++taken;
  }
  if (value != 0) {
    for (; taken < keep; ++taken) {
      if (value > limit / 10) return std::nullopt;
      value *= 10;
    }
  }
  if (round_up) ++value;
  return Duration(decimal->negative ? -value : value);
}

/// Splits a row at commas (or semicolons), or, when there are none, at blanks. Cells are trimmed, and freed of double
/// quotes.
inline void split(std::string_view row, bool at_commas, std::vector<std::string_view>& cells) {
  cells.clear();
  if (at_commas) {
    while (true) {
      const std::size_t end = row.find_first_of(",;");
      std::string_view cell = trimmed(row.substr(0, end));
      if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"')
        cell = trimmed(cell.substr(1, cell.size() - 2));
      cells.push_back(cell);
      if (end == std::string_view::npos) return;
      row.remove_prefix(end + 1);
    }
  }
  std::size_t i = 0;
  while (true) {
    while (i < row.size() && is_blank(row[i])) ++i;
    if (i == row.size()) return;
    const std::size_t start = i;
    while (i < row.size() && !is_blank(row[i])) ++i;
    cells.push_back(row.substr(start, i - start));
  }
}

[[nodiscard]] inline bool has_commas(std::string_view row) {
  return row.find_first_of(",;") != std::string_view::npos;
}

/// Hands out the lines of a text, without their line ends, counting from 1.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);  // UTF-8 byte order mark
  }
  [[nodiscard]] bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    line = trimmed(rest_.substr(0, end));
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++number_;
    return true;
  }
  [[nodiscard]] std::size_t number() const { return number_; }

 private:
  std::string_view rest_;
  std::size_t number_ = 0;
};

}  // namespace holdfast::io::detail
