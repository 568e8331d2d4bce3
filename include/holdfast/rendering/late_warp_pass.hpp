/// The late warp on the GPU: from the picture that was rendered to the picture on the panel, lens, late correction and
/// scan lines in one pass.
///
/// Upload the eye's mesh once (WarpMesh); each frame draw() takes the rendered picture with its view and the frame's
/// ScanHomography. Definition: ComposedWarp::source_pixel (deflection/composed_warp.hpp); with a SeenMesh it is
/// ComposedWarp::source_pixel_seen, and what lies beyond the panel's edge stays black. The GLSL is in shaders/late_warp*
/// and can be taken as it is. The result's alpha is the coverage mask: 1 where the rendered picture has the place for
/// all colours, else 0 with black; count_coverage_mask counts it.
///
///     const WarpMesh panel(context, adaptive_mesh(eye, LensMode::exact, {}));      // once
///     const DeflectionResult late = deflect(settings, picture.view(), late_poses);  // each frame
///     warp.draw(picture, panel, late.H_SE, timing, result);                         // result: the panel's picture
///
/// For what the eye sees of it (experiments): WarpMesh(context, seen_mesh(eye, mode)) instead, nothing else changes.
/// Leaves depth test, blending and culling off. Bad input: pictures of another size than the view or the mesh say throw
/// RenderingError.
#pragma once

#include <string>

#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/rendering/coverage_mask.hpp>
#include <holdfast/rendering/program.hpp>
#include <holdfast/rendering/render_target.hpp>
#include <holdfast/rendering/shaders.hpp>
#include <holdfast/rendering/warp_mesh.hpp>

namespace holdfast::rendering {

namespace detail {

inline void require_size(const RenderTarget& target, PixelSize size, const char* whose) {
  if (target.width() == size.width && target.height() == size.height) return;
  throw RenderingError("a picture of " + std::to_string(target.width()) + " x " + std::to_string(target.height()) +
                       " pixels where " + whose + " says " + std::to_string(size.width) + " x " +
                       std::to_string(size.height));
}

/// What every late warp demands of its pictures.
inline void require_pictures(const RenderedPicture<RenderTarget*>& source, const RenderTarget& result,
                             PixelSize result_size, const char* whose) {
  HOLDFAST_ASSERT(source.picture() != nullptr, "a rendered picture has a target");
  require_size(*source.picture(), source.view().size, "its view");
  require_size(result, result_size, whose);
  if (source.picture() == &result) throw RenderingError("a picture cannot be warped onto itself");
}

/// Before `mesh` is drawn: the pictures fit, the source can be looked up as texture 0, nothing of `result` is covered.
inline void begin_warp(const GlFunctions& gl, const RenderedPicture<RenderTarget*>& source, const WarpMesh& mesh,
                       RenderTarget& result) {
  require_pictures(source, result, mesh.resolution(), "the mesh");
  source.picture()->resolve();
  result.clear({0, 0, 0, 0});
  gl.Disable(GL_DEPTH_TEST);
  gl.Disable(GL_BLEND);
  gl.Disable(GL_CULL_FACE);
  gl.BindTextureUnit(0, source.picture()->colour_texture());
}

}  // namespace detail

class LateWarpPass {
 public:
  explicit LateWarpPass(Context& context)
      : context_(&context),
        one_colour_(context, shaders::late_warp_vert, shaders::late_warp_frag),
        per_colour_(context, shaders::late_warp_per_colour_vert, shaders::late_warp_per_colour_frag),
        seen_(context, shaders::late_warp_seen_vert, shaders::late_warp_seen_frag) {}

  /// Writes all of `result`, which has the mesh's resolution. The source is resolved here.
  void draw(const RenderedPicture<RenderTarget*>& source, const WarpMesh& mesh, const ScanHomography& H_SE,
            const DisplayTiming& timing, RenderTarget& result) const {
    detail::begin_warp(context_->gl(), source, mesh, result);
    const Pass& pass = pass_of(mesh);
    const SourceMatrices M = source_matrices(source.view(), H_SE);
    pass.program.set(pass.source_of_tangent, {M.begin, M.linear(), M.quadratic()});
    pass.program.set(pass.line_of_place, line_fraction_coefficients(timing));
    pass.program.use();
    mesh.draw();
  }

 private:
  struct Pass {
    Pass(Context& context, const ShaderSource& vertex, const ShaderSource& fragment)
        : program(context, vertex, fragment),
          source_of_tangent(program.uniform("source_of_tangent")),
          line_of_place(program.uniform("line_of_place")) {}
    Program program;
    GLint source_of_tangent, line_of_place;
  };

  [[nodiscard]] const Pass& pass_of(const WarpMesh& mesh) const {
    if (mesh.kind() == WarpMesh::Kind::seen) return seen_;
    return mesh.is_per_colour() ? per_colour_ : one_colour_;
  }

  Context* context_;
  Pass one_colour_, per_colour_, seen_;
};

}  // namespace holdfast::rendering
