/// Rows of tracking by ranges as JSON, as the contract "holdfast/track/1" has them (track_results.hpp).
///
/// Source: design.md, "The command". Units are in the key names; what is undefined is null. `updates` and `accepted` are
/// ranges that corrected the filter. Keys beyond the contract: `horizontal_mm`, `height_mm`, `ranges`, `refused`, `nis` and
/// `position_nees` per degree of freedom, and `biases` with the anchors' ids (range_types.hpp).
#pragma once

#include <span>
#include <string>

#include <holdfast/io/track_results.hpp>
#include <holdfast/registration/range_recording.hpp>
#include <holdfast/registration/range_types.hpp>

namespace holdfast::io {

[[nodiscard]] inline ResultJson range_row_json(const RangeRow& row, std::span<const RangeAnchor> anchors) {
  const auto length = [](const auto& error) { return detail::rms_and_peak_json(error.rms(), error.peak(), 1e3); };
  ResultJson json;
  json["method"] = name_of(row.variant);
  json["three_point_mm"] = length(row.three_point);
  json["position_mm"] = length(row.position);
  json["angle_deg"] = detail::rms_and_peak_json(row.angle.rms(), row.angle.peak(), degrees_per_rad);
  json["updates"] = row.accepted;
  json["accepted"] = row.accepted;
  json["gated"] = row.gated;
  json["microseconds_per_update"] = number_or_null(row.microseconds_per_range);
  json["beacon_error_mm"] = nullptr;
  json["horizontal_mm"] = length(row.horizontal);
  json["height_mm"] = length(row.height);
  json["ranges"] = row.ranges;
  json["refused"] = row.refused;
  json["nis"] = number_or_null(row.nis);
  json["position_nees"] = number_or_null(row.position_nees);
  json["biases"] = ResultJson::array();
  for (std::size_t k = 0; k < row.biases_m.size(); ++k) {
    json["biases"].push_back({{"anchor", anchors[k].id}, {"bias_m", number_or_null(row.biases_m[k])}});
  }
  return json;
}

}  // namespace holdfast::io
