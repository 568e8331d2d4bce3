/// Shared by the tests of rendering: a painter with its target, and the backends to try.
#pragma once

#include <memory>
#include <random>
#include <vector>

#include <holdfast/optics/hmd.hpp>
#include <holdfast/registration/picture_centroid.hpp>
#include <holdfast/registration/projected_ellipse.hpp>
#include <holdfast/rendering/rendering.hpp>

namespace pictures {

using namespace holdfast;
using namespace holdfast::rendering;

struct Studio {
  explicit Studio(Backend backend, EyeModel model = default_hmd().left, int samples = 1,
                  const RegistrationScene& world = default_registration_scene())
      : context(make_context(backend)),
        eye(std::move(model)),
        scene(world),
        painter(*context, scene),
        target(*context, eye.resolution.width, eye.resolution.height, samples) {}

  [[nodiscard]] View view(const Rigid& X_WE) const { return {.eye = &eye, .X_WE = X_WE}; }
  [[nodiscard]] io::Image draw(const Rigid& X_WE, const SceneStyle& style) {
    target.clear(style.background);
    painter.draw(view(X_WE), style);
    return target.read_rgba();
  }

  std::unique_ptr<Context> context;
  EyeModel eye;
  RegistrationScene scene;
  RegistrationScenePainter painter;
  RenderTarget target;
};

[[nodiscard]] inline PictureView look_at(const io::Image& image) {
  return {.bytes = image.rgba, .width = image.width, .height = image.height, .channels = 4};
}

/// Poses of an eye that wanders a few centimetres and turns a few degrees about the first viewpoint; seeded.
[[nodiscard]] inline std::vector<Rigid> wandering_eyes(int count, const Rigid& X_HE) {
  std::mt19937_64 random(20);
  std::uniform_real_distribution<double> one(-1.0, 1.0);
  std::vector<Rigid> poses;
  for (int i = 0; i < count; ++i) {
    // Braces: their members are evaluated in order, by every compiler.
    const Vector3 turn{0.08 * one(random), 0.15 * one(random), 0.3 * one(random)};
    const Vector3 shift{0.05 * one(random), 0.05 * one(random), 0.05 * one(random)};
    poses.push_back(Rigid(so3::exp<double>(turn), shift) * X_HE);
  }
  return poses;
}

/// Error of one disc's centroid in a picture, px.
struct CentroidError {
  Vector2 px = Vector2::Zero();
  double area_ratio = 1.0;  ///< measured over true
  double radius_px = 0.0;   ///< semi-minor axis
};

/// Of all discs that lie wholly inside the picture, at least 8 px in radius, and alone in their window.
[[nodiscard]] inline std::vector<CentroidError> centroid_errors(const io::Image& image, const EyeModel& eye,
                                                                const Rigid& X_WE, const RegistrationScene& scene) {
  std::vector<ProjectedEllipse> ellipses;
  for (const Disc& disc : scene.discs) {
    const auto e = project_disc(eye, X_WE, disc);
    if (e && e->is_inside(eye.resolution, -2.0 * e->semi_major_px)) ellipses.push_back(*e);
  }
  std::vector<CentroidError> errors;
  for (std::size_t i = 0; i < ellipses.size(); ++i) {
    const ProjectedEllipse& e = ellipses[i];
    bool alone = e.is_inside(eye.resolution, 5.0) && e.semi_minor_px >= 8.0;
    for (std::size_t k = 0; k < ellipses.size(); ++k) {
      const Vector2 gap =
          (e.centroid - ellipses[k].centroid).cwiseAbs() - e.half_extent_px - ellipses[k].half_extent_px;
      alone = alone && (k == i || gap.maxCoeff() > 8.0);
    }
    if (!alone) continue;
    const auto found = picture_centroid(look_at(image), window_around(e.centroid, e.half_extent_px));
    if (!found) continue;
    const double area = std::numbers::pi * e.semi_major_px * e.semi_minor_px;
    errors.push_back({found->centroid - e.centroid, found->area_px / area, e.semi_minor_px});
  }
  return errors;
}

[[nodiscard]] inline double rms_px(const std::vector<CentroidError>& errors) {
  double sum = 0.0;
  for (const CentroidError& e : errors) sum += e.px.squaredNorm();
  return std::sqrt(sum / static_cast<double>(errors.size()));
}

}  // namespace pictures
