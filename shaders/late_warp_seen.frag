#version 450 core
// See late_warp_seen.vert. Black, with alpha 0, where the eye sees past the panel, or the panel shows a place that was not
// rendered, in any colour.
noperspective in vec3 source_red, source_green, source_blue;
noperspective in vec2 from_middle_red, from_middle_green, from_middle_blue;
layout(binding = 0) uniform sampler2D picture;
out vec4 result;

bool is_shown(vec3 source, vec2 from_middle) {
  return max(abs(source.x), abs(source.y)) <= source.z && max(abs(from_middle.x), abs(from_middle.y)) <= 1.0;
}
vec4 look_up(vec3 source) { return textureLod(picture, 0.5 + 0.5 * source.xy / source.z, 0.0); }

void main() {
  bool shown = is_shown(source_red, from_middle_red) && is_shown(source_green, from_middle_green) &&
               is_shown(source_blue, from_middle_blue);
  vec3 color = vec3(look_up(source_red).r, look_up(source_green).g, look_up(source_blue).b);
  result = shown ? vec4(color, 1.0) : vec4(0.0);
}
