#version 450 core
// See late_warp_seen.vert. A colour is black where the eye sees past the panel, or the panel shows a place that was not rendered;
// alpha is 1 where all three are there.
noperspective in vec3 source_red, source_green, source_blue;
noperspective in vec2 from_middle_red, from_middle_green, from_middle_blue;
layout(binding = 0) uniform sampler2D picture;
out vec4 result;

bool is_shown(vec3 source, vec2 from_middle) {
  return max(abs(source.x), abs(source.y)) <= source.z && max(abs(from_middle.x), abs(from_middle.y)) <= 1.0;
}
vec4 look_up(vec3 source) { return textureLod(picture, 0.5 + 0.5 * source.xy / source.z, 0.0); }

void main() {
  bool red = is_shown(source_red, from_middle_red);
  bool green = is_shown(source_green, from_middle_green);
  bool blue = is_shown(source_blue, from_middle_blue);
  result = vec4(red ? look_up(source_red).r : 0.0, green ? look_up(source_green).g : 0.0, blue ? look_up(source_blue).b : 0.0,
                red && green && blue ? 1.0 : 0.0);
}
