/// What rendering throws: no context to be had, a shader that does not compile, a texture or target that the driver
/// refuses.
#pragma once

#include <stdexcept>
#include <string>

#include <holdfast/rendering/gl_functions.hpp>

namespace holdfast::rendering {

class RenderingError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

[[nodiscard]] inline const char* gl_error_name(GLenum error) {
  switch (error) {
    case GL_INVALID_ENUM:
      return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE:
      return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION:
      return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
      return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_OUT_OF_MEMORY:
      return "GL_OUT_OF_MEMORY";
    default:
      return "unknown OpenGL error";
  }
}

/// Throws when OpenGL has reported an error since the last call. Not for hot loops: glGetError may wait for the GPU.
inline void throw_gl_error(const GlFunctions& gl, const std::string& doing) {
  const GLenum error = gl.GetError();
  if (error == GL_NO_ERROR) return;
  while (gl.GetError() != GL_NO_ERROR) {
  }
  throw RenderingError("OpenGL failed while " + doing + ": " + gl_error_name(error));
}

}  // namespace holdfast::rendering
