#version 450 core
// Late warp by depth, backward: the ray of each pixel is followed through the surface of the rendered picture's depth
// (depth_facets.frag), lens and scan lines included. holdfast/deflection/depth_search.hpp is the same on the CPU and says why. In
// the rendered picture the ray appears at inverse distance w at t_S(w) = t_inf + w (o.xy + o.z t_inf), a straight line: it is
// walked pixel by pixel, w falling from that of the nearest thing to 0. It ends where it passes from before a linked surface to
// behind it. Where it passes behind an edge instead, it is hidden from the rendering eye; if it ends so, the pixel is
// disoccluded, and shows the farthest surface beside such an edge, a pixel away from it.
//   picture           linear filter, clamped to its edge
//   facets            of depth_facets.frag
//   greatest, blocks  of depth_extremes.frag: its last texel, and the texels of its first step
//   tangent_of_tangent  H(s) = [0] + s [1] + s^2 [2], as in late_warp.vert, but of the turn alone, and to tangents of the rendering
//                     eye: (t_inf, 1) ~ H(s) (t_E, 1)
//   position          o(s) = [0] + s [1] + s^2 [2]: of the displayed eye, in the rendering eye's frame, m
//   depth_of_tangent  pixel of the depth buffer = (t_S - xy) * zw
//   line_of_place     as in late_warp.vert, of the panel
// Define PER_COLOUR for a lens that bends colours differently: else green's search serves all three. Alpha: 1 covered, 1/2
// disoccluded, 0 (and black) not in the rendered picture, or beyond the panel's edge; of three colours the worst.
noperspective in vec4 red, green, blue;
layout(binding = 0) uniform sampler2D picture;
layout(binding = 1) uniform sampler2D facets;
layout(binding = 2) uniform sampler2D greatest;
layout(binding = 3) uniform sampler2D blocks;
uniform mat3 tangent_of_tangent[3];
uniform vec3 position[3];
uniform vec4 depth_of_tangent;
uniform vec3 line_of_place;
out vec4 result;

float sum_of(vec2 extremes) { return extremes.x + extremes.y; }

// No surface on the line between two pixels reaches a greater w.
float greatest_between(vec2 a, vec2 b, float greatest_w) {
  ivec2 last = textureSize(blocks, 0) - 1;
  ivec2 low = clamp(ivec2(floor((min(a, b) - 0.01) / 16.0)), ivec2(0), last);
  ivec2 high = clamp(ivec2(floor((max(a, b) + 0.01) / 16.0)), ivec2(0), last);
  if ((high.x - low.x) + (high.y - low.y) > 6) return greatest_w;
  float w = 0.0;
  for (int y = low.y; y <= high.y; ++y) {
    for (int x = low.x; x <= high.x; ++x) w = max(w, sum_of(texelFetch(blocks, ivec2(x, y), 0).xy));
  }
  return w;
}

