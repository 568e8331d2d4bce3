/// Reads recorded motion: TUM, EuRoC and CSV with a header that names its columns; the format is told from the content.
///
///   TUM         t tx ty tz qx qy qz qw          seconds; blanks or commas; lines that start with # are comments
///   EuRoC       t,px,py,pz,qw,qx,qy,qz[,...]    whole nanoseconds, commas
///   named CSV   see trajectory_columns.hpp      a row whose position or quaternion is all NaN (or empty) is an
///   occlusion: skipped
///                                               and counted
/// A comment line right before TUM or EuRoC rows that names all their columns is believed, for the order of a
/// quaternion's parts. Times become whole nanoseconds exactly; positions metres; quaternions unit length. Samples come
/// out with strictly increasing times.
///
/// Bad input, strict (the default): InputError with file, line, what was found and expected, for a row that is
/// malformed (wrong count of columns, not a number), not finite, a quaternion of a length outside [0.5, 2], or a time
/// that repeats or goes back. ReadMode::lenient drops such rows and counts them in the report. A file that cannot be
/// read, has no known format or fewer than two poses is an error in both. Likely unit mistakes are reported as
/// suspicions, never repaired. Sources: TUM RGB-D benchmark's and EuRoC MAV dataset's ground-truth formats.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/io/input_error.hpp>
#include <holdfast/io/trajectory_columns.hpp>
#include <holdfast/io/trajectory_format.hpp>
#include <holdfast/io/trajectory_report.hpp>
#include <holdfast/io/trajectory_suspicions.hpp>
#include <holdfast/io/trajectory_text.hpp>
#include <holdfast/io/trajectory_write.hpp>
#include <holdfast/io/whole_file.hpp>
#include <holdfast/motion/sampled_trajectory.hpp>

namespace holdfast::io {

struct TrajectoryFile {
  std::vector<TimedPose> samples;
  TrajectoryReport report;
};

namespace detail {

/// Parses one text; keeps what the functions of a reader share.
class TrajectoryParser {
 public:
  TrajectoryParser(std::string_view text, std::string_view file, ReadMode mode)
      : text_(text), file_(file), mode_(mode), lines_(text) {}

  [[nodiscard]] TrajectoryFile parse() {
    columns_ = find_columns(lines_, file_, mode_, result_.report);
    result_.report.format = columns_.format;
    result_.report.has_position = columns_.has_position();
    result_.report.has_orientation = columns_.has_orientation();
    result_.samples.reserve(text_.size() / 64);
    std::string_view row;
    while (lines_.next(row)) {
      if (!row.empty() && row.front() != '#') read_row(row);
    }
    if (result_.samples.size() < 2) {
      throw InputError({.file = std::string(file_),
                        .problem = "holds " + std::to_string(result_.samples.size()) + " usable poses of " +
                                   std::to_string(result_.report.rows) + " rows",
                        .expected = "at least two"});
    }
    finish_report();
    return std::move(result_);
  }

 private:
  /// What a row is dropped for, with the words of the error that it is in strict mode.
  struct Fault {
    RowFault kind;
    std::string_view key, value, expected;
  };

  void read_row(std::string_view row) {
    ++result_.report.rows;
    split(row, columns_.at_commas, cells_);
    if (cells_.size() != columns_.count) {
      count_or_throw({RowFault::malformed, "", row, std::to_string(columns_.count) + " columns"});
      return;
    }
    if (!read_time() || !read_numbers()) return;
    if (is_occluded()) {
      ++result_.report.occlusions;
      return;
    }
    accept();
  }

  [[nodiscard]] bool read_time() {
    const std::string_view cell = cells_[columns_.time];
    if (!columns_.time_digits) {  // a header that does not say: whole numbers of 15 digits and more are nanoseconds
      columns_.time_digits = cell.size() >= 15 && cell.find('.') == std::string_view::npos ? 0 : 9;
    }
    const auto time = parse_time(cell, *columns_.time_digits);
    if (time) {
      time_ = HostTime(*time);
      return true;
    }
    const bool is_number = parse_decimal(cell).has_value();
    const auto value = parse_number(cell);
    if (value && !is_number) return refuse({RowFault::non_finite, "time", cell, "a finite time"});
    if (is_number) return refuse({RowFault::malformed, "time", cell, time_range()});
    return refuse({RowFault::malformed, "time", cell, "a number"});
  }

  [[nodiscard]] std::string_view time_range() const {
    return *columns_.time_digits == 9 ? "seconds within 146 years of zero (are these milliseconds or nanoseconds?)"
                                      : "a time within 146 years of zero";
  }

  [[nodiscard]] bool read_numbers() {
    static constexpr std::array<std::string_view, 3> p_names{"x", "y", "z"};
    static constexpr std::array<std::string_view, 4> q_names{"qw", "qx", "qy", "qz"};
    for (std::size_t i = 0; columns_.has_position() && i < 3; ++i) {
      if (!read_number(columns_.p[i], p_names[i], p_[i])) return false;
    }
    for (std::size_t i = 0; columns_.has_orientation() && i < 4; ++i) {
      if (!read_number(columns_.q[i], q_names[i], q_[i])) return false;
    }
    return true;
  }

