#version 450 core
// See depth_mesh.vert. `picture` is the rendered picture: linear filter, clamped to its edge. Draw once for all colours, or, for
// a lens that bends them differently, once for each with the others masked. Alpha: 1 covered, 1/2 disoccluded; what no triangle
// reaches keeps what the target was cleared to.
noperspective in vec3 source;
flat in float state;
layout(binding = 0) uniform sampler2D picture;
out vec4 result;

void main() { result = vec4(textureLod(picture, source.xy / source.z, 0.0).rgb, state); }
