/// A picture in GPU memory, with mipmaps, repeated beyond its edges: for the materials of models.
#pragma once

#include <algorithm>
#include <bit>

#include <holdfast/io/image.hpp>
#include <holdfast/rendering/gl_object.hpp>

namespace holdfast::rendering {

class Texture {
 public:
  /// The image's bottom row has v = 0. Precondition: the image is not empty.
  Texture(Context& context, const io::Image& image)
      : context_(&context), texture_(make_texture(context, GL_TEXTURE_2D)) {
    HOLDFAST_ASSERT(!image.empty(), "a texture needs a picture");
    const GlFunctions& gl = context.gl();
    const auto longest = static_cast<unsigned>(std::max(image.width, image.height));
    gl.TextureStorage2D(id(), static_cast<GLsizei>(std::bit_width(longest)), GL_RGBA8, image.width, image.height);
    gl.TextureSubImage2D(id(), 0, 0, 0, image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
    gl.GenerateTextureMipmap(id());
    gl.TextureParameteri(id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    gl.TextureParameteri(id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl.TextureParameteri(id(), GL_TEXTURE_WRAP_S, GL_REPEAT);
    gl.TextureParameteri(id(), GL_TEXTURE_WRAP_T, GL_REPEAT);
    throw_gl_error(gl, "uploading a texture of " + std::to_string(image.width) + " x " + std::to_string(image.height));
  }

  [[nodiscard]] GLuint id() const { return texture_.id(); }
  void bind(GLuint unit) const { context_->gl().BindTextureUnit(unit, id()); }

 private:
  Context* context_;
  GlObject texture_;
};

}  // namespace holdfast::rendering
