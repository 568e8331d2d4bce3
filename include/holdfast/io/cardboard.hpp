/// Cardboard viewers: the address in a viewer's QR code, the protocol buffer in it, or our JSON of the same fields.
///
///     https://google.com/cardboard/cfg?p=CgxHb29nbGUsIEluYy4SDENhcmRib2FyZCB2MR0x...      base64url of the buffer
///     {"schema": "holdfast/cardboard/1", "screen_to_lens_distance": 0.042, ...}           the buffer's field names
///
/// All three hold the same viewer bit by bit; read_cardboard tells them apart by their content. A viewer becomes a
/// headset only with a phone's screen: cardboard_hmd (cardboard_viewer.hpp). Bad input: io::InputError with the field
/// (and the line, in JSON), its value and what was expected. Unknown fields of the buffer are skipped, as buffers want.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/io/base64url.hpp>
#include <holdfast/io/cardboard_viewer.hpp>
#include <holdfast/io/input_error.hpp>
#include <holdfast/io/json_reader.hpp>
#include <holdfast/io/lens_writer.hpp>
#include <holdfast/io/protobuf_wire.hpp>
#include <holdfast/io/whole_file.hpp>

namespace holdfast::io {

inline constexpr std::string_view cardboard_schema = "holdfast/cardboard/1";

namespace detail {

[[noreturn]] inline void cardboard_fail(const std::string& file, const CardboardProblem& problem) {
  throw InputError({.file = file,
                    .key = std::string(problem.field),
                    .problem = "missing or impossible",
                    .expected = std::string(problem.expected)});
}

[[nodiscard]] inline const CardboardViewer& checked(const CardboardViewer& viewer, const std::string& file) {
  if (const auto problem = problem_of(viewer)) cardboard_fail(file, *problem);
  return viewer;
}

/// A 32-bit number by the shortest decimal that means it.
[[nodiscard]] inline double decimal(float value) {
  for (int digits = 6; digits < 9; ++digits) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*g", digits, double(value));
    const double shorter = std::strtod(text, nullptr);
    if (static_cast<float>(shorter) == value) return shorter;
  }
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", double(value));
  return std::strtod(text, nullptr);
}

inline constexpr std::array<std::string_view, 3> alignment_names{"BOTTOM", "CENTER", "TOP"};
inline constexpr std::array<std::string_view, 4> button_names{"NONE", "MAGNET", "TOUCH", "INDIRECT_TOUCH"};

inline void set_fov(CardboardViewer& viewer, const std::vector<float>& fov, const std::string& file) {
  if (fov.size() != 4) {
    throw InputError({.file = file,
                      .key = "left_eye_field_of_view_angles",
                      .problem = "wrong number of angles",
                      .value = std::to_string(fov.size()),
                      .expected = "4: outer, inner, bottom, top"});
  }
  std::copy(fov.begin(), fov.end(), viewer.fov_deg.begin());
}

}  // namespace detail

/// From the bytes of a DeviceParams buffer; `file` is only for messages.
[[nodiscard]] inline CardboardViewer parse_cardboard_buffer(std::string_view bytes, const std::string& file) {
  CardboardViewer viewer;
  std::vector<float> fov;
  constexpr std::size_t most_numbers = 64;
  const auto append_to = [&](std::vector<float>& list) {
    return [&list](float x) {
      if (list.size() < most_numbers) list.push_back(x);
    };
  };
  std::uint64_t alignment = 0, button = 1;
  WireReader fields(bytes);
  while (fields.next()) {
    switch (fields.number()) {
      case 1:
        viewer.vendor = fields.bytes();
        break;
      case 2:
        viewer.model = fields.bytes();
        break;
      case 3:
        viewer.screen_to_lens_m = fields.float32();
        break;
      case 4:
        viewer.inter_lens_m = fields.float32();
        break;
      case 5:
        fields.floats(append_to(fov));
        break;
      case 6:
        viewer.tray_to_lens_m = fields.float32();
        break;
      case 7:
        fields.floats(append_to(viewer.distortion));
        break;
      case 10:
        viewer.has_magnet = fields.integer() != 0;
        break;
      case 11:
        alignment = fields.integer();
        break;
      case 12:
        button = fields.integer();
        break;
      default:
        break;
    }
  }
  if (!fields.ok()) {
    throw InputError(
        {.file = file, .problem = std::string(fields.problem()), .expected = "Cardboard viewer parameters"});
  }
  if (alignment > 2) detail::cardboard_fail(file, {"vertical_alignment", "0 (bottom), 1 (center) or 2 (top)"});
  if (button > 3) detail::cardboard_fail(file, {"primary_button", "0 to 3"});
  viewer.alignment = static_cast<CardboardAlignment>(alignment);
  viewer.button = static_cast<CardboardButton>(button);
  detail::set_fov(viewer, fov, file);
  return detail::checked(viewer, file);
}

