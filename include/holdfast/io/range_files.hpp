/// Reads a recording of ranges: four texts with named columns (named_columns.hpp).
///
///   anchors   id, x, y, z                  where they were surveyed, m
///   ranges    t, anchor, range             one distance at a time, m; anchor is an id of the anchors' file
///   inertial  t, gx, gy, gz, ax, ay, az    rad/s and m/s^2, in the body's axes
///   truth     a trajectory, as trajectory.hpp reads it
/// as, for instance, t_s,anchor_id,range_m. Times are of one clock and do not decrease.
/// Bad input: an InputError that names file, line, column, what was found and what was expected. Ranges must be positive,
/// ids must not repeat, and there must be rows.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <holdfast/io/named_columns.hpp>
#include <holdfast/io/trajectory.hpp>
#include <holdfast/io/whole_file.hpp>
#include <holdfast/registration/range_recording.hpp>

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

[[nodiscard]] inline std::string ids_of(const std::vector<RangeAnchor>& anchors) {
  std::string ids;
  for (const RangeAnchor& anchor : anchors) ids += (ids.empty() ? "" : ", ") + std::to_string(anchor.id);
  return ids;
}

}  // namespace detail

[[nodiscard]] inline std::vector<RangeAnchor> parse_anchors(std::string_view text, const std::string& file) {
  detail::NamedColumns rows(text, file, "id,x_m,y_m,z_m");
  const detail::NamedColumn id = rows.column({"id", "anchor"}), x = rows.column({"x"}), y = rows.column({"y"}),
                            z = rows.column({"z"});
  std::vector<RangeAnchor> anchors;
  while (rows.next()) {
    const int number = rows.integer(id);
    for (const RangeAnchor& anchor : anchors) {
      if (anchor.id == number) rows.refuse(id, "stands twice in the file", "another id");
    }
    anchors.push_back({number, Vector3(rows.length(x), rows.length(y), rows.length(z))});
  }
  if (anchors.empty()) rows.refuse_end();
  return anchors;
}

[[nodiscard]] inline std::vector<RangeReading> parse_ranges(std::string_view text, const std::string& file,
                                                            const std::vector<RangeAnchor>& anchors) {
  detail::NamedColumns rows(text, file, "t_s,anchor_id,range_m");
  const detail::NamedColumn t = detail::time_column(rows), anchor = rows.column({"anchor", "id"}),
                            range = rows.column({"range", "distance"});
  std::vector<RangeReading> readings;
  HostTime newest = HostTime::min();
  while (rows.next()) {
    RangeReading reading;
    reading.t = detail::time_in_order(rows, t, newest);
    const int id = rows.integer(anchor);
    while (reading.anchor < anchors.size() && anchors[reading.anchor].id != id) ++reading.anchor;
    if (reading.anchor == anchors.size()) {
      rows.refuse(anchor, "is no anchor of the anchors' file", "one of " + detail::ids_of(anchors));
    }
    reading.range_m = rows.length(range);
    if (!(reading.range_m > 0.0)) rows.refuse(range, "is no distance", "a number above 0");
    readings.push_back(reading);
  }
  if (readings.empty()) rows.refuse_end();
  return readings;
}

[[nodiscard]] inline std::vector<InertialReading> parse_inertial(std::string_view text, const std::string& file) {
  detail::NamedColumns rows(text, file, "t_s,gx_rad_s,gy_rad_s,gz_rad_s,ax_m_s2,ay_m_s2,az_m_s2");
  const detail::NamedColumn t = detail::time_column(rows);
  const std::array rate{rows.column({"gx"}), rows.column({"gy"}), rows.column({"gz"})};
  const std::array force{rows.column({"ax"}), rows.column({"ay"}), rows.column({"az"})};
  for (const detail::NamedColumn& column : rate) {
    for (const std::string& word : column.parts.words) {
      if (word == "deg" || word == "dps") rows.refuse_header(column.name, "is in degrees");
    }
  }
  for (const detail::NamedColumn& column : force) {
    for (const std::string& word : column.parts.words) {
      if (word == "g" || word == "mg") rows.refuse_header(column.name, "is in units of gravity");
    }
  }
  std::vector<InertialReading> readings;
  HostTime newest = HostTime::min();
  while (rows.next()) {
    readings.push_back({detail::time_in_order(rows, t, newest),
                        Vector3(rows.number(rate[0]), rows.number(rate[1]), rows.number(rate[2])),
                        Vector3(rows.number(force[0]), rows.number(force[1]), rows.number(force[2]))});
  }
  if (readings.empty()) rows.refuse_end();
  return readings;
}

struct RangeFiles {
  std::filesystem::path ranges, anchors, inertial, truth;
};

[[nodiscard]] inline RangeRecording read_range_recording(const RangeFiles& files) {
  RangeRecording recording;
  recording.anchors = parse_anchors(read_whole_file(files.anchors), files.anchors.string());
  recording.ranges = parse_ranges(read_whole_file(files.ranges), files.ranges.string(), recording.anchors);
  recording.inertial = parse_inertial(read_whole_file(files.inertial), files.inertial.string());
  recording.truth = read_trajectory(files.truth).samples;
  return recording;
}

}  // namespace holdfast::io
