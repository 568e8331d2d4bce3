// Who looks at what engine_loop.cpp shows: where the eye sees each real point and its virtual twin, and what registration
// and swim follow. Not part of an engine: it knows the head's true motion.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <holdfast/motion/motion.hpp>
#include <holdfast/pipeline/pipeline.hpp>
#include <holdfast/registration/fiducial_error.hpp>
#include <holdfast/registration/metrics.hpp>
#include <holdfast/registration/picture_centroid.hpp>
#include <holdfast/registration/shown_point.hpp>
#include <holdfast/registration/swim.hpp>

namespace engine_loop {

using namespace holdfast;

/// One eye's scan-out: what was drawn, and how it was moved.
struct Shown {
  const EyeModel* eye = nullptr;
  LensMode lens = LensMode::none;
  RenderedView view;
  const EyeDeflection* deflection = nullptr;
  DeflectionKind kind = DeflectionKind::rotation;
  HostTime scan_middle{};
  DisplayTiming timing;
};

/// Registration error and swim of the discs of the registration scene, over both eyes and all frames. Points, not
/// pictures: each disc's centre is followed from the world through view, late warp, lens and scan-out to the pixel
/// where the eye sees it (ComposedWarp), and so is the real one, at the time at which the line lights where it appears.
class Observer {
 public:
  Observer(const Motion& motion, const RegistrationScene& scene)
      : motion_(&motion), scene_(&scene), swim_(2 * scene.discs.size()) {}

  void look(std::size_t frame, const Shown& shown) {
    const EyeModel& eye = *shown.eye;
    const ComposedWarp warp(eye, shown.lens, shown.timing, shown.view, shown.deflection->deflection.H_SE);
    for (std::size_t i = 0; i < scene_->discs.size(); ++i) {
      const Vector3& p_W = scene_->discs[i].centre_W;
      const std::optional<Vector2> real = real_pixel(shown, warp, p_W);
      const std::optional<Vector2> seen = real ? virtual_pixel(shown, warp, p_W) : std::nullopt;
      if (!seen || !is_inside(eye, *seen) || !is_inside(eye, *real)) continue;
      const Vector2 error_px = *seen - *real;
      const Vector2 error_rad = angular_error(ray_E(eye, *real), ray_E(eye, *seen));
      squares_px_ += error_px.squaredNorm();
      ++points_;
      const std::size_t number = i + (eye.side == EyeSide::left ? 0 : scene_->discs.size());
      const auto swim = swim_.add(number, frame, shown.scan_middle, error_px, error_rad);
      if (!swim) continue;
      squares_deg_s_ += swim->deg_s() * swim->deg_s();
      ++swims_;
    }
  }

  [[nodiscard]] double registration_px() const { return std::sqrt(squares_px_ / static_cast<double>(points_)); }
  [[nodiscard]] double swim_deg_s() const { return std::sqrt(squares_deg_s_ / static_cast<double>(swims_)); }
  [[nodiscard]] std::size_t points() const { return points_; }

  /// Where the eye sees the real point while its line lights.
  [[nodiscard]] std::optional<Vector2> real_pixel(const Shown& shown, const ComposedWarp& warp,
                                                  const Vector3& p_W) const {
    return on_its_line([&](double s) -> std::optional<LitPlace<Vector2>> {
      const HostTime t = shown.scan_middle + line_time_from_middle(shown.timing, s);
      const Rigid X_WE = motion_->at(t).X_WB * shown.eye->X_HE;
      const std::optional<Vector2> seen = project(*shown.eye, X_WE.inverse() * p_W);
      const auto panel = seen ? warp.panel_pixel_seen(*seen) : std::nullopt;
      if (!panel) return std::nullopt;
      return LitPlace<Vector2>{*seen, warp.line_fraction(*panel)};
    });
  }

  /// Where the eye sees the virtual point, if the picture shows it.
  [[nodiscard]] static std::optional<Vector2> virtual_pixel(const Shown& shown, const ComposedWarp& warp,
                                                            const Vector3& p_W) {
    const Vector3 p_S = shown.view.X_WS.inverse() * p_W;
    const std::optional<Vector2> t_S = tangents_of_point(p_S);
    if (!t_S || !is_inside(shown.view, source_pixel_of_tangent(shown.view, *t_S))) return std::nullopt;
    return seen_pixel(shown, warp, *t_S, -1.0 / p_S.z());
  }

