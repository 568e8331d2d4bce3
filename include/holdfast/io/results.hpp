/// Results as JSON and CSV: the contracts "holdfast/run/1" and "holdfast/latency/1" that other programs read.
///
/// Source: design.md, "The command". Units are in the key names. Every number is finite; what is undefined is null (in
/// CSV an empty cell). Keys beyond the contract, told in docs/swimlab.md: of a row `deflection`, `per_scanline`,
/// `ablation`, `late_ms`, `coverage_missing_peak_pct`, `disocclusion_peak_pct`, `pose`, `scan_skew_arcmin`,
/// `overshoot_pct`, `effective_latency_uncertainty_ms`, `registration.p50_px`, `.p99_px`, `swim.rms_px_s`,
/// `.peak_px_s`.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <holdfast/io/result_json.hpp>
#include <holdfast/registration/experiment_types.hpp>
#include <holdfast/registration/latency_types.hpp>

namespace holdfast::io {

namespace detail {

/// Members of a summary that may be absent: each key with its number, or with null.
template <typename Summary>
[[nodiscard]] ResultJson members(const std::optional<Summary>& summary,
                                 std::initializer_list<std::pair<std::string_view, double Summary::*>> keys) {
  ResultJson json = ResultJson::object();
  for (const auto& [key, member] : keys) {
    json[std::string(key)] = summary ? number_or_null((*summary).*member) : ResultJson(nullptr);
  }
  return json;
}

[[nodiscard]] inline ResultJson expected_json(const std::vector<ExpectedValue>& values) {
  if (values.empty()) return nullptr;
  ResultJson json = ResultJson::object();
  for (const ExpectedValue& value : values) {
    json[value.name] = {{"expected", number_or_null(value.expected)},
                        {"tolerance", number_or_null(value.tolerance)},
                        {"measured", number_or_null(value.measured)}};
  }
  return json;
}

[[nodiscard]] inline ResultJson statistics_json(const ErrorStatistics& s) {
  return {{"rms", number_or_null(s.rms)},
          {"mean", number_or_null(s.mean)},
          {"p95", number_or_null(s.p95)},
          {"peak", number_or_null(s.peak)}};
}

[[nodiscard]] inline ResultJson pose_json(const Rigid& X) {
  return {{"position_m", {X.p().x(), X.p().y(), X.p().z()}},
          {"quaternion_xyzw", {X.q().x(), X.q().y(), X.q().z(), X.q().w()}}};
}

/// Every number and word of a row as a flat list of columns: nested keys are joined by a dot.
inline void flatten(const ResultJson& json, const std::string& prefix,
                    std::vector<std::pair<std::string, ResultJson>>& columns) {
  for (const auto& [key, value] : json.items()) {
    if (key == "expected") continue;  // different in every row
    if (value.is_object()) {
      flatten(value, prefix + key + ".", columns);
    } else {
      columns.emplace_back(prefix + key, value);
    }
  }
}

[[nodiscard]] inline std::string csv_cell(const ResultJson& value) {
  if (value.is_null()) return {};
  if (!value.is_string()) return value.dump();
  const std::string text = value.get<std::string>();
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace detail

/// One row of "holdfast/run/1".
[[nodiscard]] inline ResultJson row_json(const ExperimentRow& row) {
  using R = RegistrationSummary;
  using S = SwimSummary;
  ResultJson json;
  json["motion"] = row.motion;
  json["pipeline"] = name_of(row.pipeline);
  json["eye"] = name_of(row.eye);
  json["lens"] = name_of(row.lens);
  json["latency_ms"] = number_or_null(row.latency_ms);
  json["display"] = name_of(row.display);
  json["deflection"] = name_of(row.deflection);
  json["per_scanline"] = row.per_scanline;
  json["interval_error_ms"] = number_or_null(row.interval_error_ms);
  json["ablation"] = is_ablation(row);
  json["late_ms"] = number_or_null(row.late_ms);
  json["frames"] = row.frames;
  json["registration"] = detail::members<R>(row.registration, {{"rms_px", &R::rms_px},
                                                               {"mean_px", &R::mean_px},
                                                               {"p50_px", &R::p50_px},
                                                               {"p95_px", &R::p95_px},
                                                               {"p99_px", &R::p99_px},
                                                               {"peak_px", &R::peak_px},
                                                               {"rms_arcmin", &R::rms_arcmin},
                                                               {"peak_arcmin", &R::peak_arcmin},
                                                               {"rms_mm", &R::rms_mm}});
  json["swim"] = detail::members<S>(row.swim, {{"rms_deg_s", &S::rms_deg_s},
                                               {"peak_deg_s", &S::peak_deg_s},
                                               {"rms_px_s", &S::rms_px_s},
                                               {"peak_px_s", &S::peak_px_s}});
  json["effective_latency_ms"] = number_or_null(row.effective_latency_ms);
  json["effective_latency_uncertainty_ms"] = number_or_null(row.effective_latency_uncertainty_ms);
  json["jitter_arcmin"] = number_or_null(row.jitter_arcmin);
  json["overshoot_arcmin"] = number_or_null(row.overshoot_arcmin);
  json["overshoot_pct"] = number_or_null(row.overshoot_pct);
  json["coverage_missing_pct"] = number_or_null(row.coverage_missing_pct);
  json["coverage_missing_peak_pct"] = number_or_null(row.coverage_missing_peak_pct);
  json["disocclusion_pct"] = number_or_null(row.disocclusion_pct);
  json["disocclusion_peak_pct"] = number_or_null(row.disocclusion_peak_pct);
  json["picture_vs_theory_px"] = number_or_null(row.picture_vs_theory_px);
  json["scan_skew_arcmin"] = number_or_null(row.scan_skew_arcmin);
  json["pose"] = {{"peak_yaw_arcmin", number_or_null(row.pose.peak_yaw_arcmin)},
                  {"peak_orientation_arcmin", number_or_null(row.pose.peak_orientation_arcmin)},
                  {"rms_orientation_arcmin", number_or_null(row.pose.rms_orientation_arcmin)},
                  {"peak_position_mm", number_or_null(row.pose.peak_position_mm)},
                  {"peak_swim_deg_s", number_or_null(row.pose.peak_swim_deg_s)}};
  json["expected"] = detail::expected_json(row.expected);
  json["verdict"] = name_of(row.verdict);
  return json;
}

/// The rows as CSV with a header; columns are the JSON's keys, without `expected`.
[[nodiscard]] inline std::string rows_csv(std::span<const ExperimentRow> rows) {
  std::string text;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::vector<std::pair<std::string, ResultJson>> columns;
    detail::flatten(row_json(rows[i]), "", columns);
    std::string header, line;
    for (const auto& [name, value] : columns) {
      if (!header.empty()) {
        header += ',';
        line += ',';
      }
      header += name;
      line += detail::csv_cell(value);
    }
    if (i == 0) text = header + '\n';
    text += line + '\n';
  }
  return text;
}

/// "holdfast/latency/1". Without an estimate all numbers are null, and `status` says why.
[[nodiscard]] inline ResultJson latency_json(const LatencyResult& result, FrameRelation frames) {
  const bool known = result.has_latency();
  const bool aligned = frames == FrameRelation::rigid && result.status == LatencyStatus::ok;
  const auto value = [known](double x) { return known ? number_or_null(x) : ResultJson(nullptr); };
  const auto statistics = [known](const ErrorStatistics& s) {
    ResultJson json = detail::statistics_json(s);
    if (!known) {
      for (auto& [key, number] : json.items()) number = nullptr;
    }
    return json;
  };
  ResultJson json;
  json["schema"] = "holdfast/latency/1";
  json["effective_latency_ms"] = value(result.effective_latency_ms);
  json["uncertainty_ms"] = value(result.uncertainty_ms);
  json["angle_deg"] = statistics(result.angle_deg);
  json["position_mm"] = statistics(result.position_mm);
  json["status"] = describe(result.status);
  json["frames_aligned"] = aligned;
  json["without_shift"] = {{"angle_deg_rms", value(result.unshifted_angle_deg_rms)},
                           {"position_mm_rms", value(result.unshifted_position_mm_rms)}};
  json["alignment"] =
      aligned ? ResultJson{{"X_RO", detail::pose_json(result.X_RO)}, {"X_BoBr", detail::pose_json(result.X_BoBr)}}
              : ResultJson(nullptr);
  json["pairs"] = result.pairs;
  json["overlap_s"] = value(result.overlap_s);
  return json;
}

}  // namespace holdfast::io
