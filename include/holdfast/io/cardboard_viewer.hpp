/// A Cardboard viewer, a phone's screen, and the headset that the two make together.
///
/// The viewer's fields are those of CardboardDevice.DeviceParams (Google Cardboard SDK, proto/cardboard_device.proto),
/// kept as the 32-bit numbers that they are. The SDK takes the lens as the eye: a length on the screen over
/// screen_to_lens_m is a tangent, and p' = p (1 + K1 r^2 + K2 r^4 + ...) goes from the screen to what is seen. Lenses
/// are centred sideways; upwards the phone rests on a tray, whose distance less 3 mm of the phone's edge is the lens's
/// height over the picture. The virtual image is taken as infinitely far. fov_deg only limits what is worth drawing:
/// see drawn_field. Bad input: problem_of names the field and what was expected; nothing here throws.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/optics/hmd.hpp>

namespace holdfast::io {

/// How the phone lies in the viewer.
enum class CardboardAlignment { bottom, center, top };
/// The viewer's button; told to applications, without effect here.
enum class CardboardButton { none, magnet, touch, indirect_touch };

struct CardboardViewer {
  std::string vendor;
  std::string model;
  float screen_to_lens_m = 0.0f;
  float inter_lens_m = 0.0f;
  float tray_to_lens_m = 0.0f;  ///< of no effect when the phone is centred
  CardboardAlignment alignment = CardboardAlignment::bottom;
  std::array<float, 4> fov_deg{};  ///< left eye: outer, inner, bottom, top; all positive
  std::vector<float> distortion;   ///< K1, K2, ...
  CardboardButton button = CardboardButton::magnet;
  std::optional<bool> has_magnet;  ///< of early viewers

