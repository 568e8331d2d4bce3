/// From the text of a headset descriptor to HmdModel; the file functions are in hmd.hpp.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/io/json_reader.hpp>
#include <holdfast/io/lens_reader.hpp>
#include <holdfast/optics/hmd.hpp>

namespace holdfast::io {

inline constexpr std::string_view hmd_schema = "holdfast/hmd/1";

/// Formats that describe a headset.
enum class HmdFormat { unknown, holdfast, osvr, cardboard };

namespace detail {

inline FieldTangents checked(const JsonNode& node, const FieldResult& result) {
  if (!result.ok()) node.fail(std::string(describe(result.problem)), "a field of view that a flat picture can fill");
  for (const double t : {result.tangents.left, result.tangents.right, result.tangents.down, result.tangents.up}) {
    if (std::abs(t) > largest_tangent) node.fail("the field of view is impossibly wide", "edges below 89.4 degrees");
  }
  constexpr double narrowest = 1e-6;  // 0.2 arc seconds: keeps pixels per tangent within bounds
  const FieldTangents& t = result.tangents;
  if (std::abs(t.right - t.left) < narrowest || std::abs(t.up - t.down) < narrowest) {
    node.fail("the field of view is impossibly narrow", "at least 1e-6 in tangent across and up");
  }
  return t;
}

inline FieldTangents read_tangents(const JsonNode& node) {
  node.allow_only({"left", "right", "down", "up"});
  const auto edge = [&](std::string_view key) { return node.at(key).number(-largest_tangent, largest_tangent); };
  const FieldTangents t{edge("left"), edge("right"), edge("down"), edge("up")};
  return checked(node, {t, problem_of(t)});
}

inline FieldTangents read_angles(const JsonNode& node) {
  node.allow_only({"left", "right", "down", "up"});
  const auto edge = [&](std::string_view key) { return degrees(node.at(key).number(-89.0, 89.0)); };
  return checked(node, tangents_of(FieldAngles{edge("left"), edge("right"), edge("down"), edge("up")}));
}

inline FieldTangents read_fov(const JsonNode& node) {
  node.allow_only({"horizontal", "vertical"});
  return checked(node, symmetric_tangents(degrees(node.at("horizontal").number(0.01, 178.0)),
                                          degrees(node.at("vertical").number(0.01, 178.0))));
}

inline VirtualImage read_virtual_image(const JsonNode& node) {
  node.allow_only({"w_x", "w_y", "z_p", "x_cw", "y_cw"});
  return {node.at("w_x").number(1e-6, 1e6), node.at("w_y").number(1e-6, 1e6), node.at("z_p").number(-1e6, -1e-6),
          node.at("x_cw").number(-1e6, 1e6), node.at("y_cw").number(-1e6, 1e6)};
}

/// Exactly one of the four ways to give the field.
inline void read_field(const JsonNode& node, EyeModel& eye) {
  const std::optional<JsonNode> tangents = node.find("tangents");
  const std::optional<JsonNode> angles = node.find("angles_deg");
  const std::optional<JsonNode> fov = node.find("fov_deg");
  const std::optional<JsonNode> image = node.find("virtual_image_m");
  const int given = int(tangents.has_value()) + int(angles.has_value()) + int(fov.has_value()) + int(image.has_value());
  if (given != 1) {
    node.fail(given == 0 ? "no field of view" : "the field of view is given more than once",
              "exactly one of tangents, angles_deg, fov_deg, virtual_image_m");
  }
  if (tangents) eye.tangents = read_tangents(*tangents);
  if (angles) eye.tangents = read_angles(*angles);
  if (fov) eye.tangents = read_fov(*fov);
  if (image) {
    const VirtualImage virtual_image = read_virtual_image(*image);
    eye.tangents = checked(*image, tangents_of(virtual_image));
    eye.image_distance_m = -virtual_image.z_p;
  }
}

/// A pose whose quaternion survives another normalisation unchanged, so that writing and reading it again is exact.
inline Rigid settled(Quaternion q, const Vector3& p) {
  Rigid X(q, p);
  for (int i = 0; i < 8 && X.q().coeffs() != q.coeffs(); ++i) {
    q = X.q();
    X = Rigid(q, p);
  }
  return X;
}

inline Rigid read_pose(const JsonNode& node) {
  node.allow_only({"position", "rotation"});
  const std::vector<JsonNode> e = node.at("position").elements(3, 3);
  const Vector3 p_HE(e[0].number(-1.0, 1.0), e[1].number(-1.0, 1.0), e[2].number(-1.0, 1.0));
  const JsonNode rotation = node.at("rotation");
  rotation.allow_only({"x", "y", "z", "w"});
  const auto part = [&](std::string_view key) { return rotation.at(key).number(-1.001, 1.001); };
  const Quaternion q_HE(part("w"), part("x"), part("y"), part("z"));
  if (std::abs(q_HE.norm() - 1.0) > 1e-3) rotation.fail("not a unit quaternion", "x, y, z, w of length 1");
  return settled(q_HE, p_HE);
}

/// Rows of rising eye relief.
inline std::vector<LensesAtRelief> read_lenses_at_relief(const JsonNode& node) {
  std::vector<LensesAtRelief> table;
  for (const JsonNode& row : node.elements(1, 64)) {
    row.allow_only({"eye_relief_m", "lens", "lens_red", "lens_blue"});
    LensesAtRelief lenses;
    const JsonNode relief = row.at("eye_relief_m");
    lenses.eye_relief_m = relief.number(1e-6, 0.2);
    if (!table.empty() && !(lenses.eye_relief_m > table.back().eye_relief_m)) {
      relief.fail("not farther than the row before", "rows in the order of rising eye relief");
    }
    lenses.lens = read_lens(row.at("lens"));
    if (const auto lens = row.find("lens_red")) lenses.lens_red = read_lens(*lens);
    if (const auto lens = row.find("lens_blue")) lenses.lens_blue = read_lens(*lens);
    table.push_back(std::move(lenses));
  }
  return table;
}

inline EyeModel read_eye(const JsonNode& node, EyeSide side, double ipd_m) {
  node.allow_only({"resolution_px", "tangents", "angles_deg", "fov_deg", "virtual_image_m", "image_distance_m",
                   "eye_relief_m", "pose", "divergence_deg", "tilt_up_deg", "upside_down", "lens", "lens_red",
                   "lens_blue", "lenses_at_relief"});
  EyeModel eye;
  eye.side = side;
  const std::vector<JsonNode> size = node.at("resolution_px").elements(2, 2);
  eye.resolution = {size[0].integer(1, 32768), size[1].integer(1, 32768)};
  read_field(node, eye);
  if (const auto distance = node.find("image_distance_m")) {
    if (node.find("virtual_image_m")) distance->fail("given twice: virtual_image_m has z_p", "one of the two");
    eye.image_distance_m = distance->number(0.01, 1e9);
  }
  eye.eye_relief_m = number_or(node, "eye_relief_m", 0.0, 0.0, 0.2);
  if (const auto pose = node.find("pose")) {
    for (const std::string_view other : {"divergence_deg", "tilt_up_deg"}) {
      if (const auto given = node.find(other)) given->fail("given beside pose", "either pose or " + std::string(other));
    }
    eye.X_HE = read_pose(*pose);
  } else {
    const Rigid X_HE = eye_pose(side, ipd_m, degrees(number_or(node, "divergence_deg", 0.0, -120.0, 120.0)),
                                degrees(number_or(node, "tilt_up_deg", 0.0, -60.0, 60.0)));
    eye.X_HE = settled(X_HE.q(), X_HE.p());
  }
  if (const auto upside_down = node.find("upside_down")) eye.upside_down = upside_down->boolean();
  if (const auto lens = node.find("lens")) eye.lens = read_lens(*lens);
  if (const auto lens = node.find("lens_red")) eye.lens_red = read_lens(*lens);
  if (const auto lens = node.find("lens_blue")) eye.lens_blue = read_lens(*lens);
  if (const auto table = node.find("lenses_at_relief")) eye.lenses_at_relief = read_lenses_at_relief(*table);
  return eye;
}

inline DisplayTiming read_timing(const JsonNode& node) {
  node.allow_only(
      {"refresh_hz", "scan_out", "scan_duration_ms", "persistence_ms", "internal_delay_ms", "scan_direction"});
  DisplayTiming timing;
  timing.refresh_hz = node.at("refresh_hz").number(1.0, 1e5);
  if (const auto scan_out = node.find("scan_out")) {
    timing.scan_out = scan_out->choice({"global", "rolling"}) == 0 ? ScanOut::global : ScanOut::rolling;
  }
  const auto duration = [&](std::string_view key) { return from_milliseconds(number_or(node, key, 0.0, 0.0, 1000.0)); };
  timing.scan_duration = duration("scan_duration_ms");
  timing.persistence = duration("persistence_ms");
  timing.internal_delay = duration("internal_delay_ms");
  if (const auto direction = node.find("scan_direction")) {
    timing.scan_direction =
        scan_directions.at(direction->choice({"top_to_bottom", "bottom_to_top", "left_to_right", "right_to_left"}));
  }
  if (const auto problem = find_problem(timing)) {
    node.fail("the display's timing is impossible in " + std::string(problem->member), std::string(problem->expected));
  }
  return timing;
}

/// By the keys at the root.
inline HmdFormat format_of(const JsonNode& root) {
  if (!root.is_object()) return HmdFormat::unknown;
  if (const auto schema = root.find("schema")) {
    if (!schema->is_string()) return HmdFormat::unknown;
    if (schema->string().rfind("holdfast/hmd/", 0) == 0) return HmdFormat::holdfast;
    return schema->string().rfind("holdfast/cardboard/", 0) == 0 ? HmdFormat::cardboard : HmdFormat::unknown;
  }
  const std::optional<JsonNode> display = root.find("display");
  const bool osvr = root.find("hmd") || (display && display->is_object() && display->find("hmd"));
  return osvr ? HmdFormat::osvr : HmdFormat::unknown;
}

/// Says what a file is that is no descriptor of ours.
inline void check_schema(const JsonNode& root) {
  const std::string ours = "\"schema\": \"" + std::string(hmd_schema) + "\"";
  if (!root.is_object()) root.fail("the file holds no object", "a headset descriptor with " + ours);
  if (format_of(root) == HmdFormat::osvr) {
    root.fail("this is an OSVR descriptor", "a file with " + ours + "; read_hmd and parse_osvr read OSVR's");
  }
  const std::optional<JsonNode> schema = root.find("schema");
  if (!schema) {
    root.fail("this is not a headset descriptor", "a file with " + ours + ", or an OSVR descriptor with \"hmd\"");
  }
  const std::string name = schema->string();
  if (name == hmd_schema) return;
  const bool other_version = name.rfind("holdfast/hmd/", 0) == 0;
  schema->fail(other_version ? "this version of headset descriptor is not known" : "this is a file of another kind",
               "\"" + std::string(hmd_schema) + "\"");
}

}  // namespace detail

/// Reads a descriptor of ours from its root.
[[nodiscard]] inline HmdModel hmd_of(const JsonNode& root) {
  detail::check_schema(root);
  root.allow_only({"schema", "name", "source", "ipd_m", "optics_follow_ipd", "timing", "eyes"});
  HmdModel hmd;
  const JsonNode name = root.at("name");
  hmd.name = name.string();
  if (hmd.name.empty()) name.fail("the name is empty", "the headset's name");
  hmd.source = root.at("source").string();
  hmd.ipd_m = root.at("ipd_m").number(0.0, 0.2);
  if (const auto follow = root.find("optics_follow_ipd")) hmd.optics_follow_ipd = follow->boolean();
  hmd.timing = detail::read_timing(root.at("timing"));
  const JsonNode eyes = root.at("eyes");
  eyes.allow_only({"left", "right"});
  const JsonNode left = eyes.at("left");
  const JsonNode right = eyes.at("right");
  if (left.is_string() && right.is_string()) right.fail("both eyes are strings", "an object for at least one eye");
  if (left.is_string()) static_cast<void>(left.choice({"mirrored"}));
  if (right.is_string()) static_cast<void>(right.choice({"mirrored"}));
  if (!left.is_string()) hmd.left = detail::read_eye(left, EyeSide::left, hmd.ipd_m);
  hmd.right = right.is_string() ? mirrored(hmd.left) : detail::read_eye(right, EyeSide::right, hmd.ipd_m);
  if (left.is_string()) hmd.left = mirrored(hmd.right);
  return hmd;
}

/// Reads the text of a descriptor of ours; `file` is only for messages.
[[nodiscard]] inline HmdModel parse_hmd(std::string_view text, std::string file) {
  const JsonDocument document = JsonDocument::parse(text, std::move(file));
  return hmd_of(document.root());
}

}  // namespace holdfast::io
