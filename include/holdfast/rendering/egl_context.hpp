/// OpenGL by EGL on Mesa's surfaceless platform (EGL_PLATFORM_SURFACELESS_MESA). There only when built with EGL.
///
/// The EGL display is shared by all contexts of the process.
#pragma once

#include <array>
#include <string>

#include <holdfast/rendering/context.hpp>

#if HOLDFAST_HAS_EGL
namespace holdfast::rendering {
namespace detail {

[[nodiscard]] inline std::string egl_error() {
  static constexpr std::array names{"EGL_SUCCESS",       "EGL_NOT_INITIALIZED",     "EGL_BAD_ACCESS",
                                    "EGL_BAD_ALLOC",     "EGL_BAD_ATTRIBUTE",       "EGL_BAD_CONFIG",
                                    "EGL_BAD_CONTEXT",   "EGL_BAD_CURRENT_SURFACE", "EGL_BAD_DISPLAY",
                                    "EGL_BAD_MATCH",     "EGL_BAD_NATIVE_PIXMAP",   "EGL_BAD_NATIVE_WINDOW",
                                    "EGL_BAD_PARAMETER", "EGL_BAD_SURFACE"};
  const EGLint error = eglGetError();
  const auto index = static_cast<std::size_t>(error - EGL_SUCCESS);
  return index < names.size() ? names[index] : "EGL error " + std::to_string(error);
}

/// The initialised surfaceless display.
class EglDisplay {
 public:
  EglDisplay() {
    display_ = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display_ == EGL_NO_DISPLAY)
      throw ContextError("egl: no surfaceless platform here (" + egl_error() +
                         "); it needs Mesa's EGL (Debian: libegl-mesa0)");
    if (eglInitialize(display_, nullptr, nullptr) != EGL_TRUE)
      throw ContextError("egl: the surfaceless display does not start (" + egl_error() +
                         "); is a Mesa driver installed (Debian: libgl1-mesa-dri)?");
  }
  EglDisplay(const EglDisplay&) = delete;
  EglDisplay& operator=(const EglDisplay&) = delete;
  [[nodiscard]] EGLDisplay get() const { return display_; }

  /// The process's own, made at first use. It is kept to the end: to end it would take away the contexts of other users
  /// of the same platform, and to unload and load the driver for each context costs time.
  [[nodiscard]] static const EglDisplay& of_process() {
    static const EglDisplay* const display = new EglDisplay;
    return *display;
  }

 private:
  EGLDisplay display_ = EGL_NO_DISPLAY;
};

}  // namespace detail

class EglContext final : public Context {
 public:
  EglContext() : display_(detail::EglDisplay::of_process().get()) {
    if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE)
      throw ContextError("egl: the driver has no desktop OpenGL (" + detail::egl_error() + ")");
    constexpr std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (eglChooseConfig(display_, wanted.data(), &config, 1, &count) != EGL_TRUE || count == 0)
      throw ContextError("egl: no configuration with desktop OpenGL (" + detail::egl_error() + ")");
    constexpr std::array<EGLint, 7> attributes{
        EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, attributes.data());
    if (context_ == EGL_NO_CONTEXT)
      throw ContextError("egl: the driver gives no OpenGL 4.5 core context (" + detail::egl_error() + ")");
    try {
      make_current();
      load(Backend::egl, [](const char* name) { return reinterpret_cast<GLADapiproc>(eglGetProcAddress(name)); });
    } catch (...) {
      destroy();
      throw;
    }
  }
  ~EglContext() override { destroy(); }

 protected:
  void bind() override {
    eglBindAPI(EGL_OPENGL_API);  // per thread
    if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE)
      throw ContextError("egl: the context cannot be made current (" + detail::egl_error() + ")");
  }
  void unbind() override { eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT); }

 private:
  void destroy() {
    release_current();
    eglDestroyContext(display_, context_);
  }

  EGLDisplay display_;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace holdfast::rendering
#endif
