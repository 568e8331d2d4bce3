#version 450 core
// The greatest of each block of 16 x 16 texels. Drawn again and again, it leaves one texel: the greatest inverse distance of a
// picture and its greatest step. Their sum bounds where a search must begin (depth_search.frag), for the picture and for each
// block.
layout(binding = 0) uniform sampler2D values;
layout(location = 0) out vec2 greatest;

void main() {
  ivec2 first = 16 * ivec2(gl_FragCoord.xy);
  ivec2 end = min(first + 16, textureSize(values, 0));
  greatest = vec2(0.0);
  for (int y = first.y; y < end.y; ++y) {
    for (int x = first.x; x < end.x; ++x) greatest = max(greatest, texelFetch(values, ivec2(x, y), 0).xy);
  }
}
