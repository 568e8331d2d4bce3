#version 450 core
// Late warp by depth, forward, first step: where each pixel of the rendered picture is to be drawn. Draw one triangle
// (full_screen.vert) over a target of the depth buffer's size with two colour attachments of 32-bit floats; depth_mesh.* is the
// second step. holdfast/deflection/depth_mesh.hpp is the same on the CPU. A vertex is a pixel's centre, those of the border moved
// out to the picture's edge. Its line depends on where it is drawn, and that on its line: a few steps agree.
//   facets            of depth_facets.frag
//   places            one layer per colour: for a tangent t_E of the displayed eye, (xy) the place on the panel that shows it, and
//                     (zw) where to draw that: the same, or where the eye sees it; above 1e9 where there is none
//   place_of_tangent  texel of `places` = (t_E - xy) * zw
//   layer             of the colour
//   the others        as in depth_search.frag
layout(binding = 1) uniform sampler2D facets;
layout(binding = 2) uniform sampler2DArray places;
uniform mat3 tangent_of_tangent[3];
uniform vec3 position[3];
uniform vec4 depth_of_tangent;
uniform vec4 place_of_tangent;
uniform vec3 line_of_place;
uniform int layer;
layout(location = 0) out vec4 vertex;   // where to draw it (xy), inverse distance from the displayed eye, weight of its place in the
                                        // rendered picture (0: it is drawn nowhere)
layout(location = 1) out vec2 tangent;  // t_E

// Interpolated by hand: hardware does so with 8 bits.
vec4 in_table(vec2 t_E) {
  vec2 at = (t_E - place_of_tangent.xy) * place_of_tangent.zw;
  vec2 last = vec2(textureSize(places, 0).xy - 1);
  if (at != clamp(at, vec2(0.0), last)) return vec4(1e10);
  ivec2 i = min(ivec2(at), ivec2(last) - 1);
  vec2 part = at - vec2(i);
  vec4 a = texelFetch(places, ivec3(i, layer), 0), b = texelFetch(places, ivec3(i + ivec2(1, 0), layer), 0);
  vec4 c = texelFetch(places, ivec3(i + ivec2(0, 1), layer), 0), d = texelFetch(places, ivec3(i + 1, layer), 0);
  if (max(max(a.x, b.x), max(c.x, d.x)) > 1e9) return vec4(1e10);
  return mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  ivec2 size = textureSize(facets, 0);
  vec2 at = vec2(pixel) + 0.5;
  at = mix(at, vec2(0.0), equal(pixel, ivec2(0)));
  at = mix(at, vec2(size), equal(pixel, size - 1));
  vec4 facet = texelFetch(facets, pixel, 0);
  float w = max(facet.x + dot(facet.yz, at - vec2(pixel) - 0.5), 0.0);
  vec2 t_S = depth_of_tangent.xy + at / depth_of_tangent.zw;

  vertex = vec4(0.0);
  tangent = vec2(0.0);
  float s = 0.5;
  for (int i = 0; i < 8; ++i) {
    mat3 H = tangent_of_tangent[0] + s * (tangent_of_tangent[1] + s * tangent_of_tangent[2]);
    vec3 o = position[0] + s * (position[1] + s * position[2]);
    vec3 seen = vec3(t_S - w * o.xy, 1.0 + w * o.z) * H;  // H is a turn: its transpose turns back
    if (!(seen.z > 0.0)) return;
    tangent = seen.xy / seen.z;
    vec4 place = in_table(tangent);
    if (place.x > 1e9) return;
    vertex = vec4(place.zw, w / seen.z, 1.0 / seen.z);
    float next = dot(line_of_place, vec3(place.xy, 1.0));
    if (abs(next - s) < 1e-6) break;
    s = next;
  }
}
