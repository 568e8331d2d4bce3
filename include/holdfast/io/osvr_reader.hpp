/// From an OSVR display descriptor to HmdModel; the file functions are in osvr.hpp.
///
/// Each eye's canonical rectangle, w = 2 tan(monocular_horizontal / 2) wide and h = 2 tan(monocular_vertical / 2) high,
/// becomes its field of tangents: from -cx w to (1 - cx) w with cx = center_proj_x, likewise up, all lowered by
/// tan(pitch_tilt) (a shear, positive downwards). overlap_percent below 100 turns the eyes apart, each outward by
/// monocular_horizontal (1 - overlap) / 2. rotate_180 is a panel mounted upside down; the rest of the file speaks of
/// the picture as it is seen. So does OSVR-RenderManager, but that it drops pitch_tilt; we follow its comments there.
/// Refused with the reason: an overlap above 100 %, a roll (no reader of OSVR's says which way it turns), unequal
/// halves, a single eye, and what osvr_distortion.hpp refuses.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <holdfast/io/hmd_reader.hpp>
#include <holdfast/io/json_reader.hpp>
#include <holdfast/io/osvr_distortion.hpp>
#include <holdfast/io/osvr_types.hpp>
#include <holdfast/optics/hmd.hpp>

namespace holdfast::io {

namespace detail {

/// 0 and 1, or true and false.
inline bool osvr_flag(const JsonNode& object, std::string_view key) {
  const std::optional<JsonNode> node = object.find(key);
  if (!node) return false;
  return node->is_boolean() ? node->boolean() : node->integer(0, 1) == 1;
}

struct OsvrField {
  Angle horizontal;
  Angle vertical;
  Angle pitch_tilt;  ///< positive: the picture lies lower
  double overlap = 1.0;
};

inline OsvrField read_osvr_field(const JsonNode& node) {
  node.allow_only({"monocular_horizontal", "monocular_vertical", "overlap_percent", "pitch_tilt"});
  OsvrField field;
  field.horizontal = degrees(node.at("monocular_horizontal").number(0.01, 178.0));
  field.vertical = degrees(node.at("monocular_vertical").number(0.01, 178.0));
  field.pitch_tilt = degrees(number_or(node, "pitch_tilt", 0.0, -60.0, 60.0));
  field.overlap = number_or(node, "overlap_percent", 100.0, 0.0, 100.0) / 100.0;
  return field;
}

inline PixelSize read_osvr_resolution(const JsonNode& list, OsvrHmd& out) {
  const JsonNode node = list.elements(1, 32).front();
  node.allow_only({"width", "height", "video_inputs", "display_mode", "swap_eyes"});
  PixelSize size{node.at("width").integer(2, 65536), node.at("height").integer(2, 65536)};
  const auto inputs = node.find("video_inputs");
  out.display_mode =
      inputs && inputs->integer(1, 2) == 2 ? OsvrDisplayMode::full_screen : OsvrDisplayMode::side_by_side;
  if (const auto mode = node.find("display_mode")) {
    out.display_mode =
        static_cast<OsvrDisplayMode>(mode->choice({"horz_side_by_side", "vert_side_by_side", "full_screen"}));
  }
  out.swap_eyes = osvr_flag(node, "swap_eyes");
  const auto halve = [&](int& length, std::string_view key) {
    if (length % 2 != 0) node.at(key).fail("the eyes do not share it equally", "an even number of pixels");
    length /= 2;
  };
  if (out.display_mode == OsvrDisplayMode::side_by_side) halve(size.width, "width");
  if (out.display_mode == OsvrDisplayMode::one_above_the_other) halve(size.height, "height");
  if (size.width > 32768 || size.height > 32768)
    node.fail("too large", "at most 32768 pixels across and up for an eye");
  return size;
}

inline void read_osvr_rendering(const JsonNode& node) {
  node.allow_only({"left_roll", "right_roll"});
  for (const std::string_view key : {"left_roll", "right_roll"}) {
    const auto roll = node.find(key);
    if (roll && roll->number(-360.0, 360.0) != 0.0) {
      roll->fail("a rolled eye cannot be read: OSVR says neither unit nor direction, and none of its readers uses it",
                 "0");
    }
  }
}

/// The eye without resolution.
inline EyeModel read_osvr_eye(const JsonNode& hmd, const JsonNode& node, EyeSide side, const OsvrField& field,
                              double ipd_m, const BesideReader& beside, std::vector<std::string>& notes) {
  node.allow_only({"center_proj_x", "center_proj_y", "rotate_180", "distortion"});
  OsvrScreen screen;
  screen.eye = side == EyeSide::left ? 0 : 1;
  screen.centre_of_projection = {number_or(node, "center_proj_x", 0.5, -2.0, 3.0),
                                 number_or(node, "center_proj_y", 0.5, -2.0, 3.0)};
  screen.centre = {0.0, 0.0 - tan(field.pitch_tilt)};  // not -0 for no tilt
  screen.size = {2.0 * tan(field.horizontal / 2.0), 2.0 * tan(field.vertical / 2.0)};
  const Vector2 low = screen.centre - screen.centre_of_projection.cwiseProduct(screen.size);
  const Vector2 high = low + screen.size;
  EyeModel eye;
  eye.side = side;
  eye.tangents = {low.x(), high.x(), low.y(), high.y()};
  static_cast<void>(checked(node, {eye.tangents, problem_of(eye.tangents)}));
  eye.upside_down = osvr_flag(node, "rotate_180");
  const Rigid X_HE = eye_pose(side, ipd_m, field.horizontal * (1.0 - field.overlap));
  eye.X_HE = settled(X_HE.q(), X_HE.p());
  const std::optional<JsonNode> own = node.find("distortion");
  const std::optional<JsonNode> shared = hmd.find("distortion");
  if (!own && !shared) {
    notes.push_back("no distortion is described: the lens is taken as free of it");
    return eye;
  }
  OsvrLenses lenses = read_osvr_distortion(own ? *own : *shared, screen, beside, notes);
  eye.lens = std::move(lenses.green);
  eye.lens_red = std::move(lenses.red);
  eye.lens_blue = std::move(lenses.blue);
  return eye;
}

inline std::string osvr_name(const JsonNode& hmd) {
  const std::optional<JsonNode> device = hmd.find("device");
  if (!device) return "OSVR display";
  const std::optional<JsonNode> legacy = device->find("properties");
  std::string name;
  for (const std::string_view key : {"vendor", "model", "Version"}) {
    const auto part = (legacy ? *legacy : *device).find(key);
    if (part && part->is_string() && !part->string().empty()) name += (name.empty() ? "" : " ") + part->string();
  }
  return name.empty() ? "OSVR display" : name;
}

inline std::string osvr_source(const std::string& file, const OsvrHmd& out) {
  std::string text = "OSVR display descriptor " + std::filesystem::path(file).filename().string();
  for (const std::string& note : out.notes) text += "; " + note;
  return text;
}

}  // namespace detail

[[nodiscard]] inline OsvrHmd osvr_of(const JsonNode& root, const std::string& file, const BesideReader& beside,
                                     const OsvrAssumptions& assumed = {}) {
  const std::optional<JsonNode> display = root.find("display");
  const JsonNode hmd = (display ? *display : root).at("hmd");
  hmd.allow_only({"device", "field_of_view", "resolutions", "distortion", "rendering", "eyes"});
  OsvrHmd out;
  out.hmd.name = detail::osvr_name(hmd);
  out.hmd.ipd_m = assumed.ipd_m;
  out.hmd.timing.refresh_hz = assumed.refresh_hz;
  out.notes.push_back("IPD " + detail::brief(assumed.ipd_m * 1000.0) + " mm and " + detail::brief(assumed.refresh_hz) +
                      " Hz are assumed: OSVR descriptors do not give them");
  const detail::OsvrField field = detail::read_osvr_field(hmd.at("field_of_view"));
  if (const auto rendering = hmd.find("rendering")) detail::read_osvr_rendering(*rendering);
  PixelSize size = assumed.eye_resolution;
  if (const auto resolutions = hmd.find("resolutions")) {
    size = detail::read_osvr_resolution(*resolutions, out);
  } else {
    out.notes.push_back("a mesh without resolutions: " + std::to_string(size.width) + " x " +
                        std::to_string(size.height) + " pixels an eye are assumed");
  }
  if (out.swap_eyes) out.notes.push_back("the display wants the eyes' pictures to change places");
  const std::vector<JsonNode> eyes = hmd.at("eyes").elements(2, 2);
  for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
    std::vector<std::string> notes;
    const JsonNode& node = eyes[side == EyeSide::left ? 0 : 1];
    EyeModel& eye = out.hmd.eye(side);
    eye = detail::read_osvr_eye(hmd, node, side, field, assumed.ipd_m, beside, notes);
    eye.resolution = size;
    if (side == EyeSide::left) out.notes.insert(out.notes.end(), notes.begin(), notes.end());
  }
  out.hmd.source = detail::osvr_source(file, out);
  return out;
}

}  // namespace holdfast::io
