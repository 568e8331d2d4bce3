/// What of the view a frame cannot show: directions without a source pixel, and such that come from behind something.
///
/// The view is the eye's ideal picture, as seen through the lens, on a grid of directions. A direction is missing when
/// the lens cannot show it, when no panel pixel lies there, or when the place that the deflection looks up is outside
/// the picture that was drawn. A depth correction moves each point by its own distance; a direction is disoccluded when
/// the late eye sees a point of the scene there (or the emptiness behind it) that the drawing eye could not see for
/// something nearer: its colour is not known. Both eyes' views are cast into the scene itself (scene_depth.hpp), so
/// that the numbers are those of an ideal depth buffer; a model drawn besides is not in them. The grid's directions and
/// their lines are found once per eye and lens, which coverage() of deflection/coverage.hpp does anew for each frame;
/// where the map knows no depth, both agree. Source: evaluation.md "Metrics". Bad input: none.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include <holdfast/deflection/coverage.hpp>
#include <holdfast/registration/fiducial_error.hpp>
#include <holdfast/registration/scene_depth.hpp>
#include <holdfast/registration/shown_point.hpp>

namespace holdfast {

class ViewCoverageMeter {
 public:
  explicit ViewCoverageMeter(const ShownOn& on, const PixelSize& grid = {96, 54})
      : all_(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height)) {
    directions_.reserve(all_);
    const PixelSize size = on.eye.resolution;
    for (int row = 0; row < grid.height; ++row) {
      for (int column = 0; column < grid.width; ++column) {
        const Vector2 seen(size.width * (column + 0.5) / grid.width, size.height * (row + 0.5) / grid.height);
        const std::optional<Vector2> panel = panel_pixel_seen(on.eye, on.lens, seen);
        if (!panel || !is_inside(on.eye, *panel)) continue;
        const std::optional<Vector2> ideal = ideal_pixel_at_panel(on.believed, on.lens, *panel);
        if (ideal) directions_.push_back({tangent_of_pixel(on.believed, *ideal), on.line_fraction(*panel)});
      }
    }
  }

  /// What the frame shows of the view. Disocclusion is found only where the correction goes by depth.
  [[nodiscard]] Coverage measure(const ShownPicture& picture, const RegistrationScene& scene) {
    Coverage result;
    result.directions = all_;
    result.not_seen = all_ - directions_.size();
    const bool by_depth = picture.is_deflected() && picture.how.kind == DeflectionKind::depth;
    if (by_depth) place_eyes(picture, scene);
    for (const Direction& d : directions_) {
      const SourceState state = by_depth ? state_by_depth(picture, d) : state_by_map(picture, d);
      result.covered += state == SourceState::covered ? 1 : 0;
      result.disoccluded += state == SourceState::disoccluded ? 1 : 0;
      result.outside += state == SourceState::outside ? 1 : 0;
      result.not_seen += state == SourceState::not_seen ? 1 : 0;
    }
    return result;
  }

 private:
  struct Direction {
    Vector2 t_E;
    double line;
  };

  [[nodiscard]] static SourceState state_by_map(const ShownPicture& picture, const Direction& d) {
    const std::optional<Vector2> t_S =
        picture.is_deflected() ? picture.deflection.H_SE.source_tangent(d.t_E, d.line) : d.t_E;
    if (!t_S) return SourceState::not_seen;
    const bool inside = is_inside(picture.view, source_pixel_of_tangent(picture.view, *t_S));
    return inside ? SourceState::covered : SourceState::outside;
  }

  /// The late eye is placed at the middle of the scan: how much becomes visible does not hang on a line's fraction.
  void place_eyes(const ShownPicture& picture, const RegistrationScene& scene) {
    X_SE_ = picture.deflection.X_SE.middle();
    source_.place(scene, picture.view.X_WS, picture.view.tangents);
    shown_.place(scene, picture.view.X_WS * X_SE_, picture.view.tangents);
  }

  [[nodiscard]] SourceState state_by_depth(const ShownPicture& picture, const Direction& d) const {
    const double distance = shown_.at(d.t_E);
    const Vector3 ray_E = direction_of_tangents(d.t_E);
    const bool far = std::isinf(distance);
    const Vector3 p_S = far ? Vector3(X_SE_.q() * ray_E) : Vector3(X_SE_ * Vector3(distance * ray_E));
    const std::optional<Vector2> t_S = tangents_of_point(p_S);
    if (!t_S) return SourceState::not_seen;
    if (!is_inside(picture.view, source_pixel_of_tangent(picture.view, *t_S))) return SourceState::outside;
    // A point on a slanted surface comes back to within rounding; things stand centimetres apart.
    const double own = far ? std::numeric_limits<double>::infinity() : -p_S.z() * (1.0 - 1e-6);
    return source_.at(*t_S) < own ? SourceState::disoccluded : SourceState::covered;
  }

  std::size_t all_;
  std::vector<Direction> directions_;
  Rigid X_SE_;
  SceneDepth source_, shown_;
};

}  // namespace holdfast
