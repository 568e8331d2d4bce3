/// One pass that rearranges a picture: each pixel of the result is looked up at its own place in the source.
///
/// The places are a table in GPU memory, made once from any function of the pixel; a pixel without a place, or with one
/// outside the source, comes out black. Used for lenses (lens_pass) and any other fixed warp.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <holdfast/rendering/program.hpp>
#include <holdfast/rendering/render_target.hpp>
#include <holdfast/rendering/shaders.hpp>

namespace holdfast::rendering {

/// Where each pixel comes from, for all colours alike or for red, green and blue apart.
class WarpTable {
 public:
  /// place(pixel, colour) -> std::optional<Vector2>: the pixel of the source seen at `pixel` (centres at half
  /// integers); colour is 0, or 0, 1, 2 when `per_colour`.
  template <typename Place>
  WarpTable(Context& context, int width, int height, bool per_colour, Place&& place)
      : width_(width),
        height_(height),
        layers_(per_colour ? 3 : 1),
        texture_(make_texture(context, per_colour ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D)) {
    const GlFunctions& gl = context.gl();
    if (per_colour) gl.TextureStorage3D(id(), 1, GL_RG32F, width, height, layers_);
    if (!per_colour) gl.TextureStorage2D(id(), 1, GL_RG32F, width, height);
    gl.TextureParameteri(id(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TextureParameteri(id(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    std::vector<std::array<float, 2>> uv(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (int layer = 0; layer < layers_; ++layer) {
      std::size_t i = 0;
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x, ++i) {
          const std::optional<Vector2> from = place(Vector2(x + 0.5, y + 0.5), layer);
          const bool inside = from && from->x() >= 0.0 && from->y() >= 0.0 && from->x() <= width && from->y() <= height;
          uv[i] = inside ? std::array{static_cast<float>(from->x() / width), static_cast<float>(from->y() / height)}
                         : std::array{-1.0f, -1.0f};
          if (!inside) ++missing_;
        }
      }
      if (per_colour) gl.TextureSubImage3D(id(), 0, 0, 0, layer, width, height, 1, GL_RG, GL_FLOAT, uv.data());
      if (!per_colour) gl.TextureSubImage2D(id(), 0, 0, 0, width, height, GL_RG, GL_FLOAT, uv.data());
    }
    throw_gl_error(gl, "uploading a warp table");
  }

  [[nodiscard]] GLuint id() const { return texture_.id(); }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] int layers() const { return layers_; }
  /// Part of the picture (0 to 1) without a source.
  [[nodiscard]] double missing() const {
    return static_cast<double>(missing_) / (static_cast<double>(width_) * height_ * layers_);
  }

 private:
  int width_, height_, layers_;
  std::size_t missing_ = 0;
  GlObject texture_;
};

class WarpPass {
 public:
  explicit WarpPass(Context& context)
      : context_(&context),
        plain_(context, shaders::full_screen_vert, shaders::warp_frag),
        per_colour_(context, shaders::full_screen_vert, shaders::warp_per_colour_frag),
        no_vertices_(make_vertex_array(context)) {}

  /// Writes all of `result` from `source` (resolved here); both have the table's size.
  void draw(RenderTarget& source, const WarpTable& table, RenderTarget& result) const {
    HOLDFAST_ASSERT(source.width() == table.width() && source.height() == table.height(), "table of another size");
    HOLDFAST_ASSERT(result.width() == table.width() && result.height() == table.height(), "table of another size");
    source.resolve();
    result.bind();
    const GlFunctions& gl = context_->gl();
    gl.Disable(GL_DEPTH_TEST);
    gl.Disable(GL_BLEND);
    gl.Disable(GL_CULL_FACE);
    (table.layers() == 1 ? plain_ : per_colour_).use();
    gl.BindTextureUnit(0, source.colour_texture());
    gl.BindTextureUnit(1, table.id());
    gl.BindVertexArray(no_vertices_.id());
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
  }

 private:
  Context* context_;
  Program plain_, per_colour_;
  GlObject no_vertices_;
};

}  // namespace holdfast::rendering