  friend bool operator==(const CardboardViewer&, const CardboardViewer&) = default;
};

/// A phone in landscape: the lit part of its screen.
struct PhoneScreen {
  double width_m = 0.0;
  double height_m = 0.0;
  PixelSize resolution;  ///< of the whole screen; each eye gets half the width
  double refresh_hz = 60.0;
};

struct CardboardProblem {
  std::string_view field;
  std::string_view expected;
};

[[nodiscard]] inline std::optional<CardboardProblem> problem_of(const CardboardViewer& v) {
  const auto is_length = [](float x) { return x >= 0.001f && x <= 1.0f; };
  if (!is_length(v.screen_to_lens_m)) return CardboardProblem{"screen_to_lens_distance", "0.001 to 1 m"};
  if (!(v.inter_lens_m >= 0.001f && v.inter_lens_m <= 0.2f)) {
    return CardboardProblem{"inter_lens_distance", "0.001 to 0.2 m"};
  }
  if (v.alignment != CardboardAlignment::center && !is_length(v.tray_to_lens_m)) {
    return CardboardProblem{"tray_to_lens_distance", "0.001 to 1 m, as the phone rests on a tray"};
  }
  if (!(std::abs(v.tray_to_lens_m) <= 1.0f)) return CardboardProblem{"tray_to_lens_distance", "at most 1 m"};
  for (const float angle : v.fov_deg) {
    if (!(angle > 0.0f && angle < 90.0f))
      return CardboardProblem{"left_eye_field_of_view_angles", "4 angles of 0 to 90 degrees"};
  }
  if (v.distortion.size() > PolynomialLens::max_coefficients) {
    return CardboardProblem{"distortion_coefficients", "at most 16 coefficients"};
  }
  for (const float k : v.distortion) {
    if (!(std::abs(k) <= 1000.0f)) return CardboardProblem{"distortion_coefficients", "finite numbers up to 1000"};
  }
  return std::nullopt;
}

[[nodiscard]] inline std::optional<CardboardProblem> problem_of(const PhoneScreen& p) {
  const auto is_length = [](double x) { return x >= 0.01 && x <= 1.0; };
  if (!is_length(p.width_m)) return CardboardProblem{"width_m", "0.01 to 1 m"};
  if (!is_length(p.height_m)) return CardboardProblem{"height_m", "0.01 to 1 m"};
  if (p.resolution.width < 2 || p.resolution.width > 65536 || p.resolution.width % 2 != 0) {
    return CardboardProblem{"resolution.width", "an even number of pixels, 2 to 65536"};
  }
  if (p.resolution.height < 1 || p.resolution.height > 32768) {
    return CardboardProblem{"resolution.height", "1 to 32768 pixels"};
  }
  if (!(p.refresh_hz >= 1.0 && p.refresh_hz <= 1e5)) return CardboardProblem{"refresh_hz", "1 to 1e5 Hz"};
  return std::nullopt;
}

/// The lens's height over the lower edge of the picture.
[[nodiscard]] inline double lens_height_m(const CardboardViewer& v, double screen_height_m) {
  constexpr double edge = 0.003;  // the SDK's kDefaultBorderSizeMeters
  switch (v.alignment) {
    case CardboardAlignment::bottom:
      return double(v.tray_to_lens_m) - edge;
    case CardboardAlignment::top:
      return screen_height_m - double(v.tray_to_lens_m) - edge;  // as in the SDK, which takes the edge off here too
    case CardboardAlignment::center:
      break;
  }
  return screen_height_m / 2.0;
}

/// What keeps viewer and phone from working together: a lens that is not over its half of the screen.
[[nodiscard]] inline std::optional<CardboardProblem> problem_of(const CardboardViewer& v, const PhoneScreen& phone) {
  if (!(double(v.inter_lens_m) < phone.width_m)) {
    return CardboardProblem{"inter_lens_distance", "less than the phone's width"};
  }
  const double low = lens_height_m(v, phone.height_m);
  if (!(low > 0.0 && low < phone.height_m)) {
    return CardboardProblem{"tray_to_lens_distance", "lenses level with the phone's screen"};
  }
  return std::nullopt;
}

/// Preconditions: no problem in either, nor in both together. The eye of the headset is the left one; the right one mirrors it.
[[nodiscard]] inline HmdModel cardboard_hmd(const CardboardViewer& v, const PhoneScreen& phone) {
  HmdModel hmd;
  hmd.name = v.vendor + (v.vendor.empty() || v.model.empty() ? "" : " ") + v.model;
  if (hmd.name.empty()) hmd.name = "Cardboard viewer";
  hmd.source = "Cardboard viewer parameters, and a phone of the caller's";
  hmd.ipd_m = double(v.inter_lens_m);
  hmd.timing.refresh_hz = phone.refresh_hz;
  const double to_screen = double(v.screen_to_lens_m);
  const double inner = hmd.ipd_m / 2.0;
  const double low = lens_height_m(v, phone.height_m);
  hmd.left.side = EyeSide::left;
  hmd.left.X_HE = eye_pose(EyeSide::left, hmd.ipd_m);
  hmd.left.tangents = {-(phone.width_m / 2.0 - inner) / to_screen, inner / to_screen, -low / to_screen,
                       (phone.height_m - low) / to_screen};
  hmd.left.resolution = {phone.resolution.width / 2, phone.resolution.height};
  const std::vector<double> k(v.distortion.begin(), v.distortion.end());
  if (!k.empty()) hmd.left.lens = Lens(PolynomialLens(k));
  hmd.right = mirrored(hmd.left);
  return hmd;
}

/// The field that the SDK draws for an eye of cardboard_hmd: where the panel's edges are seen, within fov_deg. An edge
/// beyond the lens's fold is limited by fov_deg alone.
[[nodiscard]] inline FieldTangents drawn_field(const CardboardViewer& v, const EyeModel& eye) {
  const auto within = [&](const Vector2& edge, std::size_t limit) {
    const double most = tan(degrees(double(v.fov_deg[limit])));
    const std::optional<Vector2> seen = eye.lens.distort(edge);
    return seen ? std::min(most, seen->cwiseAbs().maxCoeff()) : most;
  };
  const std::size_t at_left = eye.side == EyeSide::left ? 0 : 1;
  const FieldTangents& t = eye.tangents;
  return {-within(Vector2(t.left, 0.0), at_left), within(Vector2(t.right, 0.0), 1 - at_left),
          -within(Vector2(0.0, t.down), 2), within(Vector2(0.0, t.up), 3)};
}

}  // namespace holdfast::io
