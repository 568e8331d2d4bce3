/// An OpenGL 4.5 core context without a window.
///
/// A context belongs to one thread at a time: make_current() binds it to the calling one, release_current() lets
/// another thread have it. Several contexts may live in one process; every object made of one (targets, textures,
/// programs) keeps a reference to it, makes it current when it is destroyed, and must not outlive it. make_context
/// (make_context.hpp) chooses the backend.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include <holdfast/rendering/backend.hpp>
#include <holdfast/rendering/gl_error.hpp>
#include <holdfast/rendering/gl_functions.hpp>

namespace holdfast::rendering {

/// No context: the backend was not built, no driver answers, or the version is too low. what() says which.
class ContextError : public RenderingError {
 public:
  using RenderingError::RenderingError;
};

struct ContextInfo {
  Backend backend = Backend::osmesa;
  std::string gl_version;   ///< e.g. "4.5 (Core Profile) Mesa 22.3.6"
  std::string gl_renderer;  ///< e.g. "llvmpipe (LLVM 15.0.6, 256 bits)"
  std::string gl_vendor;
  int major = 0;
  int minor = 0;
  int max_samples = 0;  ///< largest sample count of a multisampled target
};

class Context {
 public:
  Context() = default;
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  virtual ~Context() = default;

  /// Binds the context to the calling thread; cheap when it already is. Throws ContextError when the platform refuses,
  /// for one because another thread has the context.
  void make_current() {
    if (is_current()) return;
    bind();
    current() = id_;
  }
  /// Lets go of the context, if the calling thread has it.
  void release_current() {
    if (!is_current()) return;
    unbind();
    current() = 0;
  }
  [[nodiscard]] bool is_current() const { return current() == id_; }

  /// The OpenGL functions; call them only while the context is current.
  [[nodiscard]] const GlFunctions& gl() const { return gl_; }
  [[nodiscard]] const ContextInfo& info() const { return info_; }

 protected:
  virtual void bind() = 0;
  virtual void unbind() = 0;  ///< a backend's destructor calls release_current() before it destroys the context

  /// Called once by a backend, with the context current: fills the function table and the info, and refuses less
  /// than 4.5.
  void load(Backend backend, GLADloadfunc get_address) {
    const int version = holdfast_gladLoadGLContext(&gl_, get_address);
    const std::string name(backend_name(backend));
    if (version == 0) throw ContextError(name + ": the driver gave a context but no OpenGL functions");
    info_.backend = backend;
    info_.major = GLAD_VERSION_MAJOR(version);
    info_.minor = GLAD_VERSION_MINOR(version);
    info_.gl_version = text(GL_VERSION);
    info_.gl_renderer = text(GL_RENDERER);
    info_.gl_vendor = text(GL_VENDOR);
    if (version < GLAD_MAKE_VERSION(4, 5)) {
      throw ContextError(name + ": OpenGL 4.5 core is needed, the driver gives '" + info_.gl_version + "'");
    }
    gl_.GetIntegerv(GL_MAX_SAMPLES, &info_.max_samples);
    gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  }

 private:
  /// Number of the calling thread's context, 0 for none. A number, not an address, which a later context could have
  /// again.
  [[nodiscard]] static std::uint64_t& current() {
    static thread_local std::uint64_t id = 0;
    return id;
  }
  [[nodiscard]] static std::uint64_t next_id() {
    static std::atomic<std::uint64_t> last{0};
    return ++last;
  }
  [[nodiscard]] std::string text(GLenum key) const {
    const GLubyte* value = gl_.GetString(key);
    return value == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(value));
  }

  std::uint64_t id_ = next_id();
  GlFunctions gl_{};
  ContextInfo info_;
};

}  // namespace holdfast::rendering
