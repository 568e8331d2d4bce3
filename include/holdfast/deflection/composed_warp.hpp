/// One warp from the panel to the source picture: lens, late correction and scan-out composed, exactly.
///
/// What a pixel of the panel shows:
///     panel pixel -> panel tangent --lens and its correction (per colour)--> t_E --deflection(s)--> t_S -> source pixel,
/// s being the line fraction of the panel pixel (1/2 everywhere on a global display), and the deflection a
/// ScanHomography or a DepthSearch. This is the definition that every implementation (mesh, GLSL, CPU) is tested
/// against. seen_pixel is the inverse: it solves for s (lit_line.hpp). Pixels: origin at the lower left, centres at half integers; panel pixels are the panel's own, also when it is
/// mounted upside down; "seen" pixels are the eye's ideal ones.
/// Bad input: outside the lens's domain, or where the direction is not ahead of the source eye, the answer is nothing.
#pragma once

#include <optional>

#include <holdfast/deflection/depth_search.hpp>
#include <holdfast/deflection/lit_line.hpp>
#include <holdfast/deflection/rendered_picture.hpp>
#include <holdfast/deflection/scan_homography.hpp>
#include <holdfast/deflection/source_state.hpp>
#include <holdfast/optics/eye.hpp>
#include <holdfast/timing/display_timing.hpp>

namespace holdfast {

/// Coefficients c of the line fraction in the panel's own texture coordinates: s = c . (u, v, 1), (u, v) = (0, 0) at
/// the panel picture's lower left. For shaders; a global display has s = 1/2 everywhere.
[[nodiscard]] inline Vector3 line_fraction_coefficients(const DisplayTiming& timing) {
  if (timing.scan_out == ScanOut::global) return {0.0, 0.0, 0.5};
  const auto s = [&](double u, double v) {
    return line_fraction_of_pixel(timing.scan_direction, Vector2(u, v), Vector2(1.0, 1.0));
  };
  const double origin = s(0.0, 0.0);
  return {s(1.0, 0.0) - origin, s(0.0, 1.0) - origin, origin};
}

/// Homogeneous texture coordinates of the source, (u, v, 1) ~ M(s) (t_E, 1), for shaders: (0, 0) is the source
/// picture's lower left, (1, 1) its upper right.
using SourceMatrices = ScanMatrices;

[[nodiscard]] inline SourceMatrices source_matrices(const RenderedView& view, const ScanHomography& H_SE) {
  const FieldTangents& t = view.tangents;
  Matrix3 uv_of_tangent;
  uv_of_tangent << 1.0 / (t.right - t.left), 0.0, -t.left / (t.right - t.left),  //
      0.0, 1.0 / (t.up - t.down), -t.down / (t.up - t.down),                     //
      0.0, 0.0, 1.0;
  return {uv_of_tangent * H_SE.begin(), uv_of_tangent * H_SE.middle(), uv_of_tangent * H_SE.end()};
}

/// A source pixel and whether the picture holds it.
struct SourceSample {
  Vector2 pixel = Vector2::Zero();  ///< not to be used when not_seen
  SourceState state = SourceState::not_seen;
};

class ComposedWarp {
 public:
  /// By a map of tangents: every kind but depth. The eye is not copied: it must live while the warp is used.
  ComposedWarp(const EyeModel& eye, LensMode mode, const DisplayTiming& timing, const RenderedView& view,
               const ScanHomography& H_SE)
      : eye_(&eye), mode_(mode), view_(view), H_SE_(H_SE), line_(line_fraction_coefficients(timing)) {}
  ComposedWarp(EyeModel&&, LensMode, const DisplayTiming&, const RenderedView&, const ScanHomography&) = delete;

  /// By each point's own distance. The eye and the search's surface must live while the warp is used.
  ComposedWarp(const EyeModel& eye, LensMode mode, const DisplayTiming& timing, const RenderedView& view,
               const DepthSearch& depth)
      : eye_(&eye), mode_(mode), view_(view), depth_(depth), line_(line_fraction_coefficients(timing)) {}
  ComposedWarp(EyeModel&&, LensMode, const DisplayTiming&, const RenderedView&, const DepthSearch&) = delete;

  /// What a panel pixel shows: where it is in the source, and whether the picture holds it.
  [[nodiscard]] SourceSample sample(const Vector2& panel_pixel, Color color = Color::green) const {
    const Vector2 panel = tangent_of_pixel(*eye_, panel_pixel);
    const std::optional<Vector2> t_E = ideal_tangent_at_panel(eye_->lens_of(color), mode_, panel);
    if (!t_E) return {};
    const double s = line_fraction(panel_pixel);
    if (depth_) {
      const std::optional<DepthSource> found = depth_->source(*t_E, s);
      return found ? SourceSample{source_pixel_of_tangent(view_, found->t_S), found->state} : SourceSample{};
    }
    const std::optional<Vector2> t_S = H_SE_.source_tangent(*t_E, s);
    if (!t_S) return {};
    const Vector2 pixel = source_pixel_of_tangent(view_, *t_S);
    return {pixel, is_inside(view_, pixel) ? SourceState::covered : SourceState::outside};
  }

