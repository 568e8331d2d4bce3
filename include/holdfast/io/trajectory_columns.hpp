/// Which column of a motion file holds what: by the names of a header, or by the place known from the format.
///
/// Names understood, in any order and case, with units in the name or in brackets:
///   time         t, time, timestamp, stamp, sec, ...                t_s, time_ms, "#timestamp [ns]", timestamp(s)
///   position     x, px, tx, pos_x, position.x, p_RS_R_x             px_m, x_mm
///   orientation  qw, q_w, quat_w, rot_w, orientation.w, q_RS_w
/// Other columns (inertial, magnetic, velocities, ...) are left alone. A file may have only positions or only
/// orientations. Bad input: a header that names no time, a part of a position or quaternion, or the same twice is
/// described in words.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <holdfast/io/trajectory_report.hpp>
#include <holdfast/io/trajectory_text.hpp>

namespace holdfast::io::detail {

inline constexpr std::size_t no_column = static_cast<std::size_t>(-1);

struct TrajectoryColumns {
  TrajectoryFormat format = TrajectoryFormat::named_csv;
  bool at_commas = true;
  std::size_t count = 0;      ///< cells of a row
  bool more_allowed = false;  ///< rows may have further cells
  std::size_t time = no_column;
  std::array<std::size_t, 3> p{no_column, no_column, no_column};             ///< x, y, z
  std::array<std::size_t, 4> q{no_column, no_column, no_column, no_column};  ///< w, x, y, z
  std::optional<int> time_digits;  ///< decimal digits to nanoseconds: s 9, ms 6, us 3, ns 0; nothing: not said
  double metres = 1.0;             ///< of the file's unit of length