// Place in the picture (0 to 1), and its state: 1, 1/2 or 0 as alpha.
vec3 search(vec2 t_E, float s) {
  vec3 d = (tangent_of_tangent[0] + s * (tangent_of_tangent[1] + s * tangent_of_tangent[2])) * vec3(t_E, 1.0);
  if (!(d.z > 0.0)) return vec3(0.0);
  vec3 o = position[0] + s * (position[1] + s * position[2]);
  vec2 t_infinite = d.xy / d.z;
  vec2 size = vec2(textureSize(facets, 0));
  vec2 at_infinity = (t_infinite - depth_of_tangent.xy) * depth_of_tangent.zw;
  vec2 per_w = (o.xy + o.z * t_infinite) * depth_of_tangent.zw;
  float nearest_w = sum_of(texelFetch(greatest, ivec2(0), 0).xy);
  if (o.z < 0.0) nearest_w = min(nearest_w, -1.0 / o.z);  // only what is ahead of the displayed eye

  float first_w = nearest_w, last_w = 0.0;  // the part of the line inside the picture
  for (int i = 0; i < 2; ++i) {
    if (per_w[i] == 0.0) {
      if (at_infinity[i] < 0.0 || at_infinity[i] > size[i]) return vec3(0.0);
    } else {
      float a = -at_infinity[i] / per_w[i], b = (size[i] - at_infinity[i]) / per_w[i];
      first_w = min(first_w, max(a, b));
      last_w = max(last_w, min(a, b));
    }
  }
  if (!(first_w >= last_w)) return vec3(0.0);
  bool came_from_outside = first_w < nearest_w;
  // Nothing to be met before what is nearest there.
  float bound = greatest_between(at_infinity + first_w * per_w, at_infinity + last_w * per_w, nearest_w);
  first_w = max(min(first_w, bound), last_w);

  float w = first_w;
  vec2 start = at_infinity + w * per_w;
  ivec2 direction = ivec2(-sign(per_w));  // w falls
  ivec2 cell = ivec2(clamp(mix(floor(start), ceil(start) - 1.0, lessThan(direction, ivec2(0))), vec2(0.0), size - 1.0));
  bool is_before = true;  // the surface
  bool has_guess = false;
  vec3 guess = vec3(0.0);  // pixel, w
  vec3 left = vec3(0.0);   // pixel and w of the facet that was left
  int back = 0;            // link to it; 0: none was left yet
  int most_steps = int(size.x + size.y) + 2;
  for (int n = 0; n < most_steps; ++n) {
    vec4 facet = texelFetch(facets, cell, 0);
    vec3 here = vec3(vec2(cell) + 0.5, facet.x);
    vec2 border = vec2(cell + max(direction, ivec2(0)));
    vec2 crossing = vec2(direction.x == 0 ? -1e30 : (border.x - at_infinity.x) / per_w.x,
                         direction.y == 0 ? -1e30 : (border.y - at_infinity.y) / per_w.y);
    int axis = crossing.x >= crossing.y ? 0 : 1;
    float exit_w = max(min(crossing[axis], w), last_w);
    float before_in = w - facet.x - dot(facet.yz, at_infinity + w * per_w - here.xy);
    float before_out = exit_w - facet.x - dot(facet.yz, at_infinity + exit_w * per_w - here.xy);
    if (before_in < 0.0 && is_before) {
      if ((int(facet.w) & back) != 0) return vec3((at_infinity + w * per_w) / size, 1.0);
      is_before = false;
      vec3 farther = here.z < left.z ? here : left;
      if (back != 0 && (!has_guess || farther.z < guess.z)) {
        // One pixel away from the edge, if that side goes on.
        bool is_here = here.z < left.z;
        ivec2 step = ivec2(back == 1 ? -1 : back == 4 ? 1 : 0, back == 2 ? -1 : back == 8 ? 1 : 0);
        ivec2 beside = is_here ? cell : cell - step;
        int on = is_here ? (back > 2 ? back / 4 : back * 4) : back;
        bool goes_on = (int(texelFetch(facets, beside, 0).w) & on) != 0;
        if (!is_here) step = -step;
        guess = goes_on ? vec3(vec2(beside + step) + 0.5, texelFetch(facets, beside + step, 0).x) : farther;
        has_guess = true;
      }
    }
    if (before_in >= 0.0) is_before = true;
    if (is_before && before_in >= 0.0 && before_out < 0.0) {
      w += (exit_w - w) * before_in / (before_in - before_out);
      return vec3((at_infinity + w * per_w) / size, 1.0);
    }
    if (before_out >= 0.0) is_before = true;
    left = here;
    w = exit_w;
    if (exit_w <= last_w) break;
    cell[axis] += direction[axis];
    back = axis == 0 ? (direction.x > 0 ? 4 : 1) : (direction.y > 0 ? 8 : 2);
    if (cell[axis] < 0 || cell[axis] >= int(size[axis])) break;
  }
  bool leaves_picture = last_w > 0.0;
  if (is_before) return leaves_picture ? vec3(0.0) : vec3(at_infinity / size, 1.0);
  if (leaves_picture || (came_from_outside && !has_guess)) return vec3(0.0);
  return vec3(has_guess ? guess.xy / size : at_infinity / size, 0.5);
}

vec4 look_up(vec4 tangent_and_panel) {
  vec2 panel = tangent_and_panel.zw;
  if (panel != clamp(panel, 0.0, 1.0)) return vec4(0.0);
  vec3 found = search(tangent_and_panel.xy, dot(line_of_place, vec3(panel, 1.0)));
  return found.z == 0.0 ? vec4(0.0) : vec4(textureLod(picture, found.xy, 0.0).rgb, found.z);
}

void main() {
  result = look_up(green);
#ifdef PER_COLOUR
  vec4 r = look_up(red), b = look_up(blue);
  float state = min(result.a, min(r.a, b.a));
  result = state == 0.0 ? vec4(0.0) : vec4(r.r, result.g, b.b, state);
#endif
}
