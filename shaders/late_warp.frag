#version 450 core
// See late_warp.vert. `picture` is the rendered picture: linear filter, clamped to its edge, no mipmaps needed.
// The result's alpha tells coverage: 1 where the rendered picture has the place, 0 (and black) where it has none.
noperspective in vec3 source;
layout(binding = 0) uniform sampler2D picture;
out vec4 result;

void main() {
  bool inside = max(abs(source.x), abs(source.y)) <= source.z;  // never when it lies behind the rendering eye: z < 0
  vec4 color = textureLod(picture, 0.5 + 0.5 * source.xy / source.z, 0.0);
  result = inside ? vec4(color.rgb, 1.0) : vec4(0.0);
}