/// The buffer's bytes, in the order in which Google's generator writes them.
[[nodiscard]] inline std::string cardboard_buffer(const CardboardViewer& viewer) {
  WireWriter out;
  out.bytes(1, viewer.vendor);
  out.bytes(2, viewer.model);
  out.float32(3, viewer.screen_to_lens_m);
  out.float32(4, viewer.inter_lens_m);
  out.floats(5, viewer.fov_deg);
  out.integer(11, static_cast<std::uint64_t>(viewer.alignment));
  out.float32(6, viewer.tray_to_lens_m);
  out.floats(7, viewer.distortion);
  if (viewer.has_magnet) out.integer(10, *viewer.has_magnet ? 1 : 0);
  out.integer(12, static_cast<std::uint64_t>(viewer.button));
  return out.written();
}

/// From an address with the parameter p, https://google.com/cardboard/cfg?p=...
[[nodiscard]] inline CardboardViewer parse_cardboard_uri(std::string_view uri, const std::string& file) {
  const auto fail = [&](std::string_view value, const char* problem, const char* expected) {
    throw InputError({.file = file, .key = "p", .problem = problem, .value = std::string(value), .expected = expected});
  };
  while (!uri.empty() && static_cast<unsigned char>(uri.back()) <= ' ') uri.remove_suffix(1);
  std::size_t begin = uri.find("?p=");
  if (begin == std::string_view::npos) begin = uri.find("&p=");
  if (begin == std::string_view::npos) {
    fail(uri, "the address holds no viewer", "an address with ?p=...; a short one leads there when it is opened");
  }
  std::string_view p = uri.substr(begin + 3);
  p = p.substr(0, p.find_first_of("&#"));
  const std::optional<std::string> bytes = from_base64url(p);
  if (!bytes) fail(p, "not base64url", "letters, digits, - and _");
  return parse_cardboard_buffer(*bytes, file);
}

[[nodiscard]] inline std::string cardboard_uri(const CardboardViewer& viewer) {
  return "https://google.com/cardboard/cfg?p=" + to_base64url(cardboard_buffer(viewer));
}

