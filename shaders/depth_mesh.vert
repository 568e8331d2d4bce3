#version 450 core
// Late warp by depth, forward, second step: two triangles for each four neighbouring pixels of the depth buffer, drawn where
// depth_place.frag says. Draw 6 (width - 1) (height - 1) vertices without data as triangles, with depth test (less) and depth
// writing, cleared to 1. Where the surface goes on they are solid; where an edge cuts it they bridge from the nearer thing to the
// farther. A bridge that is stretched to more than stretch_limit times its area shows what was hidden: disoccluded; one that
// turned its back is hidden by what moved over it, and left out.
layout(binding = 1) uniform sampler2D facets;
layout(binding = 2) uniform sampler2D vertices;  // of depth_place.frag
layout(binding = 3) uniform sampler2D tangents;
layout(binding = 4) uniform sampler2D greatest;  // of depth_extremes.frag
uniform vec4 depth_of_tangent;
uniform float stretch_limit;
noperspective out vec3 source;  // homogeneous place in the rendered picture
flat out float state;           // 1, or 1/2 disoccluded

const ivec2 a = ivec2(0, 0), b = ivec2(1, 0), c = ivec2(1, 1), d = ivec2(0, 1);

bool linked(ivec2 pixel, int link) { return (int(texelFetch(facets, pixel, 0).w) & link) != 0; }

vec2 place_of(ivec2 pixel, ivec2 size) {
  vec2 at = mix(vec2(pixel) + 0.5, vec2(0.0), equal(pixel, ivec2(0)));
  return mix(at, vec2(size), equal(pixel, size - 1));
}

float twice_area(vec2 p[3]) {
  vec2 u = p[1] - p[0], v = p[2] - p[0];
  return u.x * v.y - u.y * v.x;
}

void main() {
  ivec2 size = textureSize(facets, 0);
  int cell_number = gl_VertexID / 6, number = gl_VertexID % 6;
  ivec2 cell = ivec2(cell_number % (size.x - 1), cell_number / (size.x - 1));
  bool second = number >= 3;
  bool bottom = linked(cell, 1), top = linked(cell + d, 1), left = linked(cell, 2), right = linked(cell + b, 2);
  // The diagonal is drawn so that a single corner that is cut off takes no more than its own triangle with it.
  bool rising = (bottom && right) || (left && top);
  bool solid = second ? (rising ? left && top : right && top) : (rising ? bottom && right : bottom && left);
  ivec2 corners[3] = second ? (rising ? ivec2[3](a, c, d) : ivec2[3](b, c, d)) : (rising ? ivec2[3](a, b, c) : ivec2[3](a, b, d));

  vec4 placed[3];
  vec2 t_E[3], t_S[3];
  bool is_drawn = true;
  for (int i = 0; i < 3; ++i) {
    ivec2 pixel = cell + corners[i];
    placed[i] = texelFetch(vertices, pixel, 0);
    is_drawn = is_drawn && placed[i].w > 0.0;
    t_E[i] = texelFetch(tangents, pixel, 0).xy;
    t_S[i] = place_of(pixel, size) / depth_of_tangent.zw;
  }
  state = 1.0;
  if (!solid) {
    float stretch = twice_area(t_E) / twice_area(t_S);
    is_drawn = is_drawn && stretch > 0.0;
    state = stretch > stretch_limit ? 0.5 : 1.0;
  }
  int k = number % 3;
  source = vec3(place_of(cell + corners[k], size) / vec2(size), 1.0) * placed[k].w;
  vec2 bound = texelFetch(greatest, ivec2(0), 0).xy;
  // From nearly the far end of the depth range (infinitely far) to its near end (twice as near as anything was).
  float z = 0.99 - placed[k].z / max(bound.x + bound.y, 1e-20);
  gl_Position = is_drawn ? vec4(2.0 * placed[k].xy - 1.0, z, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
}