  [[nodiscard]] bool read_number(std::size_t column, std::string_view key, double& number) {
    const std::string_view cell = cells_[column];
    if (cell.empty() && columns_.format == TrajectoryFormat::named_csv) {  // as pandas writes NaN
      number = std::numeric_limits<double>::quiet_NaN();
      return true;
    }
    const auto value = parse_number(cell);
    if (!value) return refuse({RowFault::malformed, key, cell, "a number"});
    number = *value;
    return true;
  }

  [[nodiscard]] bool is_occluded() const {
    if (columns_.format != TrajectoryFormat::named_csv) return false;
    const auto is_nan = [](double x) { return std::isnan(x); };
    return (columns_.has_position() && std::ranges::all_of(p_, is_nan)) ||
           (columns_.has_orientation() && std::ranges::all_of(q_, is_nan));
  }

  void accept() {
    static constexpr double farthest_m = 1e9;
    const Vector3 p(p_[0] * columns_.metres, p_[1] * columns_.metres, p_[2] * columns_.metres);
    const Quaternion q(q_[0], q_[1], q_[2], q_[3]);
    if (!p.allFinite() || !q.coeffs().allFinite()) {
      static_cast<void>(refuse({RowFault::non_finite, "", cells_text(), "finite numbers"}));
      return;
    }
    if (p.cwiseAbs().maxCoeff() > farthest_m) {
      static_cast<void>(refuse({RowFault::malformed, "position", cells_text(), "metres, below 1e9"}));
      return;
    }
    const auto X_WB = Rigid::make(q, p);
    if (!X_WB) {
      static_cast<void>(refuse({RowFault::bad_quaternion, "quaternion", cells_text(), "a length between 0.5 and 2"}));
      return;
    }
    if (!result_.samples.empty() && time_ <= result_.samples.back().t) {
      const RowFault kind = time_ == result_.samples.back().t ? RowFault::duplicate : RowFault::backward;
      static_cast<void>(refuse({kind, "time", cells_[columns_.time], "a time later than the row before"}));
      return;
    }
    if (std::abs(q.norm() - 1.0) > 1e-3) ++result_.report.non_unit_quaternions;
    result_.samples.push_back({time_, *X_WB});
  }

  [[nodiscard]] std::string_view cells_text() const {
    const char* const first = cells_.front().data();
    return {first, static_cast<std::size_t>(cells_.back().data() + cells_.back().size() - first)};
  }

  /// False, for a caller to hand on.
  [[nodiscard]] bool refuse(const Fault& fault) {
    count_or_throw(fault);
    return false;
  }

  void count_or_throw(const Fault& fault) {
    const auto kind = static_cast<std::size_t>(fault.kind);
    if (mode_ == ReadMode::strict) {
      throw InputError({.file = std::string(file_),
                        .line = lines_.number(),
                        .key = std::string(fault.key),
                        .problem = std::string(row_fault_names[kind]),
                        .value = std::string(fault.value),
                        .expected = std::string(fault.expected)});
    }
    ++result_.report.dropped[kind];
  }

  void finish_report() {
    TrajectoryReport& report = result_.report;
    const std::vector<TimedPose>& samples = result_.samples;
    report.poses = samples.size();
    report.duration = samples.back().t - samples.front().t;
    report.median_interval = median_interval(samples);
    for (std::size_t i = 1; i < samples.size(); ++i) {
      const Duration interval = samples[i].t - samples[i - 1].t;
      if (interval / 5 <= report.median_interval) continue;
      ++report.gaps;
      if (interval > report.longest_gap) {
        report.longest_gap = interval;
        report.longest_gap_start = samples[i - 1].t - samples.front().t;
      }
    }
    report.suspicions = find_suspicions(samples, report.median_interval);
  }

  std::string_view text_, file_;
  ReadMode mode_;
  Lines lines_;
  TrajectoryColumns columns_;
  std::vector<std::string_view> cells_;
  HostTime time_;
  std::array<double, 3> p_{0.0, 0.0, 0.0};
  std::array<double, 4> q_{1.0, 0.0, 0.0, 0.0};
  TrajectoryFile result_;
};

}  // namespace detail

/// Parses a text that is already in memory; `file` is its name in messages.
[[nodiscard]] inline TrajectoryFile parse_trajectory(std::string_view text, std::string_view file,
                                                     ReadMode mode = ReadMode::strict) {
  return detail::TrajectoryParser(text, file, mode).parse();
}

[[nodiscard]] inline TrajectoryFile read_trajectory(const std::filesystem::path& path,
                                                    ReadMode mode = ReadMode::strict) {
  const std::string text = read_whole_file(path);
  return parse_trajectory(text, path.string(), mode);
}

}  // namespace holdfast::io
