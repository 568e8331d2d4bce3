#version 450 core
// A flat shape is drawn as the rectangle that bounds it on the screen; its true outline is found per pixel (flat_shape.frag).
uniform vec4 bounds_px;      // left, bottom, right, top
uniform vec2 size_px;        // of the picture
uniform mat3 plane_of_pixel; // H: pixel (x, y, 1) -> (u, v, 1) / distance
uniform vec2 depth_of_inverse_distance;  // z_ndc = x + y / distance: affine over the screen, so the rectangle's depth is the plane's

void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  vec2 pixel = mix(bounds_px.xy, bounds_px.zw, corner);
  float inverse_distance = (plane_of_pixel * vec3(pixel, 1.0)).z;
  gl_Position = vec4(2.0 * pixel / size_px - 1.0,
                     depth_of_inverse_distance.x + depth_of_inverse_distance.y * inverse_distance, 1.0);
}
