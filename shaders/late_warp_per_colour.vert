#version 450 core
// As late_warp.vert (which explains everything), for a lens that bends red, green and blue differently.
layout(location = 0) in vec2 place;
layout(location = 1) in vec2 tangent_red;
layout(location = 2) in vec2 tangent_green;
layout(location = 3) in vec2 tangent_blue;
uniform mat3 source_of_tangent[3];
uniform vec3 line_of_place;
noperspective out vec3 source_red, source_green, source_blue;

vec3 from_middle(vec3 h) { return vec3(h.xy - 0.5 * h.z, 0.5 * h.z); }

void main() {
  float s = dot(line_of_place, vec3(place, 1.0));
  mat3 H = source_of_tangent[0] + s * (source_of_tangent[1] + s * source_of_tangent[2]);
  source_red = from_middle(H * vec3(tangent_red, 1.0));
  source_green = from_middle(H * vec3(tangent_green, 1.0));
  source_blue = from_middle(H * vec3(tangent_blue, 1.0));
  gl_Position = vec4(2.0 * place - 1.0, 0.0, 1.0);
}
