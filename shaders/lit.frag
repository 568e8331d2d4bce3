#version 450 core
// Lambert's law under a sky, a ground and one lamp, all fixed in the world: real and virtual pictures of one object shade alike.
in vec3 normal_W;
in vec2 uv;
in vec4 colour;
uniform vec4 base_colour;
uniform int has_texture;
layout(binding = 0) uniform sampler2D base_texture;
uniform float alpha_cutoff;  // fragments below are left out
uniform float saturation;    // 0 grey, 1 as the material is
uniform vec3 tint;
out vec4 result;

void main() {
  vec4 material = base_colour * colour;
  if (has_texture != 0) material *= texture(base_texture, uv);
  if (material.a < alpha_cutoff) discard;
  vec3 n = dot(normal_W, normal_W) > 0.0 ? normalize(normal_W) : vec3(0.0, 1.0, 0.0);
  if (!gl_FrontFacing) n = -n;
  float lamp = max(dot(n, normalize(vec3(0.25, 0.6, 0.75))), 0.0);
  float sky = 0.5 + 0.5 * n.y;
  vec3 lit = material.rgb * (mix(0.25, 0.45, sky) + 0.6 * lamp);
  vec3 grey = vec3(dot(lit, vec3(0.2126, 0.7152, 0.0722)));
  result = vec4(mix(grey, lit, saturation) * tint, 1.0);
}
