#version 450 core
// As late_warp.frag, with a place of its own for red, green and blue. Black, with alpha 0, where any of them has none.
noperspective in vec3 source_red, source_green, source_blue;
layout(binding = 0) uniform sampler2D picture;
out vec4 result;

bool is_inside(vec3 source) { return max(abs(source.x), abs(source.y)) <= source.z; }
vec4 look_up(vec3 source) { return textureLod(picture, 0.5 + 0.5 * source.xy / source.z, 0.0); }

void main() {
  bool inside = is_inside(source_red) && is_inside(source_green) && is_inside(source_blue);
  vec3 color = vec3(look_up(source_red).r, look_up(source_green).g, look_up(source_blue).b);
  result = inside ? vec4(color, 1.0) : vec4(0.0);
}
