/// make_context: an OpenGL 4.5 core context of the backend asked for, or of the first built one that works here.
#pragma once

#include <memory>
#include <string>

#include <holdfast/rendering/egl_context.hpp>
#include <holdfast/rendering/osmesa_context.hpp>

namespace holdfast::rendering {

/// The new context is current in the calling thread. Throws ContextError with the reason.
[[nodiscard]] inline std::unique_ptr<Context> make_context(Backend backend) {
#if HOLDFAST_HAS_OSMESA
  if (backend == Backend::osmesa) return std::make_unique<OsmesaContext>();
#endif
#if HOLDFAST_HAS_EGL
  if (backend == Backend::egl) return std::make_unique<EglContext>();
#endif
  throw ContextError(std::string(backend_name(backend)) +
                     ": this program was built without this backend; it has: " + built_backend_names());
}

/// The first built backend that gives a context; when none does, ContextError with every reason.
[[nodiscard]] inline std::unique_ptr<Context> make_context() {
  if (built_backends().empty())
    throw ContextError("no OpenGL context: this program was built with neither OSMesa nor EGL");
  std::string reasons;
  for (const Backend backend : built_backends()) {
    try {
      return make_context(backend);
    } catch (const ContextError& error) {
      reasons += std::string(reasons.empty() ? "" : "; ") + error.what();
    }
  }
  throw ContextError("no OpenGL context: " + reasons);
}

}  // namespace holdfast::rendering