  [[nodiscard]] bool has_position() const { return p[0] != no_column; }
  [[nodiscard]] bool has_orientation() const { return q[0] != no_column; }
};

/// A column's name in lower-case words: "#timestamp [ns]" is {timestamp} in ns, "p_RS_R_x [m]" is {p, rs, r, x} in m.
struct ColumnName {
  std::vector<std::string> words;
  std::string unit;
};

[[nodiscard]] inline bool is_unit(std::string_view word) {
  for (const std::string_view unit : {"s", "sec", "seconds", "ms", "us", "ns", "m", "mm", "cm"}) {
    if (word == unit) return true;
  }
  return false;
}

[[nodiscard]] inline ColumnName column_name(std::string_view text) {
  ColumnName name;
  std::string word;
  bool in_brackets = false;
  const auto finish = [&] {
    if (!word.empty()) (in_brackets ? name.unit = word : name.words.emplace_back(word));
    word.clear();
  };
  for (const char c : text) {
    const char lower = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if (c == '[' || c == '(') {
      finish();
      in_brackets = true;
    } else if (c == ']' || c == ')') {
      finish();
      in_brackets = false;
    } else if ((lower >= 'a' && lower <= 'z') || is_digit(c)) {
      word += lower;
    } else {
      finish();
    }
  }
  finish();
  if (name.unit.empty() && name.words.size() > 1 && is_unit(name.words.back())) {
    name.unit = name.words.back();
    name.words.pop_back();
  }
  return name;
}

[[nodiscard]] inline bool starts_with_any(std::string_view word, std::initializer_list<std::string_view> stems) {
  for (const std::string_view stem : stems) {
    if (word.starts_with(stem)) return true;
  }
  return false;
}

[[nodiscard]] inline bool is_time_name(const ColumnName& name) {
  if (name.words.size() != 1) return false;
  const std::string& word = name.words.front();
  for (const std::string_view known : {"t", "time", "timestamp", "stamp", "timestamps", "sec", "secs", "seconds"}) {
    if (word == known) return true;
  }
  return false;
}

/// What a pose's column holds: 'p' or 'q' and the axis, or nothing.
struct PoseColumn {
  char part;
  char axis;
};

[[nodiscard]] inline std::optional<PoseColumn> pose_column(const ColumnName& name) {
  if (name.words.empty()) return std::nullopt;
  std::string_view axis = name.words.back();
  std::string_view stem = name.words.size() > 1 ? std::string_view(name.words.front()) : std::string_view();
  if (stem == "pose" && name.words.size() > 2) stem = name.words[1];  // pose.position.x
  if (name.words.size() == 1 && axis.size() == 2) {                   // qw, px, tx
    stem = axis.substr(0, 1);
    axis = axis.substr(1);
  }
  if (axis.size() != 1) return std::nullopt;
  const char a = axis.front();
  const bool known_axis = a == 'w' || a == 'x' || a == 'y' || a == 'z';
  if (!known_axis) return std::nullopt;
  if (stem == "q" || starts_with_any(stem, {"quat", "rot", "orient"})) return PoseColumn{'q', a};
  if (a == 'w') return std::nullopt;
  if (stem.empty() || stem == "p" || stem == "t" || starts_with_any(stem, {"pos", "trans"})) return PoseColumn{'p', a};
  return std::nullopt;
}

/// The columns a header names; when they are no trajectory's, `problem` says why.
[[nodiscard]] inline std::optional<TrajectoryColumns> columns_of_header(std::string_view header, std::string& problem) {
  TrajectoryColumns columns;
  columns.at_commas = has_commas(header);
  std::vector<std::string_view> cells;
  split(header, columns.at_commas, cells);
  columns.count = cells.size();
  bool twice = false;
  const auto take = [&](std::size_t& place, std::size_t column) {
    twice = twice || place != no_column;
    place = column;
  };
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const ColumnName name = column_name(cells[i]);
    if (is_time_name(name)) {
      take(columns.time, i);
      const std::string& unit = name.unit;
      if (unit == "ns") columns.time_digits = 0;
      if (unit == "us") columns.time_digits = 3;
      if (unit == "ms") columns.time_digits = 6;
      if (unit == "s" || unit == "sec" || unit == "seconds" || name.words.front().starts_with("sec"))
        columns.time_digits = 9;
    } else if (const auto pose = pose_column(name)) {
      if (pose->part == 'q') {
        take(columns.q[pose->axis == 'w' ? 0u : static_cast<std::size_t>(pose->axis - 'w')], i);
      } else {
        take(columns.p[static_cast<std::size_t>(pose->axis - 'x')], i);
        if (name.unit == "mm") columns.metres = 1e-3;
        if (name.unit == "cm") columns.metres = 1e-2;
      }
    }
  }
  const auto named = [](const auto& places) {
    std::size_t count = 0;
    for (const std::size_t place : places) count += place != no_column ? 1 : 0;
    return count;
  };
  const std::size_t positions = named(columns.p), orientations = named(columns.q);
  if (twice) {
    problem = "the header names a column twice";
  } else if (columns.time == no_column) {
    problem = "the header names no time column";
  } else if (positions + orientations == 0) {
    problem = "the header names no position or orientation column";
  } else if (positions != 0 && positions != 3) {
    problem = "the header names only a part of the position";
  } else if (orientations != 0 && orientations != 4) {
    problem = "the header names only a part of the quaternion";
  } else {
    return columns;
  }
  return std::nullopt;
}

/// TUM's and EuRoC's columns for a first row of numbers; nothing when the row is neither.
[[nodiscard]] inline std::optional<TrajectoryColumns> columns_of_row(std::string_view row) {
  TrajectoryColumns columns;
  columns.at_commas = has_commas(row);
  std::vector<std::string_view> cells;
  split(row, columns.at_commas, cells);
  if (cells.size() < 8) return std::nullopt;
  for (std::size_t i = 0; i < 8; ++i) {
    if (!parse_number(cells[i])) return std::nullopt;
  }
  // Nanoseconds since 1970 have 19 digits and no point; seconds have both fewer digits and, nearly always, a point.
  bool whole = cells[0].size() >= 15;
  for (const char c : cells[0]) whole = whole && is_digit(c);
  columns.time = 0;
  columns.p = {1, 2, 3};
  columns.count = cells.size();
  if (columns.at_commas && whole) {
    columns.format = TrajectoryFormat::euroc;
    columns.q = {4, 5, 6, 7};
    columns.time_digits = 0;
    return columns;
  }
  if (cells.size() != 8) return std::nullopt;
  columns.format = TrajectoryFormat::tum;
  columns.q = {7, 4, 5, 6};
  columns.time_digits = 9;
  return columns;
}

}  // namespace holdfast::io::detail
