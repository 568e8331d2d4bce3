/// What a trajectory reader found in a file: counts, gaps, rate, and what looks wrong, in numbers and in words.
///
/// Nothing that a reader skips, repairs or doubts is silent: it is counted here, and describe() says it in plain
/// English.
#pragma once

#include <array>
#include <cstddef>
#include <locale>
#include <ostream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <holdfast/timing/clock.hpp>

namespace holdfast::io {

enum class ReadMode {
  strict,  ///< the first bad row is an InputError
  lenient  ///< bad rows are dropped and counted by cause
};

enum class TrajectoryFormat {
  tum,       ///< t tx ty tz qx qy qz qw, seconds
  euroc,     ///< t,px,py,pz,qw,qx,qy,qz[,...], whole nanoseconds
  named_csv  ///< a header line names the columns
};

[[nodiscard]] constexpr std::string_view to_string(TrajectoryFormat format) {
  switch (format) {
    case TrajectoryFormat::tum:
      return "TUM";
    case TrajectoryFormat::euroc:
      return "EuRoC";
    case TrajectoryFormat::named_csv:
      return "header-named CSV";
  }
  return "unknown";
}

/// Why a row cannot be used.
enum class RowFault { malformed, non_finite, bad_quaternion, duplicate, backward };
inline constexpr std::array<std::string_view, 5> row_fault_names{"malformed", "non-finite", "bad quaternion",
                                                                 "duplicate time", "backward time"};

struct TrajectoryReport {
  TrajectoryFormat format = TrajectoryFormat::tum;
  bool has_position = true;     ///< false: the file names no position, all positions are zero
  bool has_orientation = true;  ///< false: the file names no orientation, all are the identity

  std::size_t rows = 0;                                       ///< data rows, without comments, header and empty lines
  std::size_t poses = 0;                                      ///< rows that became samples
  std::array<std::size_t, row_fault_names.size()> dropped{};  ///< by RowFault; all zero in strict mode
  std::size_t occlusions = 0;            ///< rows whose position or orientation is all NaN (header-named CSV)
  std::size_t non_unit_quaternions = 0;  ///< length off by more than 1e-3; normalised

  Duration duration{0};
  Duration median_interval{0};
  std::size_t gaps = 0;  ///< intervals longer than 5 medians
  Duration longest_gap{0};
  Duration longest_gap_start{0};  ///< after the first sample

  std::vector<std::string> suspicions;  ///< likely unit or order mistakes, each a sentence

  [[nodiscard]] std::size_t dropped_rows() const {
    std::size_t sum = 0;
    for (const std::size_t count : dropped) sum += count;
    return sum;
  }
  [[nodiscard]] double rate_hz() const {
    return median_interval > Duration(0) ? 1.0 / to_seconds(median_interval) : 0.0;
  }
};

/// The report for people: one line of facts, then one line for each thing worth knowing.
[[nodiscard]] inline std::string describe(const TrajectoryReport& report) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.setf(std::ios::fixed);
  text.precision(1);
  text << to_string(report.format) << ": " << report.poses << " poses of " << report.rows << " rows, "
       << to_seconds(report.duration) << " s at " << report.rate_hz() << " Hz\n";
  for (std::size_t i = 0; i < report.dropped.size(); ++i) {
    if (report.dropped[i] > 0) text << "  dropped " << report.dropped[i] << " rows: " << row_fault_names[i] << '\n';
  }
  if (report.occlusions > 0)
    text << "  skipped " << report.occlusions << " rows in which the body was not seen (NaN)\n";
  if (report.non_unit_quaternions > 0) {
    text << "  normalised " << report.non_unit_quaternions
         << " quaternions that were off unit length by more than 0.001\n";
  }
  if (!report.has_position) text << "  no position columns: all positions are zero\n";
  if (!report.has_orientation) text << "  no orientation columns: all orientations are the identity\n";
  text.precision(3);
  if (report.gaps > 0) {
    text << "  " << report.gaps << " gaps longer than 5 usual intervals; the longest is "
         << to_seconds(report.longest_gap) << " s, " << to_seconds(report.longest_gap_start) << " s after the start\n";
  }
  for (const std::string& suspicion : report.suspicions) text << "  suspicious: " << suspicion << '\n';
  return text.str();
}

inline std::ostream& operator<<(std::ostream& out, const TrajectoryReport& report) {
  return out << describe(report);
}

}  // namespace holdfast::io
