#version 450 core
// Looks each pixel up where the table says; black where it says nothing (negative).
in vec2 uv;
layout(binding = 0) uniform sampler2D picture;
layout(binding = 1) uniform sampler2DArray source_uv;  // one layer, or three: red, green, blue
uniform int layers;
out vec4 result;

vec4 look_up(int layer) {
  vec2 from = texelFetch(source_uv, ivec3(ivec2(gl_FragCoord.xy), layer), 0).xy;
  if (from.x < 0.0 || from.y < 0.0 || from.x > 1.0 || from.y > 1.0) return vec4(0.0, 0.0, 0.0, 1.0);
  return textureLod(picture, from, 0.0);
}

void main() {
  if (layers == 1) result = look_up(0);
  else result = vec4(look_up(0).r, look_up(1).g, look_up(2).b, 1.0);
}
