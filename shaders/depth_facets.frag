#version 450 core
// From a depth buffer to the surface that it describes: a flat facet per pixel, in inverse distance w = 1 / z over the picture,
// where planes stay flat. A facet is linked to a neighbour when w changes little between them (by link_tolerance of the nearer),
// or as it did just before or does just after; else an edge lies between them. holdfast/deflection/depth_surface.hpp is the same
// on the CPU. Draw one triangle over a target of the depth buffer's size (full_screen.vert), with two colour attachments of
// 32-bit floats.
//   inverse_distance  w = x + y * value of the depth buffer. With P the projection that filled it: depth 0..1 made of clip
//                     space -1..1: ((P22 - 1) / P23, 2 / P23); of clip space 0..1, also turned round: (P22 / P23, 1 / P23)
//   nothing           the value to which the buffer was cleared: nothing was drawn there, w = 0
layout(binding = 0) uniform sampler2D depth;
uniform vec2 inverse_distance;
uniform float nothing;
uniform float link_tolerance;
layout(location = 0) out vec4 facet;     // w, its change per pixel to the right and up, links: 1 right, 2 up, 4 left, 8 down
layout(location = 1) out vec2 extremes;  // w, greatest step to a linked neighbour: see depth_extremes.frag

float w_at(ivec2 pixel) {
  float value = texelFetch(depth, clamp(pixel, ivec2(0), textureSize(depth, 0) - 1), 0).r;
  return value == nothing ? 0.0 : max(inverse_distance.x + inverse_distance.y * value, 0.0);
}

bool goes_on(float before, float a, float b, float after) {
  float step_ab = b - a;
  float most = 0.5 * abs(step_ab);
  return abs(step_ab) <= link_tolerance * max(a, b) || abs(step_ab - (a - before)) <= most || abs(step_ab - (after - b)) <= most;
}

// Along one direction: mean step to the linked neighbours, link behind, link ahead, greatest linked step.
vec4 along(ivec2 pixel, ivec2 direction, bool has_behind, bool has_ahead) {
  float w[5];
  for (int i = -2; i <= 2; ++i) w[i + 2] = w_at(pixel + i * direction);
  bool behind = has_behind && goes_on(w[0], w[1], w[2], w[3]);
  bool ahead = has_ahead && goes_on(w[1], w[2], w[3], w[4]);
  float from = behind ? w[2] - w[1] : 0.0;
  float to = ahead ? w[3] - w[2] : 0.0;
  return vec4(behind && ahead ? 0.5 * (from + to) : from + to, behind ? 1.0 : 0.0, ahead ? 1.0 : 0.0, abs(to));
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  bvec2 has_behind = greaterThan(pixel, ivec2(0));
  bvec2 has_ahead = lessThan(pixel, textureSize(depth, 0) - 1);
  vec4 x = along(pixel, ivec2(1, 0), has_behind.x, has_ahead.x);
  vec4 y = along(pixel, ivec2(0, 1), has_behind.y, has_ahead.y);
  float w = w_at(pixel);
  facet = vec4(w, x.x, y.x, x.z + 2.0 * y.z + 4.0 * x.y + 8.0 * y.y);
  extremes = vec2(w, max(x.w, y.w));
}
