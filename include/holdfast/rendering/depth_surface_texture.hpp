/// The surface that a rendered picture's depth describes, in GPU memory: what the depth warps look for.
///
/// The same facets and links as DepthSurface (deflection/depth_surface.hpp) has on the CPU, made by
/// shaders/depth_facets.frag from the depth buffer of the target that was drawn, without a way back to the CPU; or from
/// a DepthImage. It keeps the view of the picture it came from, which the passes compare with that of the colours. Made
/// for one size; update() allocates nothing. Leaves depth test, blending and culling off, and another target bound.
/// Bad input: a picture of another size, or a DepthImage that is none, throws RenderingError.
#pragma once

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include <holdfast/deflection/depth_image.hpp>
#include <holdfast/deflection/rendered_picture.hpp>
#include <holdfast/rendering/program.hpp>
#include <holdfast/rendering/render_target.hpp>
#include <holdfast/rendering/shaders.hpp>

namespace holdfast::rendering {

namespace detail {

/// A texture without filter, and the framebuffer that draws into it.
struct DataTarget {
  DataTarget(Context& context, GLenum format, int columns, int rows)
      : width(columns), height(rows), texture(make_texture(context, GL_TEXTURE_2D)) {
    const GlFunctions& gl = context.gl();
    gl.TextureStorage2D(texture.id(), 1, format, width, height);
    gl.TextureParameteri(texture.id(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TextureParameteri(texture.id(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    throw_gl_error(gl, "making a texture of " + std::to_string(width) + " x " + std::to_string(height));
  }
  int width, height;
  GlObject texture;
};

/// One framebuffer for one or two of them.
[[nodiscard]] inline GlObject framebuffer_of(Context& context, std::initializer_list<const DataTarget*> targets) {
  GlObject framebuffer = make_framebuffer(context);
  const GlFunctions& gl = context.gl();
  GLenum buffers[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  GLenum attachment = GL_COLOR_ATTACHMENT0;
  for (const DataTarget* target : targets)
    gl.NamedFramebufferTexture(framebuffer.id(), attachment++, target->texture.id(), 0);
  gl.NamedFramebufferDrawBuffers(framebuffer.id(), static_cast<GLsizei>(targets.size()), buffers);
  if (gl.CheckNamedFramebufferStatus(framebuffer.id(), GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw RenderingError("the driver refuses to draw into 32-bit float textures");
  return framebuffer;
}

/// Makes all of a data framebuffer the target of what is drawn next, as numbers: no blending, no tests.
inline void bind_data(Context& context, const GlObject& framebuffer, int width, int height) {
  context.make_current();
  const GlFunctions& gl = context.gl();
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
  gl.Viewport(0, 0, width, height);
  gl.Disable(GL_SCISSOR_TEST);
  gl.Disable(GL_DEPTH_TEST);
  gl.Disable(GL_BLEND);
  gl.Disable(GL_CULL_FACE);
  gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

}  // namespace detail

class DepthSurfaceTexture {
 public:
  /// link_tolerance: as DepthSurface's.
  DepthSurfaceTexture(Context& context, PixelSize size, double link_tolerance = 0.01)
      : context_(&context),
        facets_program_(context, shaders::full_screen_vert, shaders::depth_facets_frag),
        extremes_program_(context, shaders::full_screen_vert, shaders::depth_extremes_frag),
        no_vertices_(make_vertex_array(context)),
        facets_(context, GL_RGBA32F, size.width, size.height),
        uploaded_(context, GL_R32F, size.width, size.height) {
    levels_.push_back({detail::DataTarget(context, GL_RG32F, size.width, size.height), {}});
    framebuffer_ = detail::framebuffer_of(context, {&facets_, &levels_[0].values});
    while (levels_.size() < 2 || levels_.back().values.width > 1 || levels_.back().values.height > 1) {
      const detail::DataTarget& last = levels_.back().values;
      detail::DataTarget next(context, GL_RG32F, (last.width + 15) / 16, (last.height + 15) / 16);
      GlObject framebuffer = detail::framebuffer_of(context, {&next});
      levels_.push_back({std::move(next), std::move(framebuffer)});
    }
    facets_program_.set(facets_program_.uniform("link_tolerance"), static_cast<float>(link_tolerance));
    inverse_distance_ = facets_program_.uniform("inverse_distance");
    nothing_ = facets_program_.uniform("nothing");
  }

  /// From the depth buffer of a picture drawn with `projection` (the matrix of the view's tangents) and `range`.
  void update(const RenderedPicture<RenderTarget*>& drawn, const ClipPlanes& clip,
              DepthRange range = DepthRange::minus_one_to_one) {
    RenderTarget& target = *drawn.picture();
    require_size({target.width(), target.height()});
    require_size(drawn.view().size);
    target.resolve_depth();
    const Matrix4 P = projection_matrix(drawn.view().tangents, clip, range);
    const double from_clip = range == DepthRange::minus_one_to_one ? 2.0 : 1.0;
    const Vector2 w_of_value((P(2, 2) - (from_clip - 1.0)) / P(2, 3), from_clip / P(2, 3));
    find_facets(drawn.view(), target.depth_texture(), w_of_value, range == DepthRange::one_to_zero ? 0.0f : 1.0f);
  }

  /// From distances in memory.
  void update(const RenderedPicture<DepthImage>& image) {
    const DepthImage& depth = image.picture();
    if (const DepthProblem problem = problem_of(depth); problem != DepthProblem::none)
      throw RenderingError("no depth image: " + std::string(describe(problem)));
    require_size(depth.size);
    inverse_.resize(depth.distance_m.size());
    for (std::size_t i = 0; i < inverse_.size(); ++i)
      inverse_[i] = depth.distance_m[i] > 0.0f ? 1.0f / depth.distance_m[i] : 0.0f;
    context_->make_current();
    context_->gl().TextureSubImage2D(uploaded_.texture.id(), 0, 0, 0, depth.size.width, depth.size.height, GL_RED,
                                     GL_FLOAT, inverse_.data());
    find_facets(image.view(), uploaded_.texture.id(), Vector2(0.0, 1.0), 0.0f);
  }

  [[nodiscard]] PixelSize size() const { return {facets_.width, facets_.height}; }
  /// Of the picture that the depth belongs to.
  [[nodiscard]] const RenderedView& view() const { return view_; }
  /// Pixel of the depth = (t_S - (x, y)) .* (z, w), for shaders.
  [[nodiscard]] Vector4 pixel_of_tangent() const {
    const FieldTangents& t = view_.tangents;
    return {t.left, t.down, facets_.width / (t.right - t.left), facets_.height / (t.up - t.down)};
  }
  [[nodiscard]] GLuint facets_texture() const { return facets_.texture.id(); }
  /// Greatest inverse distance and step, of each block of 16 x 16 pixels and of all.
  [[nodiscard]] GLuint blocks_texture() const { return levels_[1].values.texture.id(); }
  [[nodiscard]] GLuint greatest_texture() const { return levels_.back().values.texture.id(); }

 private:
  struct Level {
    detail::DataTarget values;
    GlObject framebuffer;
  };

  void require_size(PixelSize size) const {
    if (size == this->size()) return;
    throw RenderingError("a depth of " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                         " pixels for a surface of " + std::to_string(facets_.width) + " x " +
                         std::to_string(facets_.height));
  }

  void find_facets(const RenderedView& view, GLuint depth, const Vector2& w_of_value, float nothing) {
    view_ = view;
    const GlFunctions& gl = context_->gl();
    facets_program_.set(inverse_distance_, w_of_value);
    facets_program_.set(nothing_, nothing);
    facets_program_.use();
    gl.BindVertexArray(no_vertices_.id());
    gl.BindTextureUnit(0, depth);
    detail::bind_data(*context_, framebuffer_, facets_.width, facets_.height);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    extremes_program_.use();
    for (std::size_t i = 1; i < levels_.size(); ++i) {
      gl.BindTextureUnit(0, levels_[i - 1].values.texture.id());
      detail::bind_data(*context_, levels_[i].framebuffer, levels_[i].values.width, levels_[i].values.height);
      gl.DrawArrays(GL_TRIANGLES, 0, 3);
    }
  }

  Context* context_;
  Program facets_program_, extremes_program_;
  GlObject no_vertices_;
  detail::DataTarget facets_, uploaded_;
  std::vector<Level> levels_;  // each the extremes of blocks of the one before
  GlObject framebuffer_;       // facets_ and levels_[0]
  GLint inverse_distance_ = -1, nothing_ = -1;
  RenderedView view_;
  std::vector<float> inverse_;
};

}  // namespace holdfast::rendering
