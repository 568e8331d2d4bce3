#version 450 core
// As warp.frag, with a place of its own for red, green and blue (one layer of the table each).
in vec2 uv;
layout(binding = 0) uniform sampler2D picture;
layout(binding = 1) uniform sampler2DArray source_uv;
out vec4 result;

vec4 look_up(int layer) {
  vec2 from = texelFetch(source_uv, ivec3(ivec2(gl_FragCoord.xy), layer), 0).xy;
  return from.x < 0.0 ? vec4(0.0) : textureLod(picture, from, 0.0);
}

void main() { result = vec4(look_up(0).r, look_up(1).g, look_up(2).b, 1.0); }
