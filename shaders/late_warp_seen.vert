#version 450 core
// What the eye sees of a late-warped picture through the lens, for experiments and pictures: late_warp.vert explains the uniforms.
// The mesh lies over the picture that is seen instead of over the panel's. Each colour comes from a place of the panel of its own,
// which gives the line that lights it, and shows there the tangent of the ideal picture.
layout(location = 0) in vec2 place;  // of the seen picture
layout(location = 1) in vec2 tangent_red;
layout(location = 2) in vec2 tangent_green;
layout(location = 3) in vec2 tangent_blue;
layout(location = 4) in vec2 panel_red;
layout(location = 5) in vec2 panel_green;
layout(location = 6) in vec2 panel_blue;
uniform mat3 source_of_tangent[3];
uniform vec3 line_of_place;  // of the panel
noperspective out vec3 source_red, source_green, source_blue;
noperspective out vec2 from_middle_red, from_middle_green, from_middle_blue;  // of the panel: on it where |x| and |y| <= 1

vec3 source_of(vec2 tangent, vec2 panel) {
  float s = dot(line_of_place, vec3(panel, 1.0));
  vec3 h = (source_of_tangent[0] + s * (source_of_tangent[1] + s * source_of_tangent[2])) * vec3(tangent, 1.0);
  return vec3(h.xy - 0.5 * h.z, 0.5 * h.z);
}

void main() {
  source_red = source_of(tangent_red, panel_red);
  source_green = source_of(tangent_green, panel_green);
  source_blue = source_of(tangent_blue, panel_blue);
  from_middle_red = 2.0 * panel_red - 1.0;
  from_middle_green = 2.0 * panel_green - 1.0;
  from_middle_blue = 2.0 * panel_blue - 1.0;
  gl_Position = vec4(2.0 * place - 1.0, 0.0, 1.0);
}
