/// A picture to draw into: colour RGBA8 and 32-bit float depth, with 4 samples a pixel if asked, resolved on readback.
///
/// Colours are stored as the shaders give them, without sRGB encoding, and resolving and blending average those
/// numbers: a pixel that is half covered by white on black reads 128. That makes coverage, and with it sub-pixel
/// centroids, linear in the stored value. Shaders therefore give display values. Row 0 is the bottom row. Errors:
/// RenderingError.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <holdfast/io/image.hpp>
#include <holdfast/rendering/gl_object.hpp>

namespace holdfast::rendering {

struct ClearColour {
  float r = 0, g = 0, b = 0, a = 1;
};

class RenderTarget {
 public:
  /// samples: 1, or as many as the context has (software Mesa: 4).
  RenderTarget(Context& context, int width, int height, int samples = 1)
      : context_(&context), width_(width), height_(height), samples_(samples) {
    check_arguments();
    colour_ = make_texture(context, GL_TEXTURE_2D);
    depth_ = make_texture(context, GL_TEXTURE_2D);
    resolved_ = make_framebuffer(context);
    const GlFunctions& gl = context.gl();
    gl.TextureStorage2D(colour_.id(), 1, GL_RGBA8, width, height);
    set_sampling();
    gl.TextureStorage2D(depth_.id(), 1, GL_DEPTH_COMPONENT32F, width, height);
    gl.TextureParameteri(depth_.id(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TextureParameteri(depth_.id(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl.NamedFramebufferTexture(resolved_.id(), GL_COLOR_ATTACHMENT0, colour_.id(), 0);
    gl.NamedFramebufferTexture(resolved_.id(), GL_DEPTH_ATTACHMENT, depth_.id(), 0);
    if (samples > 1) {
      samples_colour_ = make_renderbuffer(context);
      samples_depth_ = make_renderbuffer(context);
      drawn_ = make_framebuffer(context);
      gl.NamedRenderbufferStorageMultisample(samples_colour_.id(), samples, GL_RGBA8, width, height);
      gl.NamedRenderbufferStorageMultisample(samples_depth_.id(), samples, GL_DEPTH_COMPONENT32F, width, height);
      gl.NamedFramebufferRenderbuffer(drawn_.id(), GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, samples_colour_.id());
      gl.NamedFramebufferRenderbuffer(drawn_.id(), GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, samples_depth_.id());
    }
    check_complete();
  }

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] int samples() const { return samples_; }
  [[nodiscard]] Context& context() const { return *context_; }

  /// Makes the context current and this target the one drawn into: its whole area, no scissor.
  void bind() {
    context_->make_current();
    const GlFunctions& gl = context_->gl();
    gl.BindFramebuffer(GL_FRAMEBUFFER, draw_framebuffer());
    gl.Viewport(0, 0, width_, height_);
    gl.Disable(GL_SCISSOR_TEST);
  }

  /// Binds, and clears colour and depth (to the far plane of the depth range in use).
  void clear(ClearColour colour = {}, float depth = 1.0f) {
    bind();
    const GlFunctions& gl = context_->gl();
    gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    gl.DepthMask(GL_TRUE);
    const float rgba[4] = {colour.r, colour.g, colour.b, colour.a};
    gl.ClearNamedFramebufferfv(draw_framebuffer(), GL_COLOR, 0, rgba);
    gl.ClearNamedFramebufferfv(draw_framebuffer(), GL_DEPTH, 0, &depth);
  }

  /// Averages the samples; needed before colour_texture() is sampled. Nothing to do with one sample.
  void resolve() {
    context_->make_current();
    if (samples_ > 1) blit(GL_COLOR_BUFFER_BIT);
  }

  /// Takes one depth a pixel over, needed before depth_texture() is sampled. With several samples it is one of them
  /// (OpenGL leaves open which; Mesa takes the first), not their mean: depths of different surfaces must not be mixed.
  void resolve_depth() {
    context_->make_current();
    if (samples_ > 1) blit(GL_DEPTH_BUFFER_BIT);
  }

  /// The resolved picture as a texture (linear filter, clamped to its edge).
  [[nodiscard]] GLuint colour_texture() const { return colour_.id(); }
  /// The resolved depth buffer as a texture: read it texel by texel (no filter).
  [[nodiscard]] GLuint depth_texture() const { return depth_.id(); }
  [[nodiscard]] GLuint draw_framebuffer() const { return samples_ > 1 ? drawn_.id() : resolved_.id(); }

  /// Resolves and reads the picture into `image`, whose memory is reused when its size fits.
  void read_rgba(io::Image& image) {
    resolve();
    image.width = width_;
    image.height = height_;
    image.rgba.resize(4 * pixels());
    const GlFunctions& gl = context_->gl();
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, resolved_.id());
    gl.ReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, draw_framebuffer());
  }
  [[nodiscard]] io::Image read_rgba() {
    io::Image image;
    read_rgba(image);
    return image;
  }

  /// The depth buffer, bottom row first, values as stored (0 near to 1 far unless the projection turns them round).
  /// With several samples: see resolve_depth.
  void read_depth(std::vector<float>& depth) {
    resolve_depth();
    depth.resize(pixels());
    const GlFunctions& gl = context_->gl();
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, resolved_.id());
    gl.ReadPixels(0, 0, width_, height_, GL_DEPTH_COMPONENT, GL_FLOAT, depth.data());
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, draw_framebuffer());
  }
  [[nodiscard]] std::vector<float> read_depth() {
    std::vector<float> depth;
    read_depth(depth);
    return depth;
  }

 private:
  [[nodiscard]] std::size_t pixels() const {
    return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  }

  void check_arguments() const {
    const auto size = std::to_string(width_) + " x " + std::to_string(height_);
    if (width_ < 1 || height_ < 1)
      throw RenderingError("a render target of " + size + " pixels; expected at least 1 x 1");
    const int most = context_->info().max_samples;
    if (samples_ < 1 || samples_ > most)
      throw RenderingError("a render target with " + std::to_string(samples_) +
                           " samples a pixel; this OpenGL gives 1 to " + std::to_string(most));
  }

  void set_sampling() const {
    const GlFunctions& gl = context_->gl();
    gl.TextureParameteri(colour_.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl.TextureParameteri(colour_.id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl.TextureParameteri(colour_.id(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl.TextureParameteri(colour_.id(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }

  void check_complete() {
    const GlFunctions& gl = context_->gl();
    for (const GLuint framebuffer : {resolved_.id(), draw_framebuffer()}) {
      const GLenum status = gl.CheckNamedFramebufferStatus(framebuffer, GL_FRAMEBUFFER);
      if (status == GL_FRAMEBUFFER_COMPLETE) continue;
      const GLenum error = gl.GetError();
      throw RenderingError("the driver refuses a render target of " + std::to_string(width_) + " x " +
                           std::to_string(height_) + " pixels with " + std::to_string(samples_) + " samples (status " +
                           std::to_string(status) + ", " + gl_error_name(error) + ")");
    }
  }

  void blit(GLbitfield what) {
    const GlFunctions& gl = context_->gl();
    gl.Disable(GL_SCISSOR_TEST);
    gl.BlitNamedFramebuffer(drawn_.id(), resolved_.id(), 0, 0, width_, height_, 0, 0, width_, height_, what,
                            GL_NEAREST);
  }

  Context* context_;
  int width_, height_, samples_;
  GlObject colour_, depth_, samples_colour_, samples_depth_, resolved_, drawn_;
};

}  // namespace holdfast::rendering
