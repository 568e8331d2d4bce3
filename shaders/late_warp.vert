#version 450 core
// Late warp of one eye, from the picture that was rendered to the picture on the panel: lens, late correction and scan lines in
// one. With late_warp.frag, for a lens that bends all colours alike; late_warp_per_colour.* is the same for three colours.
//
// Draw a predistortion mesh (holdfast/optics/predistortion_mesh.hpp) over the panel's picture, without depth test and culling.
//   place          vertex on the panel's picture, 0 to 1 from its lower left
//   tangent        tangents (x / -z, y / -z) at which the eye sees that place through the lens, of the displayed eye E
//   source_of_tangent  H(s) = [0] + s [1] + s^2 [2], where s is 0 on the line that is lit first and 1 on the last, and
//                  (u, v, 1) ~ H(s) (tangent, 1) is the place in the rendered picture, 0 to 1 from its lower left. From the
//                  matrices B, M, E at s = 0, 1/2, 1 (SourceMatrices of holdfast/deflection): [0] = B, [1] = 4 M - 3 B - E,
//                  [2] = 2 B - 4 M + 2 E. A display that lights all lines at once has B = M = E.
//   line_of_place  s = dot(line_of_place, vec3(place, 1)): (0, -1, 1) top to bottom, (0, 1, 0) bottom to top, (1, 0, 0) left to
//                  right, (-1, 0, 1) right to left
// What is handed on is linear over the panel within a triangle when H is constant, so it is interpolated without error and without
// perspective (noperspective only saves time here: w is 1). When H depends on s, no triangle should span more than 1/32 of the
// lines.
layout(location = 0) in vec2 place;
layout(location = 2) in vec2 tangent;  // green's, which stands for all
uniform mat3 source_of_tangent[3];
uniform vec3 line_of_place;
noperspective out vec3 source;  // homogeneous, from the middle of the rendered picture: inside where |x| and |y| <= z

void main() {
  float s = dot(line_of_place, vec3(place, 1.0));
  vec3 h = (source_of_tangent[0] + s * (source_of_tangent[1] + s * source_of_tangent[2])) * vec3(tangent, 1.0);
  source = vec3(h.xy - 0.5 * h.z, 0.5 * h.z);
  gl_Position = vec4(2.0 * place - 1.0, 0.0, 1.0);
}
