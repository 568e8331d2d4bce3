/// OpenGL by Mesa's off-screen library: software only, no driver, no device. There only when built with OSMesa.
///
/// OSMesa wants a buffer to draw into; everything here draws into framebuffer objects, so it gets one of 16 x 16
/// pixels.
#pragma once

#include <array>
#include <cstdint>

#include <holdfast/rendering/context.hpp>

#if HOLDFAST_HAS_OSMESA
namespace holdfast::rendering {

class OsmesaContext final : public Context {
 public:
  OsmesaContext() {
    constexpr std::array<int, 13> attributes{OSMESA_FORMAT,
                                             OSMESA_RGBA,
                                             OSMESA_DEPTH_BITS,
                                             24,
                                             OSMESA_PROFILE,
                                             OSMESA_CORE_PROFILE,
                                             OSMESA_CONTEXT_MAJOR_VERSION,
                                             4,
                                             OSMESA_CONTEXT_MINOR_VERSION,
                                             5,
                                             0,
                                             0,
                                             0};
    context_ = OSMesaCreateContextAttribs(attributes.data(), nullptr);
    if (context_ == nullptr) throw ContextError("osmesa: this OSMesa gives no OpenGL 4.5 core context");
    try {
      make_current();
      load(Backend::osmesa, [](const char* name) { return reinterpret_cast<GLADapiproc>(OSMesaGetProcAddress(name)); });
    } catch (...) {
      destroy();
      throw;
    }
  }
  ~OsmesaContext() override { destroy(); }

 protected:
  void bind() override {
    if (OSMesaMakeCurrent(context_, buffer_.data(), GL_UNSIGNED_BYTE, side, side) != GL_TRUE)
      throw ContextError("osmesa: the context cannot be made current");
  }
  void unbind() override { OSMesaMakeCurrent(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0); }

 private:
  static constexpr int side = 16;

  void destroy() {
    release_current();
    OSMesaDestroyContext(context_);
  }

  OSMesaContext context_ = nullptr;
  std::array<std::uint8_t, 4 * side * side> buffer_{};
};

}  // namespace holdfast::rendering
#endif
