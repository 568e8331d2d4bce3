/// Reads a recording of ranges: four texts with named columns (named_columns.hpp).
///
///   anchors   id, x, y, z                  where they were surveyed, m
///   ranges    t, anchor, range             one distance at a time, m; anchor is an id of the anchors' file
///   inertial  t, gx, gy, gz, ax, ay, az    rad/s and m/s^2, in the body's axes (inertial_files.hpp)
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

#include <holdfast/io/inertial_files.hpp>
#include <holdfast/io/named_columns.hpp>
#include <holdfast/io/trajectory.hpp>
#include <holdfast/io/whole_file.hpp>
#include <holdfast/registration/range_recording.hpp>

namespace holdfast::io {

namespace detail {

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

struct RangeFiles {
  std::filesystem::path ranges, anchors, inertial, truth;
};

[[nodiscard]] inline RangeRecording read_range_recording(const RangeFiles& files) {
  RangeRecording recording;
  recording.anchors = parse_anchors(read_whole_file(files.anchors), files.anchors.string());
  recording.ranges = parse_ranges(read_whole_file(files.ranges), files.ranges.string(), recording.anchors);
  recording.inertial = read_inertial(files.inertial);
  recording.truth = read_trajectory(files.truth).samples;
  return recording;
}

}  // namespace holdfast::io
