#version 450 core
// As late_warp.frag, with a place of its own for red, green and blue. A colour without a place stays black; alpha is 1 where all
// three have one.
noperspective in vec3 source_red, source_green, source_blue;
layout(binding = 0) uniform sampler2D picture;
out vec4 result;

bool is_inside(vec3 source) { return max(abs(source.x), abs(source.y)) <= source.z; }
vec4 look_up(vec3 source) { return textureLod(picture, 0.5 + 0.5 * source.xy / source.z, 0.0); }

void main() {
  bool red = is_inside(source_red), green = is_inside(source_green), blue = is_inside(source_blue);
  result = vec4(red ? look_up(source_red).r : 0.0, green ? look_up(source_green).g : 0.0, blue ? look_up(source_blue).b : 0.0,
                red && green && blue ? 1.0 : 0.0);
}