  /// The same as the eye sees it at `seen_pixel`, through the true lens; past the panel's edge it sees nothing.
  [[nodiscard]] SourceSample sample_seen(const Vector2& seen_pixel, Color color = Color::green) const {
    const std::optional<Vector2> panel = panel_pixel_seen(seen_pixel, color);
    return panel && is_inside(*eye_, *panel) ? sample(*panel, color) : SourceSample{};
  }

  /// The source pixel that a panel pixel shows; it may lie outside the source picture, or be a guess: see sample.
  [[nodiscard]] std::optional<Vector2> source_pixel(const Vector2& panel_pixel, Color color = Color::green) const {
    const SourceSample found = sample(panel_pixel, color);
    return found.state == SourceState::not_seen ? std::nullopt : std::optional<Vector2>(found.pixel);
  }

  /// The source pixel that the eye sees at `seen_pixel`, through the true lens.
  [[nodiscard]] std::optional<Vector2> source_pixel_seen(const Vector2& seen_pixel, Color color = Color::green) const {
    const std::optional<Vector2> panel = panel_pixel_seen(seen_pixel, color);
    return panel ? source_pixel(*panel, color) : std::nullopt;
  }

  /// The panel pixel that the eye sees at `seen_pixel`, through the true lens.
  [[nodiscard]] std::optional<Vector2> panel_pixel_seen(const Vector2& seen_pixel, Color color = Color::green) const {
    if (mode_ == LensMode::none) return seen_pixel;
    const auto panel = eye_->lens_of(color).undistort(tangent_of_pixel(*eye_, seen_pixel));
    return panel ? std::optional<Vector2>(pixel_of_tangent(*eye_, *panel)) : std::nullopt;
  }

  /// The panel pixel that shows a source pixel: the inverse of source_pixel (by depth: if nothing hides it).
  [[nodiscard]] std::optional<Vector2> panel_pixel(const Vector2& source_pixel, Color color = Color::green) const {
    const Vector2 t_S = tangent_of_source_pixel(view_, source_pixel);
    const auto shown = [&](double s) -> std::optional<Vector2> {
      const std::optional<Vector2> t_E = displayed_tangent(t_S, s);
      const auto drawn = t_E ? drawn_tangent(eye_->lens_of(color), mode_, *t_E) : std::nullopt;
      return drawn ? std::optional<Vector2>(pixel_of_tangent(*eye_, *drawn)) : std::nullopt;
    };
    if (is_constant()) return shown(0.5);
    return on_its_line([&](double s) -> std::optional<LitPlace<Vector2>> {
      const std::optional<Vector2> panel = shown(s);
      if (!panel) return std::nullopt;
      return LitPlace<Vector2>{*panel, line_fraction(*panel)};
    });
  }

  /// Where the eye sees a source pixel, through the true lens: the inverse of source_pixel_seen.
  [[nodiscard]] std::optional<Vector2> seen_pixel(const Vector2& source_pixel, Color color = Color::green) const {
    const std::optional<Vector2> panel = panel_pixel(source_pixel, color);
    if (!panel || mode_ == LensMode::none) return panel;
    const auto seen = eye_->lens_of(color).distort(tangent_of_pixel(*eye_, *panel));
    return seen ? std::optional<Vector2>(pixel_of_tangent(*eye_, *seen)) : std::nullopt;
  }

  /// Line fraction at which a panel pixel lights; 1/2 on a global display.
  [[nodiscard]] double line_fraction(const Vector2& panel_pixel) const {
    return line_.x() * panel_pixel.x() / eye_->resolution.width +
           line_.y() * panel_pixel.y() / eye_->resolution.height + line_.z();
  }

  /// Whether all lines are deflected alike.
  [[nodiscard]] bool is_constant() const { return depth_ ? depth_->X_SE().is_constant() : H_SE_.is_constant(); }

  /// For shaders. Precondition: not by depth.
  [[nodiscard]] SourceMatrices source_matrices() const { return holdfast::source_matrices(view_, H_SE_); }
  [[nodiscard]] const EyeModel& eye() const { return *eye_; }
  [[nodiscard]] LensMode mode() const { return mode_; }
  [[nodiscard]] const RenderedView& view() const { return view_; }
  [[nodiscard]] const ScanHomography& H_SE() const { return H_SE_; }  ///< the identity when by depth
  [[nodiscard]] const DepthSearch* depth() const { return depth_ ? &*depth_ : nullptr; }
  [[nodiscard]] const Vector3& line_coefficients() const { return line_; }

 private:
  [[nodiscard]] std::optional<Vector2> displayed_tangent(const Vector2& t_S, double s) const {
    return depth_ ? depth_->displayed_tangent(t_S, s) : H_SE_.displayed_tangent(t_S, s);
  }

  const EyeModel* eye_;
  LensMode mode_;
  RenderedView view_;
  ScanHomography H_SE_;
  std::optional<DepthSearch> depth_;
  Vector3 line_;  // line_fraction_coefficients
};

}  // namespace holdfast
