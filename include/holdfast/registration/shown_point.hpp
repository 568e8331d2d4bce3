/// Where the eye sees a point, and a disc, of a finished picture that was drawn, deflected, predistorted and scanned out.
///
/// A picture is drawn for the eye S (ShownPicture::view). Deflected, the tangent t_S is shown at t_E, (t_S, 1) ~ H_SE(s)
/// (t_E, 1) at the line fraction s of the panel's pixel; a depth correction shows each point where the late eye at that
/// line would have it, as the point's distance is known exactly here. The renderer draws and predistorts for the eye
/// model that it believes in; light goes through the true one. Where the deflection is one for all lines, a disc stays
/// an ellipse, which is mapped exactly; line by line its outline is followed (outline_centroid.hpp). Agrees with
/// ComposedWarp::seen_pixel. Pixels as in eye.hpp: those that the eye sees; they may lie beyond the panel's edge. Bad
/// input: what lies behind an eye, outside a lens's domain or outside the picture that was drawn is not shown: nothing.
#pragma once

#include <array>
#include <optional>

#include <holdfast/deflection/lit_line.hpp>
#include <holdfast/registration/experiment_types.hpp>
#include <holdfast/registration/projected_ellipse.hpp>

namespace holdfast {

/// The display that a picture is shown on.
struct ShownOn {
  const EyeModel& eye;       ///< the true one
  const EyeModel& believed;  ///< the renderer's; the true one unless told otherwise
  LensMode lens = LensMode::none;
  const DisplayTiming& timing;

  /// Line fraction at which a panel pixel lights; 1/2 on a global display.
  [[nodiscard]] double line_fraction(const Vector2& panel_pixel) const {
    if (timing.scan_out == ScanOut::global) return 0.5;
    const Vector2 size(eye.resolution.width, eye.resolution.height);
    return line_fraction_of_pixel(timing.scan_direction, panel_pixel, size);
  }
};

/// An eye model that draws the picture of `view`: its projection and its pixels. The panel's being upside down and the
/// lens come later.
[[nodiscard]] inline EyeModel drawing_eye(const EyeModel& eye, const RenderedView& view) {
  EyeModel drawing;
  drawing.side = eye.side;
  drawing.X_HE = eye.X_HE;
  drawing.tangents = view.tangents;
  drawing.resolution = view.size;
  return drawing;
}

namespace detail {

/// Where the eye sees what is shown at tangent_at(s), an optional Vector2, on the line of fraction s.
template <typename TangentAt>
[[nodiscard]] std::optional<Vector2> seen_on_its_line(const ShownOn& on, const TangentAt& tangent_at) {
  const auto ideal = on_its_line([&](double s) -> std::optional<LitPlace<Vector2>> {
    const std::optional<Vector2> t_E = tangent_at(s);
    if (!t_E) return std::nullopt;
    const Vector2 pixel = pixel_of_tangent(on.believed, *t_E);
    const std::optional<Vector2> panel = drawn_pixel(on.believed, on.lens, pixel);
    if (!panel) return std::nullopt;
    return LitPlace<Vector2>{pixel, on.line_fraction(*panel)};
  });
  return ideal ? seen_pixel(on.eye, on.believed, on.lens, *ideal) : std::nullopt;
}

}  // namespace detail

/// Where the eye sees a point of the world, or would if the picture that was drawn reached so far.
[[nodiscard]] inline std::optional<Vector2> place_in_view(const ShownPicture& picture, const ShownOn& on,
                                                          const Vector3& p_W) {
  const Vector3 p_S = picture.view.X_WS.inverse() * p_W;
  const std::optional<Vector2> t_S = tangents_of_point(p_S);
  if (!t_S) return std::nullopt;
  if (!picture.is_deflected()) {
    return seen_pixel(on.eye, on.believed, on.lens, pixel_of_tangent(on.believed, *t_S));
  }
  const DeflectionResult& d = picture.deflection;
  if (picture.how.kind == DeflectionKind::depth) {
    return detail::seen_on_its_line(on, [&](double s) { return tangents_of_point(d.X_SE.at(s).inverse() * p_S); });
  }
  return detail::seen_on_its_line(on, [&](double s) { return d.H_SE.displayed_tangent(*t_S, s); });
}

/// Where the eye sees a point of the world.
[[nodiscard]] inline std::optional<Vector2> shown_point(const ShownPicture& picture, const ShownOn& on,
                                                        const Vector3& p_W) {
  const std::optional<Vector2> t_S = tangents_of_point(picture.view.X_WS.inverse() * p_W);
  const bool drawn = t_S && is_inside(picture.view, source_pixel_of_tangent(picture.view, *t_S));
  return drawn ? place_in_view(picture, on, p_W) : std::nullopt;
}

namespace detail {

/// The disc in the picture as shown, where the deflection is the same for all lines.
[[nodiscard]] inline std::optional<ProjectedEllipse> shown_ellipse(const ShownPicture& picture, const ShownOn& on,
                                                                   const Disc& disc) {
  const Rigid& X_WS = picture.view.X_WS;
  if (!picture.is_deflected()) return project_disc(on.believed, X_WS, disc);
  if (picture.how.kind == DeflectionKind::depth) {
    return project_disc(on.believed, X_WS * picture.deflection.X_SE.begin(), disc);
  }
  return project_disc(on.believed, X_WS, disc, picture.deflection.H_SE.begin().inverse());
}

[[nodiscard]] inline bool is_constant(const ShownPicture& picture) {
  if (!picture.is_deflected()) return true;
  return picture.how.kind == DeflectionKind::depth ? picture.deflection.X_SE.is_constant()
                                                   : picture.deflection.H_SE.is_constant();
}

}  // namespace detail

/// Centroid of a disc as the eye sees it, when all of it is drawn and shown, and `margin_px` more.
[[nodiscard]] inline std::optional<Vector2> shown_centroid(const ShownPicture& picture, const ShownOn& on,
                                                           const Disc& disc, double margin_px = 1.0) {
  if (picture.is_deflected()) {
    const auto drawn = project_disc(drawing_eye(on.believed, picture.view), picture.view.X_WS, disc);
    if (!drawn || !drawn->front || !drawn->is_inside(picture.view.size, margin_px)) return std::nullopt;
  }
  if (detail::is_constant(picture)) {
    const std::optional<ProjectedEllipse> shown = detail::shown_ellipse(picture, on, disc);
    if (!shown || !shown->front || !shown->is_inside(on.eye.resolution, margin_px)) return std::nullopt;
    if (&on.eye == &on.believed) return seen_centroid(on.eye, on.lens, *shown);
    return seen_centroid(on.eye, on.believed, on.lens, *shown);
  }
  const std::array<Vector3, 2> across_W = detail::basis_across(disc.normal_W);
  const Vector2 size(on.eye.resolution.width, on.eye.resolution.height);
  return outline_centroid([&](double cosine, double sine) -> std::optional<Vector2> {
    const Vector3 p_W = disc.centre_W + disc.radius_m * (cosine * across_W[0] + sine * across_W[1]);
    const std::optional<Vector2> seen = shown_point(picture, on, p_W);
    const bool inside = seen && seen->minCoeff() >= margin_px && (size - *seen).minCoeff() >= margin_px;
    return inside ? seen : std::nullopt;
  });
}

}  // namespace holdfast
