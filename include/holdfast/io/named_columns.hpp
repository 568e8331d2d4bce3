/// A text of numbers in columns that its first line names: comma or blank separated, the columns in any order.
///
/// A column is found by the first word of its name, whatever the case; a unit may follow, joined on or in brackets:
/// "t_s", "anchor_id", "px_m", "z (Vicon/world frame)", "ax_m_s2". Times are s unless the name says ms, us or ns, and
/// lengths m unless it says cm or mm. Other columns are left alone. Empty lines, and later ones that begin with #, are
/// skipped.
/// Bad input: an InputError that names file, line, column, what was found and what was expected.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/io/input_error.hpp>
#include <holdfast/io/trajectory_columns.hpp>
#include <holdfast/io/trajectory_text.hpp>

namespace holdfast::io::detail {

/// A column by the place it stands at.
struct NamedColumn {
  std::size_t place = no_column;
  std::string name;  ///< as the file has it
  ColumnName parts;
};

class NamedColumns {
 public:
  /// `text` must outlive this. `expected`: the header, for messages.
  NamedColumns(std::string_view text, std::string file, std::string expected)
      : lines_(text), file_(std::move(file)), expected_(std::move(expected)) {
    if (!next_line()) throw InputError({.file = file_, .problem = "is empty", .expected = "a header: " + expected_});
    at_commas_ = has_commas(line_);
    header_ = line_;
    split(header_, at_commas_, header_cells_);
  }

  /// The column whose name begins with one of the words.
  [[nodiscard]] NamedColumn column(std::initializer_list<std::string_view> words) const {
    return find(std::string(*words.begin()), [&](const std::vector<std::string>& name) {
      return std::find(words.begin(), words.end(), name.front()) != words.end();
    });
  }
  /// The column of one axis: its name begins with one of the words and the axis, as one word or as two: gx, gyr_x; or
  /// as EuRoC's files have it: w_RS_S_x.
  [[nodiscard]] NamedColumn axis_column(std::initializer_list<std::string_view> words, char axis) const {
    return find(std::string(*words.begin()) + axis, [&](const std::vector<std::string>& name) {
      return std::any_of(words.begin(), words.end(), [&](std::string_view word) {
        return name.front() == std::string(word) + axis ||
               (name.front() == word && name.size() > 1 && name[1] == std::string(1, axis)) ||
               (name.front() == word && name.size() == 4 && name[1] == "rs" && name[3] == std::string(1, axis));
      });
    });
  }

  /// Goes on to the next row; false after the last.
  [[nodiscard]] bool next() {
    do {
      if (!next_line()) return false;
    } while (line_.front() == '#');
    split(line_, at_commas_, cells_);
    if (cells_.size() == header_cells_.size()) return true;
    throw InputError({.file = file_,
                      .line = lines_.number(),
                      .problem = "has " + std::to_string(cells_.size()) + " cells",
                      .value = std::string(line_),
                      .expected = std::to_string(header_cells_.size()) + " as in the header"});
  }

  [[nodiscard]] double number(const NamedColumn& column) const {
    const std::optional<double> value = parse_number(cells_[column.place]);
    if (!value || !std::isfinite(*value)) refuse(column, "is no number", "a finite number");
    return *value;
  }
  /// In metres.
  [[nodiscard]] double length(const NamedColumn& column) const {
    const std::string& unit = column.parts.unit;
    return number(column) * (unit == "mm" ? 1e-3 : unit == "cm" ? 1e-2 : 1.0);
  }
  [[nodiscard]] int integer(const NamedColumn& column) const {
    const std::string_view cell = cells_[column.place];
    int value = 0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc() || end != cell.data() + cell.size()) refuse(column, "is no whole number", "an integer");
    return value;
  }
  [[nodiscard]] HostTime time(const NamedColumn& column) const {
    const std::string& unit = column.parts.unit;
    const int digits = unit == "ns" ? 0 : unit == "us" ? 3 : unit == "ms" ? 6 : 9;
    const std::optional<Duration> t = parse_time(cells_[column.place], digits);
    if (!t) refuse(column, "is no time", "a number");
    return HostTime(*t);
  }

  /// The row has a bad cell.
  [[noreturn]] void refuse(const NamedColumn& column, const std::string& problem, const std::string& expected) const {
    throw InputError({.file = file_,
                      .line = lines_.number(),
                      .key = column.name,
                      .problem = problem,
                      .value = std::string(cells_[column.place]),
                      .expected = expected});
  }
  /// The header is not as it should be.
  [[noreturn]] void refuse_header(const std::string& key, const std::string& problem) const {
    throw InputError({.file = file_,
                      .line = header_line_,
                      .key = key,
                      .problem = problem,
                      .value = std::string(header_),
                      .expected = expected_});
  }
  [[noreturn]] void refuse_end() const {
    throw InputError({.file = file_, .line = lines_.number(), .problem = "has no rows", .expected = "numbers"});
  }

 private:
  /// The one column whose name's words are right; `key` names it in messages.
  template <typename IsIt>
  [[nodiscard]] NamedColumn find(const std::string& key, const IsIt& is_it) const {
    NamedColumn found;
    for (std::size_t i = 0; i < header_cells_.size(); ++i) {
      const ColumnName parts = column_name(header_cells_[i]);
      if (parts.words.empty() || !is_it(parts.words)) continue;
      if (found.place != no_column) refuse_header(key, "the header names this column twice");
      found = {i, std::string(header_cells_[i]), parts};
    }
    if (found.place == no_column) refuse_header(key, "the header does not name this column");
    return found;
  }

  [[nodiscard]] bool next_line() {
    do {
      if (!lines_.next(line_)) return false;
    } while (line_.empty());
    if (header_line_ == 0) header_line_ = lines_.number();
    return true;
  }

  Lines lines_;
  std::string file_, expected_;
  std::string_view line_, header_;
  std::size_t header_line_ = 0;
  bool at_commas_ = true;
  std::vector<std::string_view> header_cells_, cells_;
};

}  // namespace holdfast::io::detail
