/// The ways to an OpenGL context without a window, both first class:
///   osmesa  Mesa's off-screen library: software, needs no driver and no device (Mesa dropped it in version 25.1)
///   egl     EGL on the surfaceless platform: the machine's GPU when it has one, else Mesa's software rasteriser
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace holdfast::rendering {

enum class Backend { osmesa, egl };

[[nodiscard]] constexpr std::string_view backend_name(Backend backend) {
  return backend == Backend::osmesa ? "osmesa" : "egl";
}

/// "osmesa" or "egl"; nothing for any other word.
[[nodiscard]] constexpr std::optional<Backend> parse_backend(std::string_view name) {
  if (name == "osmesa") return Backend::osmesa;
  if (name == "egl") return Backend::egl;
  return std::nullopt;
}

/// The backends this program was built with, the preferred one first.
[[nodiscard]] inline std::vector<Backend> built_backends() {
  std::vector<Backend> backends;
#if HOLDFAST_HAS_OSMESA
  backends.push_back(Backend::osmesa);
#endif
#if HOLDFAST_HAS_EGL
  backends.push_back(Backend::egl);
#endif
  return backends;
}

/// "osmesa, egl" (for messages and --help).
[[nodiscard]] inline std::string built_backend_names() {
  std::string names;
  for (const Backend backend : built_backends()) {
    if (!names.empty()) names += ", ";
    names += backend_name(backend);
  }
  return names;
}

}  // namespace holdfast::rendering
