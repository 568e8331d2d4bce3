/// Rows of tracking experiments as JSON: the contract "holdfast/track/1" that other programs read.
///
/// Source: design.md, "The command". Units are in the key names; what is undefined is null. Keys beyond the contract:
/// `sightings`; `beacon_error_mm` holds `beacons`, how many were seen at all, and is of those; `beacon_error_seen_20_mm` the
/// same of beacons seen 20 times or more; `nees` and `nis`, per degree of freedom (track_types.hpp).
#pragma once

#include <string>

#include <holdfast/io/result_json.hpp>
#include <holdfast/registration/metrics.hpp>
#include <holdfast/registration/track_types.hpp>

namespace holdfast::io {

namespace detail {

[[nodiscard]] inline ResultJson rms_and_peak_json(double rms, double peak, double scale) {
  return {{"rms", number_or_null(scale * rms)}, {"peak", number_or_null(scale * peak)}};
}

[[nodiscard]] inline ResultJson beacons_json(const BeaconErrors::Group& group) {
  return {{"before", number_or_null(1e3 * group.before)},
          {"after", number_or_null(1e3 * group.after)},
          {"beacons", group.beacons}};
}

}  // namespace detail

[[nodiscard]] inline ResultJson track_row_json(const TrackRow& row) {
  ResultJson json;
  json["method"] = name_of(row.method);
  json["three_point_mm"] = detail::rms_and_peak_json(row.three_point.rms(), row.three_point.peak(), 1e3);
  json["position_mm"] = detail::rms_and_peak_json(row.position.rms(), row.position.peak(), 1e3);
  json["angle_deg"] = detail::rms_and_peak_json(row.angle.rms(), row.angle.peak(), degrees_per_rad);
  json["updates"] = row.updates;
  json["accepted"] = row.accepted;
  json["gated"] = row.gated;
  json["microseconds_per_update"] = number_or_null(row.microseconds_per_update);
  json["beacon_error_mm"] = row.beacons ? detail::beacons_json(row.beacons->seen) : ResultJson(nullptr);
  json["beacon_error_seen_20_mm"] = row.beacons ? detail::beacons_json(row.beacons->seen_often) : ResultJson(nullptr);
  json["sightings"] = row.sightings;
  json["nees"] = number_or_null(row.nees);
  json["nis"] = number_or_null(row.nis);
  return json;
}

}  // namespace holdfast::io
