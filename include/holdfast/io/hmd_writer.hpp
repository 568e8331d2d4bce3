/// From HmdModel to the text of a headset descriptor; the file functions are in hmd.hpp.
#pragma once

#include <cmath>
#include <string>

#include <nlohmann/json.hpp>

#include <holdfast/io/hmd_reader.hpp>
#include <holdfast/io/lens_writer.hpp>
#include <holdfast/optics/hmd.hpp>

namespace holdfast::io {

namespace detail {

inline OrderedJson eye_json(const EyeModel& eye) {
  const FieldTangents& t = eye.tangents;
  const Vector3& p = eye.X_HE.p();
  const Quaternion& q = eye.X_HE.q();
  OrderedJson json;
  json["resolution_px"] = {eye.resolution.width, eye.resolution.height};
  json["tangents"] = {{"left", t.left}, {"right", t.right}, {"down", t.down}, {"up", t.up}};
  if (!std::isinf(eye.image_distance_m)) json["image_distance_m"] = eye.image_distance_m;
  json["eye_relief_m"] = eye.eye_relief_m;
  json["pose"] = {{"position", {p.x(), p.y(), p.z()}},
                  {"rotation", {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}}}};
  json["upside_down"] = eye.upside_down;
  json["lens"] = lens_json(eye.lens);
  if (eye.lens_red) json["lens_red"] = lens_json(*eye.lens_red);
  if (eye.lens_blue) json["lens_blue"] = lens_json(*eye.lens_blue);
  for (const LensesAtRelief& row : eye.lenses_at_relief) {
    OrderedJson lenses{{"eye_relief_m", row.eye_relief_m}, {"lens", lens_json(row.lens)}};
    if (row.lens_red) lenses["lens_red"] = lens_json(*row.lens_red);
    if (row.lens_blue) lenses["lens_blue"] = lens_json(*row.lens_blue);
    json["lenses_at_relief"].push_back(std::move(lenses));
  }
  return json;
}

inline OrderedJson timing_json(const DisplayTiming& timing) {
  return {{"refresh_hz", timing.refresh_hz},
          {"scan_out", timing.scan_out == ScanOut::global ? "global" : "rolling"},
          {"scan_duration_ms", to_milliseconds(timing.scan_duration)},
          {"persistence_ms", to_milliseconds(timing.persistence)},
          {"internal_delay_ms", to_milliseconds(timing.internal_delay)},
          {"scan_direction", name_of(timing.scan_direction)}};
}

}  // namespace detail

/// The descriptor's text. Every double is written with the digits that give back the same bits. The display's phase
/// (timing.first_vsync) belongs to a running system, not to the headset: it is not written.
[[nodiscard]] inline std::string hmd_json(const HmdModel& hmd) {
  detail::OrderedJson json;
  json["schema"] = hmd_schema;
  json["name"] = hmd.name;
  json["source"] = hmd.source;
  json["ipd_m"] = hmd.ipd_m;
  json["optics_follow_ipd"] = hmd.optics_follow_ipd;
  json["timing"] = detail::timing_json(hmd.timing);
  json["eyes"] = {{"left", detail::eye_json(hmd.left)}, {"right", detail::eye_json(hmd.right)}};
  return detail::pretty(json);
}

}  // namespace holdfast::io
