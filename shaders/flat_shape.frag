#version 450 core
// Discs, rectangles and checkerboards with exact edges: how much of the pixel's square lies inside the outline is computed from
// the outline's distance and direction, not sampled. Measured centroids and lines are then good to thousandths of a pixel.
// Two pixels round the outline get the shape's depth, with no colour: a late warp by depth then moves all of a soft edge with the
// shape, to where a linear look-up fades out. Cut at the outline's last pixel it would be off by a part of a pixel in each row.
uniform mat3 plane_of_pixel;  // H: pixel (x, y, 1) -> (u, v, 1) / distance, with (u, v) the shape's own coordinates
uniform int kind;             // 0 disc u^2 + v^2 < 1; 1 rectangle 0 < u, v < 1; 2 board: cells of side 1, 0 < (u, v) < cells
uniform vec2 cells;           // kind 2
uniform vec3 colour;          // kind 2: of the cell at (0, 0)
uniform vec3 other_colour;    // kind 2: of its neighbours
out vec4 result;

// The outline's lines are written with homogeneous plane coordinates q = (u, v, 1) / distance, which are linear over the picture:
// u > 0 is q.x > 0, u < 1 is q.z - q.x > 0, and so on. That holds at the plane's horizon and behind the eye too.
vec3 q;
vec2 gu, gv, gw;  // gradients of q's members, per pixel

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

const float rim_px = 2.0;

// Pixels to the line where f = 0, positive inside.
float pixels_inside(float f, vec2 g) { return f / max(length(g), 1e-15); }
float pixels_inside_rectangle(vec2 size) {
  return min(min(pixels_inside(q.x, gu), pixels_inside(size.x * q.z - q.x, size.x * gw - gu)),
             min(pixels_inside(q.y, gv), pixels_inside(size.y * q.z - q.y, size.y * gw - gv)));
}

float rectangle(vec2 size) {
  float across = inside(q.x, gu) + inside(size.x * q.z - q.x, size.x * gw - gu) - 1.0;
  float along = inside(q.y, gv) + inside(size.y * q.z - q.y, size.y * gw - gv) - 1.0;
  return max(across, 0.0) * max(along, 0.0);
}

// +1 in even cells, -1 in odd ones, and the area-weighted mean in pixels that a cell's border crosses. x is q.x or q.y.
float stripes(float x, vec2 gradient) {
  float border = round(x / q.z);
  float above = inside(x - border * q.z, gradient - border * gw);
  float sign_above = mod(border, 2.0) < 0.5 ? 1.0 : -1.0;
  return sign_above * (2.0 * above - 1.0);
}

void main() {
  q = plane_of_pixel * vec3(gl_FragCoord.xy, 1.0);
  gu = vec2(plane_of_pixel[0].x, plane_of_pixel[1].x);
  gv = vec2(plane_of_pixel[0].y, plane_of_pixel[1].y);
  gw = vec2(plane_of_pixel[0].z, plane_of_pixel[1].z);

  float coverage, distance_px;
  vec3 shade = colour;
  if (kind == 0) {
    float radius = max(length(q.xy), 1e-20);
    vec2 gradient = gw - (q.x * gu + q.y * gv) / radius;
    coverage = inside(q.z - radius, gradient);
    distance_px = pixels_inside(q.z - radius, gradient);
  } else if (kind == 1) {
    coverage = rectangle(vec2(1.0));
    distance_px = pixels_inside_rectangle(vec2(1.0));
  } else {
    coverage = rectangle(cells);
    distance_px = pixels_inside_rectangle(cells);
    shade = mix(other_colour, colour, 0.5 + 0.5 * stripes(q.x, gu) * stripes(q.y, gv));
  }
  if (coverage <= 0.0 && (distance_px < -rim_px || q.z <= 0.0)) discard;
  result = vec4(shade, coverage);
}
