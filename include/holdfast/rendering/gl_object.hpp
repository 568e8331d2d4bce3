/// Ownership of one OpenGL object: freed in the context it was made in, whichever context is current then.
#pragma once

#include <utility>

#include <holdfast/rendering/context.hpp>

namespace holdfast::rendering {

class GlObject {
 public:
  using Free = void (*)(const GlFunctions&, GLuint);

  GlObject() = default;
  GlObject(Context& context, GLuint id, Free free) : context_(&context), id_(id), free_(free) {}
  GlObject(GlObject&& other) noexcept
      : context_(std::exchange(other.context_, nullptr)), id_(std::exchange(other.id_, 0)), free_(other.free_) {}
  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(context_, other.context_);
    std::swap(id_, other.id_);
    std::swap(free_, other.free_);
    return *this;
  }
  ~GlObject() {
    if (context_ == nullptr) return;
    try {
      context_->make_current();
      free_(context_->gl(), id_);
    } catch (const ContextError&) {
      // The platform took the context away; its objects are gone with it.
    }
  }

  [[nodiscard]] GLuint id() const { return id_; }

 private:
  Context* context_ = nullptr;
  GLuint id_ = 0;
  Free free_ = nullptr;
};

/// Each makes `context` current.
[[nodiscard]] inline GlObject make_texture(Context& context, GLenum target) {
  context.make_current();
  GLuint id = 0;
  context.gl().CreateTextures(target, 1, &id);
  return GlObject(context, id, [](const GlFunctions& gl, GLuint name) { gl.DeleteTextures(1, &name); });
}
[[nodiscard]] inline GlObject make_buffer(Context& context) {
  context.make_current();
  GLuint id = 0;
  context.gl().CreateBuffers(1, &id);
  return GlObject(context, id, [](const GlFunctions& gl, GLuint name) { gl.DeleteBuffers(1, &name); });
}
[[nodiscard]] inline GlObject make_vertex_array(Context& context) {
  context.make_current();
  GLuint id = 0;
  context.gl().CreateVertexArrays(1, &id);
  return GlObject(context, id, [](const GlFunctions& gl, GLuint name) { gl.DeleteVertexArrays(1, &name); });
}
[[nodiscard]] inline GlObject make_framebuffer(Context& context) {
  context.make_current();
  GLuint id = 0;
  context.gl().CreateFramebuffers(1, &id);
  return GlObject(context, id, [](const GlFunctions& gl, GLuint name) { gl.DeleteFramebuffers(1, &name); });
}
[[nodiscard]] inline GlObject make_renderbuffer(Context& context) {
  context.make_current();
  GLuint id = 0;
  context.gl().CreateRenderbuffers(1, &id);
  return GlObject(context, id, [](const GlFunctions& gl, GLuint name) { gl.DeleteRenderbuffers(1, &name); });
}

}  // namespace holdfast::rendering
