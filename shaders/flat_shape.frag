#version 450 core
// Discs, rectangles and checkerboards with exact edges: how much of the pixel's square lies inside the outline is computed from
// the outline's distance and direction, not sampled. Measured centroids and lines are then good to thousandths of a pixel.
uniform mat3 plane_of_pixel;  // H: pixel (x, y, 1) -> (u, v, 1) / distance, with (u, v) the shape's own coordinates
uniform int kind;             // 0 disc u^2 + v^2 < 1; 1 rectangle 0 < u, v < 1; 2 board: cells of side 1, 0 < (u, v) < cells
uniform vec2 cells;           // kind 2
uniform vec3 colour;          // kind 2: of the cell at (0, 0)
uniform vec3 other_colour;    // kind 2: of its neighbours
out vec4 result;

vec2 uv;      // of the pixel's centre
vec2 du, dv;  // gradients of u and v, per pixel

// Part of a unit square on the inner side of a straight line: signed distance from the square's centre to the line (positive when
// the centre is inside), unit normal of the line.
float half_plane_area(float distance_px, vec2 normal) {
  vec2 n = abs(normal);
  float a = max(n.x, n.y);
  float b = min(n.x, n.y);
  float d = abs(distance_px);
  float beyond;  // area on the other side of a line at distance d
  if (d >= 0.5 * (a + b)) beyond = 0.0;
  else if (d <= 0.5 * (a - b)) beyond = 0.5 - d / a;
  else beyond = (0.5 * (a + b) - d) * (0.5 * (a + b) - d) / (2.0 * a * b);
  return distance_px < 0.0 ? beyond : 1.0 - beyond;
}

// The same for the line where f = 0, f > 0 inside, with gradient g per pixel.
float inside(float f, vec2 g) {
  float slope = length(g);
  if (slope < 1e-15) return f < 0.0 ? 0.0 : 1.0;
  return half_plane_area(f / slope, g / slope);
}

float rectangle(vec2 size) {
  float across = inside(uv.x, du) + inside(size.x - uv.x, du) - 1.0;
  float along = inside(uv.y, dv) + inside(size.y - uv.y, dv) - 1.0;
  return max(across, 0.0) * max(along, 0.0);
}

// +1 in even cells, -1 in odd ones, and the area-weighted mean in pixels that a cell's border crosses.
float stripes(float x, vec2 gradient) {
  float border = round(x);
  float above = inside(x - border, gradient);
  float sign_above = mod(border, 2.0) < 0.5 ? 1.0 : -1.0;
  return sign_above * (2.0 * above - 1.0);
}

void main() {
  vec3 q = plane_of_pixel * vec3(gl_FragCoord.xy, 1.0);
  if (q.z <= 0.0) discard;  // behind the eye
  uv = q.xy / q.z;
  vec2 dx = (plane_of_pixel[0].xy - uv * plane_of_pixel[0].z) / q.z;
  vec2 dy = (plane_of_pixel[1].xy - uv * plane_of_pixel[1].z) / q.z;
  du = vec2(dx.x, dy.x);
  dv = vec2(dx.y, dy.y);

  float coverage;
  vec3 shade = colour;
  if (kind == 0) {
    float radius = length(uv);
    vec2 outward = radius > 0.0 ? uv / radius : vec2(1.0, 0.0);
    coverage = inside(1.0 - radius, outward.x * du + outward.y * dv);
  } else if (kind == 1) {
    coverage = rectangle(vec2(1.0));
  } else {
    coverage = rectangle(cells);
    shade = mix(other_colour, colour, 0.5 + 0.5 * stripes(uv.x, du) * stripes(uv.y, dv));
  }
  if (coverage <= 0.0) discard;
  result = vec4(shade, coverage);
}