  /// Where the eye sees what the picture has at t_S, at distance 1/w.
  [[nodiscard]] static std::optional<Vector2> seen_pixel(const Shown& shown, const ComposedWarp& warp,
                                                         const Vector2& t_S, double w) {
    if (shown.kind != DeflectionKind::depth) return warp.seen_pixel(source_pixel_of_tangent(shown.view, t_S));
    const Lens& lens = shown.eye->lens;
    const auto t_E = on_its_line([&](double s) -> std::optional<LitPlace<Vector2>> {
      const auto at = tangents_of_point(DepthSearch::seen_from_E(shown.deflection->deflection.X_SE.at(s), t_S, w));
      const auto drawn = at ? drawn_tangent(lens, shown.lens, *at) : std::nullopt;
      if (!drawn) return std::nullopt;
      return LitPlace<Vector2>{*at, warp.line_fraction(pixel_of_tangent(*shown.eye, *drawn))};
    });
    if (!t_E) return std::nullopt;
    const auto seen = seen_tangent(lens, shown.lens, *t_E);
    return seen ? std::optional<Vector2>(pixel_of_tangent(*shown.eye, *seen)) : std::nullopt;
  }

 private:
  const Motion* motion_;
  const RegistrationScene* scene_;
  SwimMeter swim_;
  double squares_px_ = 0.0, squares_deg_s_ = 0.0;
  std::size_t points_ = 0, swims_ = 0;
};

/// Holds the figures above against a picture: where each disc's centroid is in what the eye sees, and where it should
/// be by the same arithmetic.
class PictureCheck {
 public:
  void look(const Shown& shown, const EyeModel& picture_eye, const RegistrationScene& scene,
            const PictureView& seen_picture) {
    const ComposedWarp warp(*shown.eye, shown.lens, shown.timing, shown.view, shown.deflection->deflection.H_SE);
    std::vector<Expected> discs;
    for (const Disc& disc : scene.discs) {
      if (const auto expected = expect(shown, warp, picture_eye, disc)) discs.push_back(*expected);
    }
    for (const Expected& disc : discs) {
      if (!disc.is_whole || !is_alone(disc, discs)) continue;
      const auto measured = picture_centroid(seen_picture, window_around(disc.centroid, disc.half_extent));
      if (!measured) continue;
      squares_ += (measured->centroid - disc.centroid).squaredNorm();
      ++discs_;
    }
  }

  [[nodiscard]] std::size_t discs() const { return discs_; }
  [[nodiscard]] double rms_px() const { return std::sqrt(squares_ / static_cast<double>(discs_)); }

 private:
  struct Expected {
    Vector2 centroid, half_extent;
    bool is_whole;
  };

  [[nodiscard]] static std::optional<Expected> expect(const Shown& shown, const ComposedWarp& warp,
                                                      const EyeModel& picture_eye, const Disc& disc) {
    const auto drawn = project_disc(picture_eye, shown.view.X_WS, disc);
    if (!drawn || !drawn->front) return std::nullopt;
    const Rigid X_SW = shown.view.X_WS.inverse();
    const Vector3 normal_S = X_SW.q() * disc.normal_W;
    const double offset = normal_S.dot(X_SW * disc.centre_W);
    Vector2 low = Vector2::Constant(1e9), high = -low;
    const auto centroid = centroid_through(*drawn, [&](const Vector2& source) {
      const Vector2 t_S = tangent_of_source_pixel(shown.view, source);
      const auto seen = Observer::seen_pixel(shown, warp, t_S, normal_S.dot(direction_of_tangents(t_S)) / offset);
      if (seen) {
        low = low.cwiseMin(*seen);
        high = high.cwiseMax(*seen);
      }
      return seen;
    });
    if (!centroid) return std::nullopt;
    const Vector2 half_extent = (high - *centroid).cwiseMax(*centroid - low);
    const Vector2 reach = half_extent + Vector2::Constant(8.0);
    const PixelSize& size = shown.eye->resolution;
    const bool is_whole = drawn->is_inside(picture_eye.resolution, 2.0) && centroid->x() > reach.x() &&
                          centroid->y() > reach.y() && centroid->x() < size.width - reach.x() &&
                          centroid->y() < size.height - reach.y();
    return Expected{*centroid, half_extent, is_whole};
  }

  [[nodiscard]] static bool is_alone(const Expected& disc, const std::vector<Expected>& all) {
    int near = 0;
    for (const Expected& other : all) {
      const Vector2 gap = (disc.centroid - other.centroid).cwiseAbs() - disc.half_extent - other.half_extent;
      near += gap.maxCoeff() < 8.0 ? 1 : 0;
    }
    return near == 1;  // itself
  }

  double squares_ = 0.0;
  std::size_t discs_ = 0;
};

}  // namespace engine_loop
