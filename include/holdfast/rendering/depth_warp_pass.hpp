/// The late warp by depth on the GPU, backward: each pixel's ray is followed through the depth of the rendered picture,
/// lens and scan lines included.
///
/// Definition: ComposedWarp by depth (deflection/composed_warp.hpp, deflection/depth_search.hpp); the GLSL is
/// shaders/depth_search.*. It removes the parallax of a moved eye as well as the turn, and needs no more geometry than
/// LateWarpPass: the same WarpMesh, over the panel or over what the eye sees. Alpha is the mask: 1 covered, 1/2
/// disoccluded (it was hidden when the picture was drawn; the farthest surface beside the edge fills it), 0 not in the
/// picture; count_coverage_mask counts it. DepthMeshPass is the forward way.
///
///     surface.update(picture, clip);                                  // each frame, after drawing the source
///     const DeflectionResult late = deflect({.kind = DeflectionKind::depth}, picture, late_poses);
///     warp.draw(picture, surface, panel, late.X_SE, timing, result);
///
/// Leaves depth test, blending and culling off. Bad input: sizes that do not fit, or a depth of another picture, throw
/// RenderingError.
#pragma once

#include <array>

#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/rendering/coverage_mask.hpp>
#include <holdfast/rendering/depth_surface_texture.hpp>
#include <holdfast/rendering/late_warp_pass.hpp>
#include <holdfast/rendering/warp_mesh.hpp>

namespace holdfast::rendering {

namespace detail {

inline void require_same_view(const RenderedView& picture, const RenderedView& depth) {
  const bool same = picture.X_WS.q().coeffs() == depth.X_WS.q().coeffs() && picture.X_WS.p() == depth.X_WS.p() &&
                    picture.tangents == depth.tangents;
  if (!same) throw RenderingError("the depth was drawn with another view than the picture");
}

/// Uniforms that tell a shader of the depth warps where the displayed eye is.
struct DepthUniforms {
  explicit DepthUniforms(const Program& program)
      : tangent_of_tangent(program.uniform("tangent_of_tangent")),
        position(program.uniform("position")),
        depth_of_tangent(program.uniform("depth_of_tangent")),
        line_of_place(program.uniform("line_of_place")) {}

  void set(const Program& program, const DepthSurfaceTexture& surface, const ScanPose& X_SE,
           const DisplayTiming& timing) const {
    const auto turn = [](const Rigid& X) { return Homography::rotation(X.q()).matrix(); };
    const ScanMatrices H{turn(X_SE.begin()), turn(X_SE.middle()), turn(X_SE.end())};
    program.set(tangent_of_tangent, {H.begin, H.linear(), H.quadratic()});
    program.set(position, std::array<Vector3, 3>{X_SE.begin().p(), X_SE.moved_linear(), X_SE.moved_quadratic()});
    program.set(depth_of_tangent, surface.pixel_of_tangent());
    program.set(line_of_place, line_fraction_coefficients(timing));
  }

  GLint tangent_of_tangent, position, depth_of_tangent, line_of_place;
};

}  // namespace detail

class DepthWarpPass {
 public:
  explicit DepthWarpPass(Context& context)
      : context_(&context),
        one_colour_(context, shaders::depth_search_vert, shaders::depth_search_frag),
        per_colour_(context, shaders::depth_search_vert, shaders::depth_search_frag, "PER_COLOUR"),
        one_colour_uniforms_(one_colour_),
        per_colour_uniforms_(per_colour_) {}

  /// Writes all of `result`, which has the mesh's resolution. X_SE: DeflectionResult's, for DeflectionKind::depth.
  void draw(const RenderedPicture<RenderTarget*>& source, const DepthSurfaceTexture& surface, const WarpMesh& mesh,
            const ScanPose& X_SE, const DisplayTiming& timing, RenderTarget& result) const {
    detail::require_same_view(source.view(), surface.view());
    const GlFunctions& gl = context_->gl();
    detail::begin_warp(gl, source, mesh, result);
    const Program& program = mesh.is_per_colour() ? per_colour_ : one_colour_;
    (mesh.is_per_colour() ? per_colour_uniforms_ : one_colour_uniforms_).set(program, surface, X_SE, timing);
    program.use();
    gl.BindTextureUnit(1, surface.facets_texture());
    gl.BindTextureUnit(2, surface.greatest_texture());
    gl.BindTextureUnit(3, surface.blocks_texture());
    mesh.draw();
  }

 private:
  Context* context_;
  Program one_colour_, per_colour_;
  detail::DepthUniforms one_colour_uniforms_, per_colour_uniforms_;
};

}  // namespace holdfast::rendering
