/// Tells a motion file's format from its first lines.
///
/// The first line that is neither empty nor a comment must be a row of TUM or EuRoC numbers or a header that names the
/// columns. In lenient mode up to 100 other lines before it are dropped and counted as malformed. Bad input: an
/// InputError that names the first line that did not fit.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <holdfast/io/input_error.hpp>
#include <holdfast/io/trajectory_columns.hpp>
#include <holdfast/io/trajectory_report.hpp>
#include <holdfast/io/trajectory_text.hpp>

namespace holdfast::io::detail {

[[nodiscard]] inline bool starts_with_number(std::string_view line) {
  std::vector<std::string_view> cells;
  split(line, has_commas(line), cells);
  return !cells.empty() && parse_decimal(cells.front()).has_value();
}

/// Takes the columns' places from a comment that names all of them, position and orientation.
inline void trust(std::string_view comment, TrajectoryColumns& columns) {
  std::string problem;
  const auto named = columns_of_header(comment, problem);
  if (!named || named->count != columns.count || !named->has_position() || !named->has_orientation()) return;
  columns.time = named->time;
  columns.p = named->p;
  columns.q = named->q;
  columns.metres = named->metres;
  if (named->time_digits) columns.time_digits = named->time_digits;
}

[[nodiscard]] inline InputError unknown_format(std::string_view file, std::size_t line_number, std::string_view line,
                                               const std::string& header_problem) {
  return InputError({.file = std::string(file),
                     .line = line_number,
                     .problem = starts_with_number(line) ? "not a row of a known format" : header_problem,
                     .value = std::string(line),
                     .expected =
                         "TUM (t tx ty tz qx qy qz qw, seconds), EuRoC (t,x,y,z,qw,qx,qy,qz, whole nanoseconds) "
                         "or a header that names t, px, py, pz, qw, qx, qy, qz"});
}

/// The columns; leaves `lines` before the first data row.
[[nodiscard]] inline TrajectoryColumns find_columns(Lines& lines, std::string_view file, ReadMode mode,
                                                    TrajectoryReport& report) {
  constexpr std::size_t most_dropped = 100;
  std::vector<InputError> errors;  // of the lines that did not fit
  std::string_view line, comment;
  std::string problem;
  for (Lines before = lines; lines.next(line); before = lines) {
    if (line.empty()) continue;
    if (line.front() == '#') {
      comment = line.substr(1);
      continue;
    }
    if (auto columns = columns_of_row(line)) {
      trust(comment, *columns);
      lines = before;
      return *columns;
    }
    if (auto columns = columns_of_header(line, problem)) return *columns;
    errors.push_back(unknown_format(file, lines.number(), line, problem));
    if (mode == ReadMode::strict || errors.size() > most_dropped) break;
    ++report.rows;
    ++report.dropped[static_cast<std::size_t>(RowFault::malformed)];
  }
  if (!errors.empty()) throw errors.front();
  throw InputError({.file = std::string(file), .problem = "the file holds no rows", .expected = "a recorded motion"});
}

}  // namespace holdfast::io::detail
