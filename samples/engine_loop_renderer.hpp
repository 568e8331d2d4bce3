// How engine_loop.cpp draws one eye: the scene into the overfilled picture, and the late warp of that picture.
#pragma once

#include <holdfast/pipeline/pipeline.hpp>
#include <holdfast/rendering/rendering.hpp>

namespace engine_loop {

using namespace holdfast;
using Picture = RenderedPicture<rendering::RenderTarget*>;  // a picture that keeps the view it was drawn with

class EyeRenderer {
 public:
  static constexpr ClipPlanes clip{0.05, 100.0};

  EyeRenderer(rendering::Context& context, const RegistrationScene& scene, const EyeModel& eye,
              const EyePicture& picture, LensMode lens)
      : painter_(context, scene),
        target_(context, picture.size.width, picture.size.height),
        result_(context, eye.resolution.width, eye.resolution.height),
        panel_mesh_(context, adaptive_mesh(eye, lens, {})),
        seen_mesh_(context, rendering::seen_mesh(eye, lens)),
        warp_(context),
        depth_warp_(context),
        surface_(context, picture.size) {
    picture_eye_.tangents = picture.tangents;  // with them the painter makes the same matrices as EyeView has
    picture_eye_.resolution = picture.size;
  }

  [[nodiscard]] const EyeModel& picture_eye() const { return picture_eye_; }

  [[nodiscard]] Picture draw(const EyeView& view, const rendering::SceneStyle& style) {
    target_.clear(style.background);
    painter_.draw({.eye = &picture_eye_, .X_WE = view.X_WE, .clip = clip}, style);
    return Picture(view.rendered_view(), &target_);
  }

  /// What is sent to the panel: lens, late correction and scan lines in one pass.
  rendering::RenderTarget& panel(const Picture& picture, const EyeDeflection& late, DeflectionKind kind,
                                 const DisplayTiming& timing) {
    return warp(picture, late, kind, timing, panel_mesh_);
  }
  /// What the eye then sees: for measuring.
  rendering::RenderTarget& seen(const Picture& picture, const EyeDeflection& late, DeflectionKind kind,
                                const DisplayTiming& timing) {
    return warp(picture, late, kind, timing, seen_mesh_);
  }

 private:
  rendering::RenderTarget& warp(const Picture& picture, const EyeDeflection& late, DeflectionKind kind,
                                const DisplayTiming& timing, const rendering::WarpMesh& mesh) {
    if (kind == DeflectionKind::depth) {
      surface_.update(picture, clip);
      depth_warp_.draw(picture, surface_, mesh, late.deflection.X_SE, timing, result_);
    } else {
      warp_.draw(picture, mesh, late.deflection.H_SE, timing, result_);
    }
    return result_;
  }

  rendering::RegistrationScenePainter painter_;
  EyeModel picture_eye_;
  rendering::RenderTarget target_, result_;
  rendering::WarpMesh panel_mesh_, seen_mesh_;
  rendering::LateWarpPass warp_;
  rendering::DepthWarpPass depth_warp_;
  rendering::DepthSurfaceTexture surface_;
};

}  // namespace engine_loop