[[nodiscard]] inline CardboardViewer cardboard_of(const JsonNode& root, const std::string& file) {
  root.allow_only({"schema", "vendor", "model", "screen_to_lens_distance", "inter_lens_distance",
                   "left_eye_field_of_view_angles", "vertical_alignment", "tray_to_lens_distance",
                   "distortion_coefficients", "has_magnet", "primary_button"});
  const auto number = [](const JsonNode& node) { return static_cast<float>(node.number(-1e6, 1e6)); };
  CardboardViewer viewer;
  if (const auto vendor = root.find("vendor")) viewer.vendor = vendor->string();
  if (const auto model = root.find("model")) viewer.model = model->string();
  viewer.screen_to_lens_m = number(root.at("screen_to_lens_distance"));
  viewer.inter_lens_m = number(root.at("inter_lens_distance"));
  if (const auto tray = root.find("tray_to_lens_distance")) viewer.tray_to_lens_m = number(*tray);
  std::vector<float> fov;
  for (const JsonNode& e : root.at("left_eye_field_of_view_angles").elements(4, 4)) fov.push_back(number(e));
  detail::set_fov(viewer, fov, file);
  if (const auto list = root.find("distortion_coefficients")) {
    for (const JsonNode& e : list->elements(0, PolynomialLens::max_coefficients))
      viewer.distortion.push_back(number(e));
  }
  if (const auto alignment = root.find("vertical_alignment")) {
    viewer.alignment = static_cast<CardboardAlignment>(alignment->choice({"BOTTOM", "CENTER", "TOP"}));
  }
  if (const auto button = root.find("primary_button")) {
    viewer.button = static_cast<CardboardButton>(button->choice({"NONE", "MAGNET", "TOUCH", "INDIRECT_TOUCH"}));
  }
  if (const auto magnet = root.find("has_magnet")) viewer.has_magnet = magnet->boolean();
  if (const auto problem = problem_of(viewer)) {
    const auto node = root.find(problem->field);
    (node ? *node : root).fail(std::string(problem->field) + " is impossible", std::string(problem->expected));
  }
  return viewer;
}

[[nodiscard]] inline std::string cardboard_json(const CardboardViewer& viewer) {
  const auto list = [](const auto& numbers) {
    detail::OrderedJson json = detail::OrderedJson::array();
    for (const float x : numbers) json.push_back(detail::decimal(x));
    return json;
  };
  detail::OrderedJson json{{"schema", cardboard_schema},
                           {"vendor", viewer.vendor},
                           {"model", viewer.model},
                           {"screen_to_lens_distance", detail::decimal(viewer.screen_to_lens_m)},
                           {"inter_lens_distance", detail::decimal(viewer.inter_lens_m)},
                           {"left_eye_field_of_view_angles", list(viewer.fov_deg)},
                           {"vertical_alignment", detail::alignment_names[static_cast<std::size_t>(viewer.alignment)]},
                           {"tray_to_lens_distance", detail::decimal(viewer.tray_to_lens_m)},
                           {"distortion_coefficients", list(viewer.distortion)}};
  if (viewer.has_magnet) json["has_magnet"] = *viewer.has_magnet;
  json["primary_button"] = detail::button_names[static_cast<std::size_t>(viewer.button)];
  return detail::pretty(json);
}

/// From any of the three forms, told apart by the content.
[[nodiscard]] inline CardboardViewer parse_cardboard(std::string_view text, std::string file) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  const std::string_view trimmed = begin == std::string_view::npos ? std::string_view() : text.substr(begin);
  if (trimmed.starts_with("{") || trimmed.starts_with("//") || trimmed.starts_with("/*")) {
    const JsonDocument document = JsonDocument::parse(text, std::move(file));
    return cardboard_of(document.root(), document.file());
  }
  if (trimmed.starts_with("http")) return parse_cardboard_uri(trimmed, file);
  return parse_cardboard_buffer(text, file);
}

[[nodiscard]] inline CardboardViewer read_cardboard(const std::filesystem::path& path) {
  return parse_cardboard(read_whole_file(path), path.string());
}

/// The headset of a viewer and a phone, or an InputError that names what does not fit.
[[nodiscard]] inline HmdModel checked_cardboard_hmd(const CardboardViewer& viewer, const PhoneScreen& phone,
                                                    const std::string& file) {
  for (const auto& problem : {problem_of(viewer), problem_of(phone)}) {
    if (problem) detail::cardboard_fail(file, *problem);
  }
  if (const auto problem = problem_of(viewer, phone)) detail::cardboard_fail(file, *problem);
  HmdModel hmd = cardboard_hmd(viewer, phone);
  hmd.source = "Cardboard viewer parameters " + std::filesystem::path(file).filename().string() + ", on a phone of " +
               detail::brief(phone.width_m * 1000.0) + " x " + detail::brief(phone.height_m * 1000.0) + " mm";
  return hmd;
}

}  // namespace holdfast::io
