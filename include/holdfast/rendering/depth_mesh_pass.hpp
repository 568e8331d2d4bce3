/// The late warp by depth on the GPU, forward: the rendered picture's depth as a mesh, drawn where the late eye sees it.
///
/// Definition: DepthMesh and rasterize (deflection/depth_mesh.hpp, deflection/depth_raster.hpp); the GLSL is
/// shaders/depth_place.frag and shaders/depth_mesh.*. Lens and scan lines are in the vertices' places, so that one
/// look-up is enough. A vertex per pixel: for a GPU that has triangles to spare; DepthWarpPass, which searches backward,
/// costs less on a software one. Alpha is the mask: 1 covered, 1/2 disoccluded (a surface stretched over what was hidden;
/// its colours run from the nearer thing's to the farther's), 0 not in the picture; with a lens that bends colours
/// differently it is green's. count_coverage_mask counts it. What a SeenMesh is to the backward pass,
/// PlaceTable(.., DrawnPicture::seen) is to this one, but the panel's edge does not cut it off.
///
///     const PlaceTable places(context, eye, LensMode::exact);   // once
///     surface.update(picture, clip);                            // each frame, after drawing the source
///     mesh_pass.draw(picture, surface, places, late.X_SE, timing, result);
///
/// Leaves the depth test on (less), blending and culling off. Bad input: sizes that do not fit, or a depth of another
/// picture, throw RenderingError; so does a depth of less than 2 x 2 pixels.
#pragma once

#include <holdfast/rendering/depth_surface_texture.hpp>
#include <holdfast/rendering/depth_warp_pass.hpp>
#include <holdfast/rendering/place_table.hpp>

namespace holdfast::rendering {

class DepthMeshPass {
 public:
  /// size: of the depth surfaces. stretch_limit: as DepthMesh's.
  DepthMeshPass(Context& context, PixelSize size, double stretch_limit = 2.0)
      : context_(&context),
        place_program_(context, shaders::full_screen_vert, shaders::depth_place_frag),
        mesh_program_(context, shaders::depth_mesh_vert, shaders::depth_mesh_frag),
        place_uniforms_(place_program_),
        place_of_tangent_(place_program_.uniform("place_of_tangent")),
        layer_(place_program_.uniform("layer")),
        depth_of_tangent_(mesh_program_.uniform("depth_of_tangent")),
        vertices_(context, GL_RGBA32F, size.width, size.height),
        tangents_(context, GL_RG32F, size.width, size.height),
        framebuffer_(detail::framebuffer_of(context, {&vertices_, &tangents_})),
        no_vertices_(make_vertex_array(context)) {
    if (size.width < 2 || size.height < 2) throw RenderingError("a depth mesh needs at least 2 x 2 pixels");
    mesh_program_.set(mesh_program_.uniform("stretch_limit"), static_cast<float>(stretch_limit));
  }

  /// Writes all of `result`, which has the table's resolution. X_SE: DeflectionResult's, for DeflectionKind::depth.
  void draw(const RenderedPicture<RenderTarget*>& source, const DepthSurfaceTexture& surface, const PlaceTable& places,
            const ScanPose& X_SE, const DisplayTiming& timing, RenderTarget& result) const {
    RenderTarget& picture = *source.picture();
    detail::require_pictures(source, result, places.resolution(), "the table of places");
    detail::require_same_view(source.view(), surface.view());
    if (surface.size() != PixelSize{vertices_.width, vertices_.height})
      throw RenderingError("a depth mesh for another size than the surface's");
    picture.resolve();
    result.clear({0, 0, 0, 0});
    place_uniforms_.set(place_program_, surface, X_SE, timing);
    place_program_.set(place_of_tangent_, places.entry_of_tangent());
    mesh_program_.set(depth_of_tangent_, surface.pixel_of_tangent());
    const GlFunctions& gl = context_->gl();
    gl.BindVertexArray(no_vertices_.id());
    gl.BindTextureUnit(0, picture.colour_texture());
    gl.BindTextureUnit(1, surface.facets_texture());
    gl.BindTextureUnit(3, tangents_.texture.id());
    gl.BindTextureUnit(4, surface.greatest_texture());
    const int colours = places.is_per_colour() ? 3 : 1;
    for (int colour = 0; colour < colours; ++colour) {
      place_vertices(places, colour);
      draw_mesh(result, colours == 1 ? -1 : colour);
    }
  }

 private:
  void place_vertices(const PlaceTable& places, int layer) const {
    const GlFunctions& gl = context_->gl();
    place_program_.set(layer_, layer);
    place_program_.use();
    gl.BindTextureUnit(2, places.id());
    detail::bind_data(*context_, framebuffer_, vertices_.width, vertices_.height);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
  }

  /// colour: the only one to be drawn, or -1 for all.
  void draw_mesh(RenderTarget& result, int colour) const {
    const GlFunctions& gl = context_->gl();
    const auto is_drawn = [&](int c) -> GLboolean { return colour < 0 || colour == c ? GL_TRUE : GL_FALSE; };
    result.bind();
    gl.ColorMask(is_drawn(0), is_drawn(1), is_drawn(2), is_drawn(1));
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LESS);
    gl.DepthMask(GL_TRUE);
    const float farthest = 1.0f;
    gl.ClearNamedFramebufferfv(result.draw_framebuffer(), GL_DEPTH, 0, &farthest);
    mesh_program_.use();
    gl.BindTextureUnit(2, vertices_.texture.id());
    gl.DrawArrays(GL_TRIANGLES, 0, 6 * (vertices_.width - 1) * (vertices_.height - 1));
    gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  }

  Context* context_;
  Program place_program_, mesh_program_;
  detail::DepthUniforms place_uniforms_;
  GLint place_of_tangent_, layer_, depth_of_tangent_;
  detail::DataTarget vertices_, tangents_;
  GlObject framebuffer_, no_vertices_;
};

}  // namespace holdfast::rendering
