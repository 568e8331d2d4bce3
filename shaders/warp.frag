#version 450 core
// Looks each pixel up where the table says; black where it says nothing (negative).
in vec2 uv;
layout(binding = 0) uniform sampler2D picture;
layout(binding = 1) uniform sampler2D source_uv;
out vec4 result;

void main() {
  vec2 from = texelFetch(source_uv, ivec2(gl_FragCoord.xy), 0).xy;
  if (from.x < 0.0) result = vec4(0.0, 0.0, 0.0, 1.0);
  else result = textureLod(picture, from, 0.0);
}
