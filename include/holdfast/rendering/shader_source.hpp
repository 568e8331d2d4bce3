/// The text of one shader file of shaders/ and the name by which its errors are reported.
#pragma once

#include <string_view>

namespace holdfast::rendering {

struct ShaderSource {
  std::string_view name;  ///< file name, e.g. "flat_shape.frag"
  std::string_view text;  ///< GLSL
};

}  // namespace holdfast::rendering
