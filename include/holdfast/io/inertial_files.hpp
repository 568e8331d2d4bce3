/// Reads a recording of inertial sensors: a text with named columns (named_columns.hpp).
///
///   t, gx, gy, gz, ax, ay, az    or gyr_x, ..., acc_x, ...; also gyro_, w_, omega_, accel_, a_: rad/s and m/s^2, in
/// the
///                                 body's axes; other columns are left alone
/// as, for instance, t_s,gyr_x_rad_s,gyr_y,gyr_z,acc_x_m_s2,acc_y,acc_z; or a EuRoC file: #timestamp [ns],w_RS_S_x [rad
/// s^-1], ... Times do not decrease.
/// Bad input: an InputError that names file, line, column, what was found and what was expected: rates in degrees and
/// forces in units of gravity, where the header says so, too; and any other unit in brackets.
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include <holdfast/io/named_columns.hpp>
#include <holdfast/io/trajectory_report.hpp>
#include <holdfast/io/whole_file.hpp>
#include <holdfast/tracking/inertial_reading.hpp>

namespace holdfast::io {

namespace detail {

[[nodiscard]] inline NamedColumn time_column(const NamedColumns& rows) {
  return rows.column({"t", "time", "timestamp", "stamp", "seconds"});
}

/// The time of a row, which is not before that of the row before.
[[nodiscard]] inline HostTime time_in_order(const NamedColumns& rows, const NamedColumn& column, HostTime& newest) {
  const HostTime t = rows.time(column);
  if (t < newest) rows.refuse(column, "goes back in time", "times that do not decrease");
  return newest = t;
}

using UnitWords = std::initializer_list<std::string_view>;

/// Whether a column's name says another unit than it should: in brackets, a word that is among `wrong` or, beside one that is
/// among `right`, one that is not; elsewhere a word that is among `wrong`. (What stands in brackets may be a frame, too.)
[[nodiscard]] inline bool is_of_other_unit(std::string_view name, UnitWords right, UnitWords wrong) {
  const auto is_among = [](std::string_view word, UnitWords words) {
    return std::find(words.begin(), words.end(), word) != words.end();
  };
  std::string word;
  bool is_right = false, is_other = false;  // of the words in one pair of brackets
  for (const char c : std::string(name) + ' ') {
    const char lower = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if ((lower >= 'a' && lower <= 'z') || is_digit(c)) {
      word += lower;
      continue;
    }
    if (is_among(word, wrong)) return true;
    (is_among(word, right) ? is_right : is_other) |= !word.empty();
    word.clear();
    if (c == '[' || c == '(') is_right = is_other = false;
    if ((c == ']' || c == ')') && is_right && is_other) return true;
  }
  return false;
}

[[nodiscard]] inline std::array<NamedColumn, 3> axes_columns(const NamedColumns& rows,
                                                             std::initializer_list<std::string_view> words,
                                                             UnitWords right_units, UnitWords wrong_units,
                                                             const std::string& problem) {
  const std::array columns{rows.axis_column(words, 'x'), rows.axis_column(words, 'y'), rows.axis_column(words, 'z')};
  for (const NamedColumn& column : columns) {
    if (is_of_other_unit(column.name, right_units, wrong_units)) rows.refuse_header(column.name, problem);
  }
  return columns;
}

}  // namespace detail

struct InertialFile {
  std::vector<InertialReading> readings;
  std::size_t dropped = 0;  ///< bad rows, in a lenient reading
};

[[nodiscard]] inline InertialFile parse_inertial(std::string_view text, const std::string& file, ReadMode mode) {
  detail::NamedColumns rows(text, file, "t_s,gx_rad_s,gy_rad_s,gz_rad_s,ax_m_s2,ay_m_s2,az_m_s2");
  const detail::NamedColumn t = detail::time_column(rows);
  const auto rate =
      detail::axes_columns(rows, {"g", "gyr", "gyro", "w", "omega"},
                           {"rad", "rads", "radian", "radians", "s", "sec", "second", "seconds", "1", "per"},
                           {"deg", "degs", "degree", "degrees", "dps", "mdps", "mrad", "rpm"}, "is not in rad/s");
  const auto force = detail::axes_columns(
      rows, {"a", "acc", "accel"},
      {"m", "meter", "meters", "metre", "metres", "s", "sec", "second", "seconds", "s2", "2", "per", "squared"},
      {"g", "mg", "ug", "gs", "cm", "mm", "gal"}, "is not in m/s^2");
  InertialFile result;
  HostTime newest = HostTime::min();
  for (bool more = true; more;) {
    try {
      more = rows.next();
      if (!more) break;
      const Vector3 rate_B(rows.number(rate[0]), rows.number(rate[1]), rows.number(rate[2]));
      const Vector3 force_B(rows.number(force[0]), rows.number(force[1]), rows.number(force[2]));
      result.readings.push_back({detail::time_in_order(rows, t, newest), rate_B, force_B});
    } catch (const InputError&) {
      if (mode == ReadMode::strict) throw;
      ++result.dropped;
    }
  }
  if (result.readings.empty()) rows.refuse_end();
  return result;
}
[[nodiscard]] inline std::vector<InertialReading> parse_inertial(std::string_view text, const std::string& file) {
  return parse_inertial(text, file, ReadMode::strict).readings;
}

[[nodiscard]] inline InertialFile read_inertial(const std::filesystem::path& file, ReadMode mode) {
  return parse_inertial(read_whole_file(file), file.string(), mode);
}
[[nodiscard]] inline std::vector<InertialReading> read_inertial(const std::filesystem::path& file) {
  return read_inertial(file, ReadMode::strict).readings;
}

}  // namespace holdfast::io
